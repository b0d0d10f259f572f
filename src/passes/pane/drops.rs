//! The drops on a pane, on the device: caps, and a grid of cells by which a ray finds those that it may meet.
//!
//! They stand still on the pane, so no camera and no picture changes them: the grid is made once, or when others arrive (`aging.rs`); of
//! a host's that change with each frame it is made on the device (`host.rs`). Each cell has the numbers of all
//! drops whose circle, seen square on, reaches into its box, rising: a ray's drop does not depend on the order of any thread.
//! Places are from the grid's corner in float32: beside drops of 0.1 mm on a pane of 2 m they are off by a thousandth of a radius.

use std::sync::Arc;

use ash::vk;
use glam::{DVec2, UVec2};

use crate::Result;
use crate::abi::{PANE_LIST, PaneCap};
use crate::gpu::{Buffer, Device, Memory, Texel, Texels};
use crate::optics::Cap;

/// Cells for each drop, about: finer ones are entered by more drops each, coarser ones have more of them.
const CELLS_A_DROP: f64 = 8.0;
/// Cells along an axis, at most and without those at its end in part.
const MOST_CELLS: f64 = 4096.0;
/// What buffers are for that the passes of a pane read.
fn usage() -> vk::BufferUsageFlags {
    vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
}

/// What rays find of the drops.
pub(crate) struct PaneDrops {
    pub count: u32,
    /// The middles of their discs, along the pane's u and v.
    pub at: Vec<DVec2>,
    pub caps: Buffer,
    pub cells: Buffer,
    /// How shaders read caps and cells by texels.
    pub texels: [Texels; 2],
    pub bounds: Bounds,
    /// Groups of the dispatches over a host's drops, as the device counts them.
    pub groups: Option<Buffer>,
}

/// Where the drops are, and how far they reach.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounds {
    pub lattice: Lattice,
    /// Height of the highest drop.
    pub tallest: f64,
    /// Least cosine of a contact angle. Rays whose sine is larger may meet a drop from outside; 2: there is no drop.
    pub overhang: f64,
}

/// Place of the grid's corner on the pane, edge of a cell, cells across and down.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lattice {
    pub corner: DVec2,
    pub cell: f64,
    pub size: UVec2,
}

impl Lattice {
    /// The cells of a grid from one corner to the other, for so many drops, none smaller than `least`.
    ///
    /// Discs of the radii r that do not overlap, n at most, cover no more than its area, which is that of 8n cells of edge c: the sum of
    /// r²/c² is up to 8n/π. One is in (2r/c + 2)² cells at most, so all are in 4·8n/π + 8·(8/π)^½·n + 4n of them: 27 a drop.
    pub fn new(corner: DVec2, end: DVec2, drops: usize, least: f64) -> Self {
        let extent = end - corner;
        let by_number = (extent.element_product() / (CELLS_A_DROP * drops as f64)).sqrt();
        let cell = by_number.max(extent.max_element() / MOST_CELLS).max(least);
        Self { corner, cell, size: (extent / cell).as_uvec2() + 1 }
    }

    /// Rows of cells at most.
    pub const MOST_ROWS: u64 = MOST_CELLS as u64 + 1;

    /// How many cells there are at most for so many drops, wherever they are: with a row and a column of cells in part.
    pub fn most_cells(drops: u32) -> u64 {
        CELLS_A_DROP as u64 * u64::from(drops) + 2 * Self::MOST_ROWS
    }
}

/// The numbers of the drops in each cell of a lattice, as `glsl/include/pane.glsl` has them.
struct Grid {
    lattice: Lattice,
    words: Vec<u32>,
}

impl Grid {
    fn new(caps: &[(DVec2, Cap)]) -> Self {
        let low = caps.iter().map(|(at, cap)| *at - cap.reach()).reduce(DVec2::min);
        let high = caps.iter().map(|(at, cap)| *at + cap.reach()).reduce(DVec2::max);
        let (Some(corner), Some(end)) = (low, high) else {
            let lattice = Lattice { corner: DVec2::ZERO, cell: 1.0, size: UVec2::ONE };
            return Self { lattice, words: vec![2, 2] };
        };
        let lattice = Lattice::new(corner, end, caps.len(), 0.0);
        let Lattice { cell, size, .. } = lattice;
        let cell_of =
            |place: DVec2| ((place - corner) / cell).max(DVec2::ZERO).as_uvec2().min(size - 1);
        let mut cells = vec![Vec::new(); (size.x * size.y) as usize];
        for (number, (at, cap)) in (0..).zip(caps) {
            // Wider than the drop by more than float32 loses of places.
            let reach = cap.reach() + 1e-3 * cell;
            let (first, last) = (cell_of(at - reach), cell_of(at + reach));
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    cells[(y * size.x + x) as usize].push(number);
                }
            }
        }
        let mut begins = cells.len() as u32 + 1;
        let mut words = Vec::with_capacity(cells.len() + 1);
        for cell in &cells {
            words.push(begins);
            begins += cell.len() as u32;
        }
        words.push(begins);
        words.extend(cells.into_iter().flatten());
        Self { lattice, words }
    }
}

