//! Which drops fall on which tile of the image, front to back, without touching a drop that is out
//! of view for long. Five compute passes:
//!
//! 1. `cells`: whole cells of the rain box out of view are passed over (five of six drops);
//! 2. `gather`: each drop of the other cells finds its place, its outline and its tiles of 8 x 8
//!    pixels, and takes a place in the list of each, by slab of distance;
//! 3. `tile offsets`: the lists get their room;
//! 4. `tile fill`: the drops are written into the lists;
//! 5. `tile order`: each list is sorted by distance, then drop index: a total order, so that the
//!    picture is the same on every run.
//!
//! Drops over 32 pixels, a few in a hundred thousand, are kept apart and looked at by every tile.
//!
//! No pass uses shared memory or barriers within a workgroup, poison on CPU drivers; what must be
//! counted is counted by atomics on many addresses.

use std::sync::Arc;

use ash::vk;

use super::frame::FrameBuffer;
use super::simulate::{MAX_LARGE, Simulate, placed_records};
use crate::Result;
use crate::cells::Cells;
use crate::gpu::{
    Binding, Bindings, Buffer, ComputePipeline, Device, Memory, Resource, Use, memory_barrier,
    shaders,
};
use crate::scene::Scene;

/// Edge of a tile in pixels, and slabs a tile, as in `glsl/include/tile_buffers.glsl`.
const TILE: u32 = 8;
const SLABS: u32 = 16;
/// Diameter in pixels of the largest drop that is entered into lists.
const LARGEST_PX: f32 = 32.0;
/// List entries that are provided for each drop: at the paper's sizes a drop in view touches 1.7
/// tiles, and at most a third of all drops are in view at 90°.
const ENTRIES_A_DROP: u64 = 2;
/// Entries provided in any case: a few drops that fill the image touch 20 tiles each.
const LEAST_ENTRIES: u64 = 65_536;

/// The passes and what they hand on.
pub struct Tiles {
    /// Tiles in the image.
    pub count: u32,
    /// Room for entries; the lists end there.
    pub max_entries: u32,
    /// What was counted (see [`Simulate::counts`]).
    pub counters: Buffer,
    pub(super) records: Buffer,
    pub(super) spheres: Buffer,
    pub(super) record_index: Buffer,
    pub(super) tiles: Buffer,
    pub(super) entries: Buffer,
    /// Drops over 32 pixels, nearest first.
    pub(super) large: Buffer,
    totals: Buffer,
    slabs: [Buffer; 2],
    cell_groups: u32,
    bindings: Bindings,
    cells: ComputePipeline,
    gather: ComputePipeline,
    offsets: ComputePipeline,
    fill: ComputePipeline,
    order: ComputePipeline,
    order_bindings: Bindings,
    order_large: ComputePipeline,
    // Bound, never touched from here.
    _bound: [Buffer; 8],
}

impl Tiles {
    /// Buffers and pipelines for the drops of `scene`.
    pub fn new(device: &Arc<Device>, frame: &FrameBuffer, scene: &Scene) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let grid = Cells::new(scene.rain().as_ref(), scene.drops.len() as u32);
        let count = scene.image.width.div_ceil(TILE) * scene.image.height.div_ceil(TILE);
        let range = u64::from(device.report.limits.max_storage_buffer_range);
        let drops = u64::from(scene.drop_count());
        let max_records = drops.min(range / 32) as u32;
        let max_entries = (ENTRIES_A_DROP * drops + LEAST_ENTRIES).min(range / 8) as u32;

        let storage = Usage::STORAGE_BUFFER;
        let cleared = storage | Usage::TRANSFER_DST;
        let make = |name, bytes, usage| Buffer::new(device, name, bytes, usage, Memory::Device);
        let records_of = |name, bytes: u64| make(name, bytes * u64::from(max_records), storage);
        let order = Buffer::upload_device(device, "drop order", &grid.order, storage)?;
        let first = Buffer::upload_device(device, "cells", &grid.first, storage)?;
        let visible = make("cells in view", 16 * u64::from(grid.count()), storage)?;
        let totals = make("totals", 48, cleared | Usage::INDIRECT_BUFFER)?;
        let records = records_of("drop records", 32)?;
        let spheres = records_of("drop spheres", 16)?;
        let record_index = records_of("drop indices", 4)?;
        let bins = records_of("drop bins", 16)?;
        let slab_bytes = 4 * u64::from(count) * u64::from(SLABS);
        let slabs = [
            make("small drops a slab", slab_bytes, cleared)?,
            make("wide drops a slab", slab_bytes, cleared)?,
        ];
        let tiles = make("tiles", 8 * u64::from(count), storage)?;
        let entries = make("tile entries", 8 * u64::from(max_entries), storage)?;
        let unordered = make("large drops", 16 * u64::from(MAX_LARGE), storage)?;
        let large_index = make("large drops' indices", 4 * u64::from(MAX_LARGE), storage)?;
        let large = make("large drops in order", 16 * u64::from(MAX_LARGE), storage)?;
        let arguments = make("large drops' draw", 16, storage)?;
        let placed = Buffer::upload(device, "placed drops", &placed_records(scene), storage)?;
        let counters = Simulate::counters(device)?;

