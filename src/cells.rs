//! The rain's drops, cell by cell of a grid in the rain box.
//!
//! All drops fall alike, so which of them share a cell never changes: the grid moves with them. One
//! sort when the scene is made lets every frame pass over whole cells that are out of view.

use rayon::prelude::*;

use crate::rain::{Rain, start};

/// Drops that a cell should hold on average: enough that a cell's test costs little a drop, few
/// enough that cells at the edge of the view do not drag in many drops out of it.
const DROPS_A_CELL: f64 = 32.0;

/// Finest grid: 64 cells an edge, 262,144 in all.
const MAX_BITS: u32 = 6;

/// Drop indices in order of their cells.
pub struct Cells {
    /// The box has 2^bits cells an edge.
    pub bits: u32,
    /// Indices of the random drops cell by cell, then of the drops placed by hand.
    pub order: Vec<u32>,
    /// First place in `order` of each cell, of the placed drops, and of the end.
    pub first: Vec<u32>,
}

impl Cells {
    /// Sorts the drops of `rain`, and appends `placed` drops as a cell of their own.
    pub fn new(rain: Option<&Rain>, placed: u32) -> Self {
        let count = rain.map_or(0, |rain| rain.count);
        let bits = (f64::from(count) / DROPS_A_CELL).max(1.0).log2() / 3.0;
        let bits = (bits.round() as u32).clamp(1, MAX_BITS);
        let cells = 1usize << (3 * bits);
        let cell_of: Vec<u32> = rain.map_or(Vec::new(), |rain| {
            (0..count).into_par_iter().map(|index| cell(start(rain.seed, index), bits)).collect()
        });
        let mut first = vec![0u32; cells + 2];
        for cell in &cell_of {
            first[*cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            first[cell + 1] += first[cell];
        }
        first[cells + 1] = count + placed;
        let mut next = first.clone();
        let mut order = vec![0u32; (count + placed) as usize];
        for (index, cell) in (0..).zip(&cell_of) {
            let place = &mut next[*cell as usize];
            order[*place as usize] = index;
            *place += 1;
        }
        for index in count..count + placed {
            order[index as usize] = index;
        }
        Self { bits, order, first }
    }

    /// Cells in all, that of the placed drops included.
    pub fn count(&self) -> u32 {
        self.first.len() as u32 - 1
    }
}

/// Number of the cell that holds a place; x varies fastest.
fn cell(place: [u32; 3], bits: u32) -> u32 {
    let [x, y, z] = place.map(|coordinate| coordinate >> (32 - bits));
    x | y << bits | z << (2 * bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn every_drop_is_in_its_cell_once() {
        let rain = Rain {
            seed: 5,
            count: 20_000,
            half_extent: DVec3::splat(100.0),
            radius: 1.0,
            velocity: DVec3::ZERO,
        };
        let cells = Cells::new(Some(&rain), 3);
        let mut seen = cells.order.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..20_003));
        for number in 0..cells.count() - 1 {
            let (from, to) = (cells.first[number as usize], cells.first[number as usize + 1]);
            for index in &cells.order[from as usize..to as usize] {
                assert_eq!(cell(start(5, *index), cells.bits), number);
            }
        }
        assert_eq!(cells.order[20_000..], [20_000, 20_001, 20_002]);
    }
}
