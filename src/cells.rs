//! The rain's drops, cell by cell of a grid in the rain box.
//!
//! All drops fall alike, so which of them share a cell never changes: the grid moves with them. One
//! sort when the scene is made lets every frame pass over whole cells that are out of view.

use glam::DVec3;
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

    /// Where cells stand as seen from the camera, by whole edges, numbered as the cells of a grid are
    /// whose number 0 has its corner less than an edge above the camera: in `bands` parts of equal
    /// length, the farthest first. At the end the cell of the placed drops.
    ///
    /// Which cell stands there changes as rain and camera move; how far it is does not, but for the part
    /// of an edge.
    pub fn far_to_near(&self, half_extent: DVec3, bands: u32) -> Vec<u32> {
        let cells = 1u32 << (3 * self.bits);
        let (edge, mask) = (1i32 << self.bits, (1u32 << self.bits) - 1);
        let distance2 = |number: u32| {
            let along = |axis: u32| {
                let place = (number >> (axis * self.bits) & mask) as i32;
                let signed = if 2 * place >= edge { place - edge } else { place };
                // Its middle is by half an edge to one and a half above that.
                f64::from(signed + 1)
            };
            (DVec3::new(along(0), along(1), along(2)) * half_extent).length_squared()
        };
        let mut order: Vec<u32> = (0..cells).collect();
        order.par_sort_by_cached_key(|number| std::cmp::Reverse(distance2(*number).to_bits()));
        for band in order.chunks_mut(cells.div_ceil(bands) as usize) {
            // Layer by layer, but the halves, quarters … of a band with every second, fourth … layer: a
            // CPU driver's threads each take such a part, and have as many cells in view.
            band.sort_unstable_by_key(|number| {
                ((number >> (2 * self.bits)).reverse_bits(), *number)
            });
        }
        order.push(cells);
        order
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

    #[test]
    fn bands_go_from_far_to_near() {
        let rain = Rain {
            seed: 5,
            count: 20_000,
            half_extent: DVec3::new(100.0, 300.0, 50.0),
            radius: 1.0,
            velocity: DVec3::ZERO,
        };
        let grid = Cells::new(Some(&rain), 0);
        assert_eq!(grid.bits, 3);
        let order = grid.far_to_near(rain.half_extent, 5);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..=512));
        assert_eq!(order[512], 512, "the placed drops come last");
        // Whole cells from the camera's, along each axis from -3 to 4.
        let distance = |number: &u32| {
            let axis = |shift: u32| ((number >> shift & 7) as i32 + 4) % 8 - 3;
            (DVec3::new(axis(0).into(), axis(3).into(), axis(6).into()) * rain.half_extent).length()
        };
        let bands: Vec<_> = order[..512].chunks(512_usize.div_ceil(5)).collect();
        for pair in bands.windows(2) {
            let nearest = pair[0].iter().map(distance).fold(f64::INFINITY, f64::min);
            let farthest = pair[1].iter().map(distance).fold(0.0, f64::max);
            assert!(nearest >= farthest, "{nearest} before {farthest}");
        }
        // Half of a band has half of the cells before the camera, and half of those behind.
        let behind = |cells: &[u32]| cells.iter().filter(|number| **number >> 6 >= 4).count();
        let (half, all) = (behind(&bands[1][..bands[1].len() / 2]), behind(bands[1]));
        assert!(all.abs_diff(2 * half) <= all / 4, "{half} of {all}");
    }
}
