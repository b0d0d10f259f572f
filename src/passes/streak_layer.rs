//! Streaks of one colour, which need no order: the lists that `glsl/include/streak_layer.glsl` has of them.
//!
//! While the shutter is open a small drop becomes a streak, thin and long: it meets many tiles, and covers little of
//! each. Most of rain is of this kind. A far drop's mean light depends on its direction alone, so streaks over one
//! another have one colour, and what is over what does not matter: of all of them a pixel needs only how much passes.
//! So `gather` enters them into lists by cells of the picture larger than tiles (a few for a streak, whatever its
//! length), and `composite` adds up their optical depths in whole units, whose sum is the same in any order. In front
//! of each larger drop it lays those that are nearer.
//!
//! A bright source is no mean colour: in a wide streak each of its images draws a line. `gather` notes the parts of such
//! streaks, `lines` adds what the two brightest images show in each pixel, of the source whose image is brightest
//! there (`glsl/lines.comp`).
//!
//! Coverage is a closed form (`streak.glsl`) whose sum over pixels is the drop's area at every size, length and angle.
//! Error: the colour is that of the pixel's direction, not of the drop's own; a drop's upper and lower half have one. Lines
//! are in front of all drops.

use std::sync::Arc;

use ash::vk;

use super::MOST_GROUPS;
use crate::Result;
use crate::abi::CELLS_PX;
use crate::gpu::sets::group;
use crate::gpu::{Buffer, Device, Memory};
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::{Lens, Motion};

/// Focus in scene units from which on discs are not expected to be smaller.
const FAR_FOCUS: f64 = 10.0;
/// Kinds of cells without a lens.
const KINDS_OF_STREAKS: usize = 4;
/// Most links for each drop in view that are provided for discs.
const MOST_LINKS_A_DROP: f64 = 256.0;
/// Links for each drop in view: one that becomes a streak of a hundred pixels has some six.
const LINKS_A_DROP: f64 = 8.0;
/// Links in any case.
const LEAST_LINKS: u64 = 1 << 18;
const LINK_BYTES: u64 = 8;
/// Links for each part of a streak that has lines; a part has as many bytes as a link.
const LINKS_A_PART: u64 = 4;
/// Most of these: a row of workgroups.
const MOST_PARTS: u64 = (MOST_GROUPS * group::LINES_COMP[0]) as u64;

/// The lists of the cells.
pub(super) struct StreakLayer {
    pub buffer: Buffer,
    /// Bytes of the cells' first links, which are reset for each frame.
    pub reset: u64,
    /// Words of those, room for links and for parts of lines, and radius in pixels of drops that have lines.
    pub in_frame: [u32; 4],
}

impl StreakLayer {
    /// Lists for tiles of so many pixels and drops in view; where they are not used, something to bind.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        plan: &FramePlan,
        (width, height): (u32, u32),
        drops: f64,
    ) -> Result<Self> {
        let has_lens = plan.lens != Lens::Pinhole;
        let is_used = (has_lens || plan.motion != Motion::Instant) && plan.splat_px > 0.0;
        // Radius of the disc that the lens makes of a far drop, or of one at half the focus.
        let blur_px = if has_lens {
            scene.view().focal_px * scene.drawn_lens() / scene.camera.focus.min(FAR_FOCUS)
        } else {
            0.0
        };
        let cells = |[x, y]: [u32; 2]| width.div_ceil(x) * height.div_ceil(y);
        let kinds = if blur_px > 0.0 { &CELLS_PX[..] } else { &CELLS_PX[..KINDS_OF_STREAKS] };
        // An even number: a link of two words is a texel.
        let heads = if is_used { kinds.iter().copied().map(cells).sum::<u32>() } else { 0 };
        let heads = heads.next_multiple_of(2);
        let reset = 4 * u64::from(heads);
        let range = u64::from(device.report.limits.max_storage_buffer_range);
        let squares = (2.0 * blur_px / 8.0 + 2.0).powi(2);
        let a_drop = if blur_px > 0.0 {
            squares.clamp(LINKS_A_DROP, MOST_LINKS_A_DROP)
        } else {
            LINKS_A_DROP
        };
        let wanted = ((a_drop * drops) as u64).max(LEAST_LINKS).saturating_mul(plan.room.into());
        let room = if is_used {
            wanted.min(range.saturating_sub(reset) / LINK_BYTES * LINKS_A_PART / (LINKS_A_PART + 1))
        } else {
            0
        };
        let room = room.min(1 << 29);
        let parts = (room / LINKS_A_PART).min(MOST_PARTS);
        let bytes = (reset + LINK_BYTES * (room + parts)).max(16);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(device, "streak layer", bytes, usage, Memory::Device)?;
        Ok(Self {
            buffer,
            reset,
            in_frame: [heads, room as u32, parts as u32, plan.line_px.to_bits()],
        })
    }
}
