//! Contact discs by place: a grid of cells over the pane, each with the discs whose middle is in it.

use super::Resting;

/// Edge of a cell in metres: about the diameter of the largest drops that do not slide.
const CELL: f64 = 4e-3;

/// Most cells on an axis; a wider pane has wider cells.
const MOST_CELLS: f64 = 2048.0;

/// The drops on a pane.
#[derive(Clone, Debug)]
pub(super) struct Discs {
    /// Least u and v, and the edge of a cell.
    from: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<Resting>>,
    /// The largest radius that was ever entered.
    largest: f64,
}

/// Where a disc is: its cell, and its place there.
pub(super) type Place = (usize, usize);

impl Discs {
    /// None, on a pane of [u0, v0] to [u1, v1].
    pub(super) fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let size = [to[0] - from[0], to[1] - from[1]];
        let cell = CELL.max(size[0].max(size[1]) / MOST_CELLS);
        let [columns, rows] = size.map(|edge| (edge / cell).ceil().max(1.0) as usize);
        Self { from, cell, columns, rows, cells: vec![Vec::new(); columns * rows], largest: 0.0 }
    }

    /// Columns and rows of the cells from one coordinate to another.
    fn range(&self, axis: usize, from: f64, to: f64) -> std::ops::RangeInclusive<usize> {
        let last = [self.columns, self.rows][axis] - 1;
        let index = |at: f64| (((at - self.from[axis]) / self.cell).max(0.0) as usize).min(last);
        index(from)..=index(to)
    }

    /// Enters a disc.
    pub(super) fn insert(&mut self, disc: Resting) {
        let column = *self.range(0, disc.at.x, disc.at.x).start();
        let row = *self.range(1, disc.at.y, disc.at.y).start();
        self.cells[row * self.columns + column].push(disc);
        self.largest = self.largest.max(disc.radius);
    }

    /// Takes a disc out.
    pub(super) fn remove(&mut self, (cell, place): Place) -> Resting {
        self.cells[cell].remove(place)
    }

    /// The first disc, cell by cell, that one touches.
    pub(super) fn touching(&self, disc: &Resting) -> Option<Place> {
        let reach = disc.radius + self.largest;
        let columns = self.range(0, disc.at.x - reach, disc.at.x + reach);
        for row in self.range(1, disc.at.y - reach, disc.at.y + reach) {
            for column in columns.clone() {
                let cell = row * self.columns + column;
                let touches = |other: &Resting| {
                    let both = disc.radius + other.radius;
                    (other.at - disc.at).length_squared() < both * both
                };
                if let Some(place) = self.cells[cell].iter().position(touches) {
                    return Some((cell, place));
                }
            }
        }
        None
    }

    /// The first disc that one touches on its way down to `lowest`, and its v where they touch.
    pub(super) fn below(&self, disc: &Resting, lowest: f64) -> Option<(f64, Place)> {
        let reach = disc.radius + self.largest;
        let columns = self.range(0, disc.at.x - reach, disc.at.x + reach);
        let mut first: Option<(f64, Place)> = None;
        for row in self.range(1, lowest - reach, disc.at.y + reach).rev() {
            // Discs of this row and of all below touch no higher than so.
            let highest = self.from[1] + (row + 1) as f64 * self.cell + reach;
            if first.is_some_and(|(v, _)| v > highest) && row + 1 < self.rows {
                break;
            }
            for column in columns.clone() {
                let cell = row * self.columns + column;
                for (place, other) in self.cells[cell].iter().enumerate() {
                    let (both, aside) = (disc.radius + other.radius, other.at.x - disc.at.x);
                    let rise2 = both * both - aside * aside;
                    if rise2 <= 0.0 {
                        continue;
                    }
                    let v = other.at.y + rise2.sqrt();
                    // One that is above, or touches now, is not on the way.
                    let is_on_way = other.at.y < disc.at.y && v >= lowest;
                    if is_on_way && first.is_none_or(|(highest, _)| v > highest) {
                        first = Some((v, (cell, place)));
                    }
                }
            }
        }
        first.map(|(v, place)| (v.min(disc.at.y), place))
    }

    /// All of them, cell by cell.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Resting> {
        self.cells.iter().flatten()
    }
}