        let uniform = (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer));
        let bound = [
            &order,
            &first,
            &visible,
            &totals,
            &records,
            &spheres,
            &record_index,
            &bins,
            &slabs[0],
            &slabs[1],
            &tiles,
            &entries,
            &unordered,
            &large_index,
            &placed,
            &counters,
        ];
        let slots: Vec<_> = std::iter::once(uniform)
            .chain(bound.map(|buffer| (Binding::STORAGE_BUFFER, Resource::Buffer(buffer))))
            .collect();
        let bindings = Bindings::of(device, "tiles", &slots)?;
        let pipeline = |shader, constants: &[u32]| {
            ComputePipeline::new(device, shader, &bindings, 0, constants)
        };
        let cells = pipeline(shaders::CELLS_COMP, &[grid.bits, grid.count()])?;
        let gather =
            pipeline(shaders::GATHER_COMP, &[MAX_LARGE, max_records, LARGEST_PX.to_bits()])?;
        let offsets = pipeline(shaders::TILE_OFFSETS_COMP, &[count, max_records])?;
        let fill = pipeline(shaders::TILE_FILL_COMP, &[max_entries, max_records])?;
        let sort = pipeline(shaders::TILE_ORDER_COMP, &[count, max_entries])?;
        let order_bindings = Bindings::of(
            device,
            "order large",
            &[&unordered, &large_index, &counters, &large, &arguments]
                .map(|buffer| (Binding::STORAGE_BUFFER, Resource::Buffer(buffer))),
        )?;
        let order_large = ComputePipeline::new(
            device,
            shaders::ORDER_LARGE_COMP,
            &order_bindings,
            0,
            &[MAX_LARGE, 1],
        )?;
        Ok(Self {
            count,
            max_entries,
            counters,
            records,
            spheres,
            record_index,
            tiles,
            entries,
            large,
            totals,
            slabs,
            cell_groups: grid.count().div_ceil(64),
            bindings,
            cells,
            gather,
            offsets,
            fill,
            order: sort,
            order_bindings,
            order_large,
            _bound: [order, first, visible, bins, unordered, large_index, arguments, placed],
        })
    }

    /// Records the reset of what is counted; a barrier to compute must follow.
    pub fn record_reset(&self, device: &Device, commands: vk::CommandBuffer) {
        let [small, wide] = &self.slabs;
        for buffer in [&self.counters, small, wide] {
            // SAFETY: the command buffer is recorded outside of rendering.
            unsafe { device.raw().cmd_fill_buffer(commands, buffer.raw(), 0, vk::WHOLE_SIZE, 0) };
        }
        // No cell in view yet: 0 x 1 x 1 workgroups.
        let totals: [u32; 12] = [0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0];
        let bytes = bytemuck::bytes_of(&totals);
        // SAFETY: as above; the data is copied now.
        unsafe { device.raw().cmd_update_buffer(commands, self.totals.raw(), 0, bytes) };
    }

    /// Records which cells are in view.
    pub fn record_cells(&self, commands: vk::CommandBuffer) {
        self.cells.dispatch(commands, &self.bindings, 0, &[], [self.cell_groups, 1, 1]);
    }

    /// Records the drops' places, after [`Tiles::record_cells`] and a barrier.
    pub fn record_gather(&self, commands: vk::CommandBuffer) {
        self.gather.dispatch_indirect(commands, &self.bindings, &self.totals, 0);
    }

    /// Records the lists of the tiles, in order, after [`Tiles::record_gather`] and a barrier.
    pub fn record_lists(&self, device: &Device, commands: vk::CommandBuffer) {
        let groups = |invocations: u32| [self.count.div_ceil(invocations), 1, 1];
        self.offsets.dispatch(commands, &self.bindings, 0, &[], groups(64));
        self.order_large.dispatch(commands, &self.order_bindings, 0, &[], [16, 1, 1]);
        let written = [Use::ComputeWrite, Use::Indirect];
        memory_barrier(device, commands, &[Use::ComputeWrite], &written);
        self.fill.dispatch_indirect(commands, &self.bindings, &self.totals, 16);
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        self.order.dispatch(commands, &self.bindings, 0, &[], groups(32));
    }
}
