//! The drops on a pane, on the device: caps, and a grid of cells by which a ray finds those that it may meet.
//!
//! They stand still on the pane, so no camera and no picture changes them: the grid is made once, or when others arrive (`aging.rs`). Each cell has the numbers of all
//! drops whose circle, seen square on, reaches into its box, rising: a ray's drop does not depend on the order of any thread.
//! Places are from the grid's corner in float32: beside drops of 0.1 mm on a pane of 2 m they are off by a thousandth of a radius.

use std::sync::Arc;

use ash::vk;
use glam::{DVec2, DVec3, UVec2};

use crate::Result;
use crate::abi::PaneCap;
use crate::gpu::{Buffer, Device, Texel, Texels};
use crate::optics::Cap;

/// Cells for each drop, about: finer ones are entered by more drops each, coarser ones have more of them.
const CELLS_A_DROP: f64 = 8.0;
/// Most cells along an axis.
const MOST_CELLS: f64 = 4096.0;

/// What rays find of the drops.
pub(crate) struct PaneDrops {
    pub count: u32,
    /// The middles of their discs, along the pane's u and v.
    pub at: Vec<DVec2>,
    pub caps: Buffer,
    pub cells: Buffer,
    /// Of caps and of cells.
    pub texels: [Texels; 2],
    /// Place of the grid's corner on the pane, edge of a cell, cells across and down.
    pub corner: DVec2,
    pub cell: f64,
    pub size: UVec2,
    /// Height of the highest drop.
    pub tallest: f64,
    /// Least cosine of a contact angle. Rays whose sine is larger may meet a drop from outside; 2: there is no drop.
    pub overhang: f64,
}

/// The numbers of the drops in each cell of a grid, as `glsl/include/pane.glsl` has them.
struct Grid {
    corner: DVec2,
    cell: f64,
    size: UVec2,
    words: Vec<u32>,
}

impl Grid {
    fn new(caps: &[(DVec2, Cap)]) -> Self {
        let low = caps.iter().map(|(at, cap)| *at - cap.reach()).reduce(DVec2::min);
        let high = caps.iter().map(|(at, cap)| *at + cap.reach()).reduce(DVec2::max);
        let (Some(corner), Some(end)) = (low, high) else {
            let words = vec![2, 2];
            return Self { corner: DVec2::ZERO, cell: 1.0, size: UVec2::ONE, words };
        };
        let extent = end - corner;
        let by_number = (extent.element_product() / (CELLS_A_DROP * caps.len() as f64)).sqrt();
        let cell = by_number.max(extent.max_element() / MOST_CELLS);
        let size = (extent / cell).as_uvec2() + 1;
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
        Self { corner, cell, size, words }
    }
}

impl PaneDrops {
    /// Puts the drops on a pane on the device.
    ///
    /// # Errors
    /// See [`Buffer::upload_device`].
    pub fn new(device: &Arc<Device>, caps: &[(DVec2, Cap)]) -> Result<Self> {
        let Grid { corner, cell, size, words } = Grid::new(caps);
        let record = |(number, (at, cap)): (u32, &(DVec2, Cap))| PaneCap {
            at: (*at - corner).as_vec2().to_array(),
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
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let caps_on_device = Buffer::upload_device(device, "pane's drops", &records, usage)?;
        let cells = Buffer::upload_device(device, "cells of a pane", &words, usage)?;
        let texels = [
            Texels::new(device, "texels of a pane's drops", &caps_on_device, Texel::FourWords)?,
            Texels::new(device, "words of a pane's cells", &cells, Texel::Word)?,
        ];
        let cosines = caps.iter().map(|(_, cap)| cap.angle.to_radians().cos());
        Ok(Self {
            count: caps.len() as u32,
            at: caps.iter().map(|(at, _)| *at).collect(),
            caps: caps_on_device,
            cells,
            texels,
            corner,
            cell,
            size,
            tallest: caps.iter().map(|(_, cap)| cap.height()).fold(0.0, f64::max),
            overhang: cosines.fold(2.0, f64::min),
        })
    }

    /// A place on the pane as the shaders have it.
    pub fn relative(&self, place: DVec3) -> DVec3 {
        place - self.corner.extend(0.0)
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
        let Grid { corner, cell, size, words } = Grid::new(&caps);
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
}
