//! A host's drops on a pane, in a buffer of its own that it renews with each frame (`glsl/pane_cells.comp`). The device makes of them
//! what `drops.rs` makes of a scene's: caps, and the grid of cells by which rays find them. Nothing of them is read back.
//!
//! 1. Each drop becomes a cap, and is counted in each of its cells and in their rows.
//! 2. Each row of cells finds where the numbers of its cells begin, by the sums of the rows before.
//! 3. Each drop puts its number into its cells, by whichever thread comes first.
//! 4. Each drop finds its place in a cell by how many numbers there are less than its own: so the lists, and the picture, do not
//!    depend on the order of any thread.
//!
//! Nothing is read outside of the host's buffer, and nothing written outside of the room: the CPU knows how many drops that buffer
//! holds, and a cell whose numbers have no room ([`PANE_LIST`]) has none; they are counted. What is no drop is in no cell.
//!
//! Error: caps are computed in float32, and places are from a corner that the host's limits give. Both may be off by 1e-6 of
//! themselves from those of the same drops in the scene.

use std::sync::Arc;

use ash::vk;
use glam::{DVec2, UVec2};

use super::Pane;
use super::drops::{Bounds, Lattice};
use crate::abi::{PANE_LIST, PaneCellsPush};
use crate::gpu::sets::{group, pane_cells as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, fill_buffer,
    memory_barrier, shaders,
};
use crate::optics::Cap;
use crate::passes::frame::FrameBuffer;
use crate::passes::host_records::{ParticleCount, Records, Words, word};
use crate::passes::{rows_of, side_by_side};
use crate::scene::Scene;
use crate::{Error, Result};

/// Contact angles that a drop may have, in degrees.
const ANGLES: std::ops::RangeInclusive<f32> = 1.0..=170.0;

/// Drops on the pane, in a buffer on the host's device: for one frame. None may overlap another.
///
/// What holds for the buffers of [`HostParticles`](crate::renderer::HostParticles) holds for these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostPaneDrops {
    /// The buffer that they are in.
    pub buffer: vk::Buffer,
    /// Where in it the first one begins, in bytes.
    pub offset: u64,
    /// Bytes of the buffer from there on that may be read. Drops that do not fit are left out and counted.
    pub bytes: u64,
    /// Where in a drop each of its values is.
    pub layout: PaneDropLayout,
    /// How many there are.
    pub count: ParticleCount,
    /// The smallest and the largest place of a drop's middle, along u and v from the pane's point in scene units. One that is out of
    /// this box is left out and counted. The box is divided into cells, 8 for each drop that there may be: the tighter it is, the
    /// fewer drops a ray is held against.
    pub within: [DVec2; 2],
    /// The largest radius. A drop with a larger one is left out and counted.
    pub largest_radius: f32,
    /// The largest contact angle in degrees, 170 at most. A steeper drop is left out and counted, as is one of less than 1 degree.
    /// Over 90 drops overhang, so that all rays near them look for one that they meet from outside: that takes longer.
    pub largest_angle: f32,
}

/// Where in a drop its values are, in bytes from its start; multiples of 4. They are float32 of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PaneDropLayout {
    /// From one drop to the next.
    pub stride: u32,
    /// Middle of its contact disc: along u and v from the pane's point, in scene units.
    pub at: u32,
    /// Radius of its contact disc, in scene units.
    pub radius: u32,
    /// Contact angle in degrees; none: the pane's.
    pub contact_angle: Option<u32>,
}

impl HostPaneDrops {
    /// Drops of a layout, from the start of a buffer of so many bytes on; `largest`: radius, and contact angle in degrees.
    pub fn new(
        (buffer, bytes): (vk::Buffer, u64),
        layout: PaneDropLayout,
        count: ParticleCount,
        within: [DVec2; 2],
        largest: (f32, f32),
    ) -> Self {
        let (largest_radius, largest_angle) = largest;
        Self { buffer, offset: 0, bytes, layout, count, within, largest_radius, largest_angle }
    }

    fn records(&self, most: u32) -> Records {
        let Self { buffer, offset, bytes, layout, count, .. } = *self;
        let angle = layout.contact_angle.map(|at| ("contact_angle", at, 4));
        let values = [Some(("at", layout.at, 8)), Some(("radius", layout.radius, 4)), angle, None];
        let (what, stride) = ("the drops on the pane", layout.stride);
        Records { what, buffer, offset, bytes, stride, values, count, most }
    }

    /// Refuses what cannot be read.
    pub(crate) fn check(&self, device: &Device, most: u32) -> Result<()> {
        self.records(most).check(device)?;
        let Self { within: [low, high], largest_radius: radius, largest_angle: angle, .. } = self;
        let is_box = [low, high].iter().all(|corner| corner.as_vec2().is_finite());
        let is_size = radius.is_finite() && *radius > 0.0 && ANGLES.contains(angle);
        // Shaders divide by the edge of a cell.
        let has_cells = || (self.bounds(most).lattice.cell as f32).is_normal();
        if is_box && low.cmple(*high).all() && is_size && has_cells() {
            return Ok(());
        }
        let problem = format!(
            "within {low} to {high}, radius {radius}, angle {angle}: limits are finite, from the smaller to the larger, over 0 for \
             the radius, and 1 to 170 degrees for the angle"
        );
        Err(Error::scene("the drops on the pane", problem))
    }

