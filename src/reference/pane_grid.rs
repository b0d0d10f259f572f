//! The drops on a pane by place: which one stands where a ray meets the wet face, and which one it meets beyond.

use glam::{DVec2, DVec3, UVec2};

use super::pane::PaneCap;

/// Cells for each drop, about.
const CELLS_A_DROP: f64 = 2.0;

/// Cells of equal edge over all drops, each with those that may be over it.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    caps: Vec<PaneCap>,
    from: DVec2,
    to: DVec2,
    cell: f64,
    size: UVec2,
    /// Numbers of the drops in each cell, rising.
    cells: Vec<Vec<u32>>,
    /// Height of the highest drop.
    height: f64,
}

impl Grid {
    pub(super) fn new(caps: Vec<PaneCap>) -> Self {
        let bound = |cap: &PaneCap| (cap.at - cap.reach, cap.at + cap.reach);
        let from = caps.iter().map(|cap| bound(cap).0).fold(DVec2::INFINITY, DVec2::min);
        let to = caps.iter().map(|cap| bound(cap).1).fold(DVec2::NEG_INFINITY, DVec2::max);
        let height = caps.iter().map(|cap| cap.height).fold(0.0, f64::max);
        let extent = (to - from).max(DVec2::ZERO);
        let area = extent.element_product();
        // Drops in a line have cells along it.
        let cell = (area / (CELLS_A_DROP * caps.len() as f64).max(1.0)).sqrt();
        let cell = cell.max(1e-3 * extent.max_element()).max(f64::MIN_POSITIVE);
        let size = if caps.is_empty() { UVec2::ZERO } else { (extent / cell).as_uvec2() + 1 };
        let mut grid = Self {
            from,
            to,
            cell,
            size,
            cells: vec![Vec::new(); (size.x * size.y) as usize],
            height,
            caps: Vec::new(),
        };
        for (number, cap) in (0..).zip(&caps) {
            let (lower, upper) = (grid.cell_of(bound(cap).0), grid.cell_of(bound(cap).1));
            for y in lower.y..=upper.y {
                for x in lower.x..=upper.x {
                    grid.cells[(y * size.x + x) as usize].push(number);
                }
            }
        }
        Self { caps, ..grid }
    }

    /// The cell of a place; one beside the grid is in the nearest.
    fn cell_of(&self, place: DVec2) -> UVec2 {
        ((place - self.from) / self.cell).max(DVec2::ZERO).as_uvec2().min(self.size - 1)
    }

    fn in_cell(&self, cell: UVec2) -> impl Iterator<Item = &PaneCap> {
        let numbers = &self.cells[(cell.y * self.size.x + cell.x) as usize];
        numbers.iter().map(|&number| &self.caps[number as usize])
    }

    /// The first drop whose disc a place is in.
    pub(super) fn containing(&self, place: DVec2) -> Option<&PaneCap> {
        if place.cmplt(self.from).any() || place.cmpgt(self.to).any() || self.caps.is_empty() {
            return None;
        }
        self.in_cell(self.cell_of(place))
            .find(|cap| place.distance_squared(cap.at) < cap.radius * cap.radius)
    }

    /// The first drop that a ray from a place of the wet face meets, and the distance.
    pub(super) fn first_met(&self, place: DVec3, direction: DVec3) -> Option<(&PaneCap, f64)> {
        if self.caps.is_empty() {
            return None;
        }
        let (start, way) = (place.truncate(), direction.truncate());
        // Where it is over the grid and no higher than the highest drop.
        let (mut near, mut far) = (0.0_f64, self.height / direction.z);
        for axis in 0..2 {
            let edges = [self.from[axis] - start[axis], self.to[axis] - start[axis]];
            if way[axis] == 0.0 {
                if edges[0] > 0.0 || edges[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let [a, b] = edges.map(|edge| edge / way[axis]);
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        let mut cell = self.cell_of(start + near * way);
        let mut found: Option<(&PaneCap, f64)> = None;
        let mut at = near;
        while at <= far {
            for cap in self.in_cell(cell) {
                if let Some(distance) = cap.meet(place, direction)
                    && found.is_none_or(|(_, nearest)| distance < nearest)
                {
                    found = Some((cap, distance));
                }
            }
            // The distances at which it comes to the next column and row.
            let next = |axis: usize| {
                let edge = if way[axis] > 0.0 { cell[axis] + 1 } else { cell[axis] };
                let edge = self.from[axis] + f64::from(edge) * self.cell;
                if way[axis] == 0.0 { f64::INFINITY } else { (edge - start[axis]) / way[axis] }
            };
            let (column, row) = (next(0), next(1));
            let axis = usize::from(row < column);
            at = column.min(row);
            if found.is_some_and(|(_, nearest)| nearest < at) {
                break;
            }
            let moved = i64::from(cell[axis]) + if way[axis] > 0.0 { 1 } else { -1 };
            if !(0..i64::from(self.size[axis])).contains(&moved) {
                break;
            }
            cell[axis] = moved as u32;
        }
        found
    }
}