impl PaneDrops {
    /// Puts the drops on a pane on the device.
    ///
    /// # Errors
    /// See [`Buffer::upload_device`].
    pub fn new(device: &Arc<Device>, caps: &[(DVec2, Cap)]) -> Result<Self> {
        let Grid { lattice, words } = Grid::new(caps);
        let record = |(number, (at, cap)): (u32, &(DVec2, Cap))| PaneCap {
            at: (*at - lattice.corner).as_vec2().to_array(),
            radius: cap.radius as f32,
            reach: cap.reach() as f32,
            height: cap.height() as f32,
            sphere: cap.sphere_radius() as f32,
            center: cap.center_height() as f32,
            number,
        };
        let mut records: Vec<PaneCap> = (0..).zip(caps).map(record).collect();
        // A buffer holds one at least.
        records.resize(caps.len().max(1), PaneCap::default());
        let buffers = [
            Buffer::upload_device(device, "pane's drops", &records, usage())?,
            Buffer::upload_device(device, "cells of a pane", &words, usage())?,
        ];
        let cosines = caps.iter().map(|(_, cap)| cap.angle.to_radians().cos());
        let bounds = Bounds {
            lattice,
            tallest: caps.iter().map(|(_, cap)| cap.height()).fold(0.0, f64::max),
            overhang: cosines.fold(2.0, f64::min),
        };
        let at = caps.iter().map(|(at, _)| *at).collect();
        Self::of(device, caps.len() as u32, at, buffers, bounds)
    }

    /// Room for so many drops that each frame brings anew; none is there before.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn of_host(device: &Arc<Device>, most: u32) -> Result<Self> {
        let make = |name, bytes| Buffer::new(device, name, bytes, usage(), Memory::Device);
        // One more, which no ray meets.
        let caps =
            make("host's drops on a pane", size_of::<PaneCap>() as u64 * u64::from(most + 1))?;
        let words = Lattice::most_cells(most) + 1 + u64::from(PANE_LIST) * u64::from(most);
        let cells = make("cells of a host's pane", 4 * words)?;
        let (usage, bytes) = (usage() | vk::BufferUsageFlags::INDIRECT_BUFFER, 32);
        let groups = Buffer::new(device, "groups of looks", bytes, usage, Memory::Device)?;
        let drops = Self::of(device, most, Vec::new(), [caps, cells], Bounds::default())?;
        Ok(Self { groups: Some(groups), ..drops })
    }

    fn of(
        device: &Arc<Device>,
        count: u32,
        at: Vec<DVec2>,
        [caps, cells]: [Buffer; 2],
        bounds: Bounds,
    ) -> Result<Self> {
        let texels = [
            Texels::new(device, "texels of a pane's drops", &caps, Texel::FourWords)?,
            Texels::new(device, "words of a pane's cells", &cells, Texel::Word)?,
        ];
        Ok(Self { count, at, caps, cells, texels, bounds, groups: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell that a drop's circle meets has its number, and no number comes twice.
    #[test]
    fn cells_have_the_drops_that_reach_into_them() {
        let cap =
            |x: f64, y: f64, radius: f64, angle: f64| (DVec2::new(x, y), Cap { radius, angle });
        let caps = [cap(0.0, 0.0, 1.0, 60.0), cap(3.0, 0.5, 0.2, 100.0), cap(-1.0, 4.0, 0.7, 30.0)];
        let Grid { lattice: Lattice { corner, cell, size }, words } = Grid::new(&caps);
        let mut found = 0;
        for y in 0..size.y {
            for x in 0..size.x {
                let at = (y * size.x + x) as usize;
                let numbers = &words[words[at] as usize..words[at + 1] as usize];
                assert!(numbers.is_sorted() && numbers.windows(2).all(|two| two[0] != two[1]));
                let low = corner + cell * DVec2::new(x.into(), y.into());
                for (number, (at, cap)) in (0..).zip(&caps) {
                    let nearest = at.clamp(low, low + cell);
                    let meets = nearest.distance(*at) < cap.reach();
                    assert!(!meets || numbers.contains(&number), "{number} in {x}, {y}");
                    found += u32::from(meets);
                }
            }
        }
        assert!(found > caps.len() as u32, "{found}");
        assert_eq!(Grid::new(&[]).words, [2, 2]);
    }

    /// Discs that touch, and a large one beside them, in long boxes and in square ones.
    #[test]
    fn numbers_of_drops_side_by_side_have_room() {
        let mut most: f64 = 0.0;
        for (across, down, large) in
            [(1, 1, 1.0), (40, 30, 1.0), (40, 30, 25.0), (2000, 1, 9.0), (3, 700, 0.1)]
        {
            let place =
                |number: u32| DVec2::new((number % across).into(), (number / across).into());
            let small = |number| (2.0 * place(number), Cap { radius: 1.0, angle: 90.0 });
            let beside = (DVec2::new(-1.0 - large, 0.0), Cap { radius: large, angle: 90.0 });
            let caps: Vec<_> = (0..across * down).map(small).chain([beside]).collect();
            let Grid { lattice: Lattice { size, .. }, words } = Grid::new(&caps);
            let (drops, cells) = (caps.len() as u32, u64::from(size.x * size.y));
            assert!(cells <= Lattice::most_cells(drops), "{size} cells of {drops} drops");
            most = most.max((words.len() as f64 - cells as f64 - 1.0) / f64::from(drops));
        }
        // Nearly as many as a drop may be in, so the room is not far too large.
        assert!(most < 27.0 && most > 14.0 && most < f64::from(PANE_LIST), "{most}");
    }
}