    /// Where the drops may be, of which there may be so many, and how far they may reach.
    pub(crate) fn bounds(&self, most: u32) -> Bounds {
        let largest = Cap { radius: self.largest_radius.into(), angle: self.largest_angle.into() };
        let [low, high] = self.within;
        // What float32 holds: the device takes it from the drops' places.
        let corner = (low - largest.reach()).as_vec2().as_dvec2();
        Bounds {
            // However few there are, each is in up to a hundred cells, not in thousands.
            lattice: Lattice::new(
                corner,
                high + largest.reach(),
                most as usize,
                0.25 * largest.reach(),
            ),
            tallest: largest.height(),
            overhang: largest.angle.to_radians().cos(),
        }
    }
}

/// The passes.
pub(crate) struct PaneCells {
    bindings: Bindings,
    /// Caps and counts, starts, filling, order.
    passes: [ComputePipeline; 4],
    tallies: Buffer,
    most: u32,
}

impl PaneCells {
    /// The passes for the drops that a host gives with its frames of `scene`, of which so many may be under way.
    ///
    /// # Errors
    /// [`Error::Memory`] if the device has no room; [`Error::Limit`] if they do not fit in one binding; [`Error::Vulkan`] if the
    /// driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        pane: &Pane,
        counters: &Buffer,
        scene: &Scene,
        frames: usize,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let most = scene.host_pane_drops;
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let spans = make("cells of each drop", 16 * u64::from(most + 1), Usage::empty())?;
        let bytes = 4 * (Lattice::most_cells(most) + Lattice::MOST_ROWS);
        let tallies = make("drops of each cell", bytes, Usage::TRANSFER_DST)?;
        let bytes = 4 * u64::from(PANE_LIST) * u64::from(most);
        let unordered = make("drops of cells, in no order", bytes, Usage::empty())?;
        let drops = &pane.drops;
        let groups = drops.groups.as_ref().unwrap_or(&spans);
        let slots = [
            (slot::CONSTANTS, &frame.buffer),
            (slot::PANE_CONSTANTS, &pane.buffers.constants),
            // A frame fills these two with the host's.
            (slot::PARTICLES, &spans),
            (slot::PARTICLE_COUNT, &spans),
            (slot::PANE_CAPS, &drops.caps),
            (slot::PANE_CELLS, &drops.cells),
            (slot::PANE_SPANS, &spans),
            (slot::PANE_TALLIES, &tallies),
            (slot::PANE_UNORDERED, &unordered),
            (slot::PANE_GROUPS, groups),
            (slot::COUNTERS, counters),
        ]
        .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)));
        let bindings = Bindings::all(device, "cells of a pane", &slots, frames as u32)?;
        let shaders = [
            shaders::PANE_CELLS_COMP,
            shaders::PANE_CELLS_COMP_STARTS,
            shaders::PANE_CELLS_COMP_FILL,
            shaders::PANE_CELLS_COMP_ORDER,
        ];
        let push = size_of::<PaneCellsPush>() as u32;
        let passes = side_by_side(shaders, |shader| {
            ComputePipeline::new(device, shader, &bindings, push, &[])
        })?;
        Ok(Self { bindings, passes, tallies, most })
    }

    /// Fills a set with a frame's buffers.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the buffers live until it is no more.
    pub unsafe fn set_buffers(
        &self,
        device: &Device,
        set: usize,
        drops: &HostPaneDrops,
    ) -> Result<()> {
        let (records, slots) = (drops.records(self.most), [slot::PARTICLES, slot::PARTICLE_COUNT]);
        // SAFETY: by contract.
        unsafe { records.set_buffers(device, &self.bindings, set, slots) }
    }

    /// Records what empties the cells; a barrier to compute must follow.
    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>, drops: &HostPaneDrops) {
        let UVec2 { x, y } = drops.bounds(self.most).lattice.size;
        // The tallies of the cells, and of their rows.
        fill_buffer(device, commands, &self.tallies, 0..4 * u64::from(x * y + y), 0);
    }

    /// Records caps and cells of a frame of `scene`, whose constants are ready. A barrier must follow.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        set: usize,
        scene: &Scene,
        drops: &HostPaneDrops,
    ) {
        let HostPaneDrops { layout, within, largest_radius, largest_angle, .. } = *drops;
        let Lattice { corner, size, .. } = drops.bounds(self.most).lattice;
        let Words { start, stride, count, count_at, capacity } =
            drops.records(self.most).words(device);
        let [low, high, corner] =
            [within[0], within[1], corner].map(|place| place.as_vec2().to_array());
        let push = PaneCellsPush {
            low,
            high,
            corner,
            largest_radius,
            largest_angle,
            contact_angle: scene.pane.as_ref().map_or(0.0, |pane| pane.contact_angle as f32),
            start,
            stride,
            at: layout.at / 4,
            radius: layout.radius / 4,
            angle: word(layout.contact_angle),
            count,
            count_at,
            capacity,
            most: self.most,
        };
        let each = |drops: u32| rows_of(drops.div_ceil(group::PANE_CELLS_COMP[0]));
        // One more than there are drops: the cap that no ray meets.
        let groups = [each(self.most + 1), [size.y, 1, 1], each(self.most), each(self.most)];
        for (number, (pass, groups)) in self.passes.iter().zip(groups).enumerate() {
            if number > 0 {
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
            }
            pass.dispatch(commands, &self.bindings, set, bytemuck::bytes_of(&push), groups);
        }
    }
}
