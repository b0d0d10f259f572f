//! Which drops fall on which tile of the image, front to back, without touching a drop that is out
//! of view for long. Compute passes:
//!
//! 1. `cells`: whole cells of the rain box out of view are passed over (five of six drops);
//! 2. `gather`: each drop of the other cells finds its place, its outline and its tiles of 4 x 2
//!    pixels, and is counted in each, by slab of distance;
//! 3. `lists`: the lists get their room (`tile_offsets`), the drops are written into them
//!    (`tile_fill`), and each slab is sorted by distance, then drop index (`tile_order`): a total
//!    order, so that the picture is the same on every run.
//!
//! Drops that touch more than 12 tiles, a few in a thousand, are counted and entered by a
//! workgroup each (`big`).
//!
//! No pass uses shared memory or barriers within a workgroup, poison on CPU drivers; what must be
//! counted is counted by atomics on many addresses.

use std::sync::Arc;

use ash::vk;

use super::frame::FrameBuffer;
use super::simulate::{Simulate, placed_records};
use crate::cells::Cells;
use crate::gpu::{
    Binding, Bindings, Buffer, ComputePipeline, Device, Memory, Resource, Use, memory_barrier,
    shaders,
};
use crate::scene::Scene;
use crate::{Error, Result};

/// A tile in pixels, as in `glsl/include/tile_buffers.glsl`.
const TILE: (u32, u32) = (4, 2);
/// Words of a drop's bin, as there.
const BIN_WORDS: u64 = 8;
/// Tiles that a drop at the paper's sizes touches.
const TILES_A_DROP: f64 = 3.5;
/// Part of all drops that is in view at the paper's 90°, at most.
const SHARE_IN_VIEW: f64 = 0.18;
/// Drops that a slab should hold: with twice as many it still sorts in registers.
const DROPS_A_SLAB: f64 = 3.0;
const MAX_SLABS: u32 = 16;
/// Radius in pixels of the largest drop that can touch no more than the 12 tiles that one invocation
/// enters: 96 pixels.
const MOST_PX_OF_FEW_TILES: f32 = 5.6;
/// Distance in radii within which drops are drawn by rays, as in `glsl/gather.comp`.
const NEAR_RADII: f32 = 32.0;
/// Most drops that touch many tiles; those beyond it are counted and reported, not drawn.
const MAX_BIGS: u32 = 262_144;
/// List entries that are provided for each drop: four times what the paper's scene takes.
const ENTRIES_A_DROP: u64 = 2;
/// Entries provided for each tile: so many layers of the whole image may be large drops.
const ENTRIES_A_TILE: u64 = 8;
/// Blocks provided for each tile, likewise, of drops drawn by rays …
const BLOCKS_A_TILE: u32 = 6;
/// … and for each drop, where all are.
const BLOCKS_A_DROP: u32 = 1;

/// The passes and what they hand on.
pub struct Tiles {
    /// Tiles in the image.
    pub count: u32,
    /// Room for entries; the lists end there.
    pub max_entries: u32,
    /// Room for pixel blocks of drops drawn by rays.
    pub max_blocks: u32,
    /// What was counted (see [`Simulate::counts`]).
    pub counters: Buffer,
    /// What the shaders' `tile_buffers.glsl` declares, from binding 1 on.
    pub(super) shared: [Buffer; 14],
    slabs: u32,
    cell_groups: u32,
    bindings: Bindings,
    cells: ComputePipeline,
    gather: ComputePipeline,
    count_big: ComputePipeline,
    offsets: ComputePipeline,
    fill: ComputePipeline,
    fill_big: ComputePipeline,
    order: ComputePipeline,
    _placed: Buffer,
}

/// Where in [`Tiles::shared`] the buffers are that are reset.
const TOTALS: usize = 2;
const SLABS: usize = 8;
const BIG_SLABS: usize = 13;
/// Byte offsets of the indirect arguments in the totals.
const RECORD_GROUPS: u64 = 0;
const BIG_GROUPS: u64 = 16;
/// … and of those of the blocks, which are drawn elsewhere.
pub(super) const BLOCK_GROUPS: u64 = 32;

impl Tiles {
    /// Buffers and pipelines for the drops of `scene`; drops of over `rays_px` pixels of radius get
    /// pixel blocks of their own.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        scene: &Scene,
        rays_px: f32,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let limits = &device.report.limits;
        let range = u64::from(limits.max_storage_buffer_range);
        let groups = limits.max_compute_work_group_count[0];
        let drops = scene.drop_count();
        let within = |what, wanted: u64, limit: u64| {
            let device = device.report.name.clone();
            if wanted > limit { Err(Error::Limit { what, wanted, limit, device }) } else { Ok(()) }
        };
        // Their order, a word each, is one binding.
        within("the number of drops in tiles", drops.into(), range / 4)?;
        let (across, down) =
            (scene.image.width.div_ceil(TILE.0), scene.image.height.div_ceil(TILE.1));
        let count = across * down;
        // One dispatch takes an invocation a slab of a tile; a tile's list, 8 bytes, is in one binding.
        let most_slabs = (64 * u64::from(groups)).min(range / 8);
        let pixels = u64::from(TILE.0 * TILE.1);
        within("the image's pixels in tiles", pixels * u64::from(count), pixels * most_slabs)?;
        let a_tile = f64::from(drops) * SHARE_IN_VIEW * TILES_A_DROP / f64::from(count);
        let most_slabs = (most_slabs / u64::from(count)).clamp(1, MAX_SLABS.into()) as u32;
        let slabs = ((a_tile / DROPS_A_SLAB).ceil() as u32).clamp(1, most_slabs);
        let grid = Cells::new(scene.rain().as_ref(), scene.drops.len() as u32);

        let max_records = u64::from(drops).min(range / 32) as u32;
        let entries = ENTRIES_A_DROP * u64::from(drops) + ENTRIES_A_TILE * u64::from(count);
        let max_entries = entries.min(range / 8) as u32;
        let all_by_rays = if rays_px > 0.0 { 0 } else { BLOCKS_A_DROP * drops };
        let blocks = u64::from(BLOCKS_A_TILE * count + all_by_rays);
        // The blocks share a buffer with the pictures, which take 6 MB.
        let max_blocks = blocks.min((range - (6 << 20)) / 32).min(32 * u64::from(groups)) as u32;
        let max_bigs = drops.min(MAX_BIGS).min(groups);

        let storage = Usage::STORAGE_BUFFER;
        let cleared = storage | Usage::TRANSFER_DST;
        let make = |name, bytes: u64, count: u32, usage| {
            Buffer::new(device, name, bytes * u64::from(count), usage, Memory::Device)
        };
        let shared = [
            Buffer::upload_device(device, "drop order", &grid.order, storage)?,
            Buffer::upload_device(device, "cells", &grid.first, storage)?,
            make("totals", 64, 1, cleared | Usage::INDIRECT_BUFFER)?,
            make("drop records", 32, max_records, storage)?,
            make("drop spheres", 16, max_records, storage)?,
            make("drop indices", 4, max_records, storage)?,
            make("records of drops", 4, drops, storage)?,
            make("drop bins", 4 * BIN_WORDS, max_records, storage)?,
            make("slabs", 4, count * slabs, cleared)?,
            make("tiles", 8, count, storage)?,
            make("tile entries", 8, max_entries, storage)?,
            make("big drops", 4, max_bigs, storage)?,
            make("pixel blocks", 8, max_blocks, storage)?,
            make("slabs of big drops", 4, count * slabs, cleared)?,
        ];
        let placed = Buffer::upload(device, "placed drops", &placed_records(scene), storage)?;
        let counters = Simulate::counters(device)?;

        let uniform = (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer));
        let slots: Vec<_> = std::iter::once(uniform)
            .chain(
                shared
                    .iter()
                    .chain([&placed, &counters])
                    .map(|buffer| (Binding::STORAGE_BUFFER, Resource::Buffer(buffer))),
            )
            .collect();
        let bindings = Bindings::of(device, "tiles", &slots)?;
        let pipeline = |shader, constants: &[u32]| {
            ComputePipeline::new(device, shader, &bindings, 0, constants)
        };
        // Drops so small are only drawn by rays if all are, or where a pixel is so wide that near
        // drops are small; then the code for it is compiled in.
        let near_px = scene.view().focal_px as f32 / NEAR_RADII;
        let may_ray = u32::from(rays_px.min(near_px) < MOST_PX_OF_FEW_TILES);
        let big = |fill| pipeline(shaders::BIG_COMP, &[fill, max_entries, max_blocks, slabs]);
        let cells = pipeline(shaders::CELLS_COMP, &[grid.bits, grid.count(), max_records])?;
        let has_placed = u32::from(!scene.drops.is_empty());
        let gather = pipeline(
            shaders::GATHER_COMP,
            &[max_bigs, max_records, slabs, rays_px.to_bits(), has_placed, may_ray],
        )?;
        let (count_big, fill_big) = (big(0)?, big(1)?);
        let offsets = pipeline(shaders::TILE_OFFSETS_COMP, &[count, slabs])?;
        let fill = pipeline(
            shaders::TILE_FILL_COMP,
            &[max_entries, max_blocks, max_records, slabs, may_ray],
        )?;
        let order = pipeline(shaders::TILE_ORDER_COMP, &[count, max_entries, max_blocks, slabs])?;
        Ok(Self {
            count,
            max_entries,
            max_blocks,
            counters,
            shared,
            slabs,
            cell_groups: grid.count().div_ceil(64),
            bindings,
            cells,
            gather,
            count_big,
            offsets,
            fill,
            fill_big,
            order,
            _placed: placed,
        })
    }

    /// Numbers of workgroups that the passes leave for indirect dispatches.
    pub(super) fn totals(&self) -> &Buffer {
        &self.shared[TOTALS]
    }

    /// Records the reset of what is counted; a barrier to compute must follow.
    pub fn record_reset(&self, device: &Device, commands: vk::CommandBuffer) {
        for buffer in [&self.counters, &self.shared[SLABS], &self.shared[BIG_SLABS]] {
            // SAFETY: the command buffer is recorded outside of rendering.
            unsafe { device.raw().cmd_fill_buffer(commands, buffer.raw(), 0, vk::WHOLE_SIZE, 0) };
        }
        // Three times 0 x 1 x 1 workgroups, then the counts.
        let totals: [u32; 16] = [0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0];
        let bytes = bytemuck::bytes_of(&totals);
        // SAFETY: as above; the data is copied now.
        unsafe { device.raw().cmd_update_buffer(commands, self.totals().raw(), 0, bytes) };
    }

    /// Records which cells are in view.
    pub fn record_cells(&self, commands: vk::CommandBuffer) {
        self.cells.dispatch(commands, &self.bindings, 0, &[], [self.cell_groups, 1, 1]);
    }

    /// Records the drops' places and tiles, after [`Tiles::record_cells`] and a barrier.
    pub fn record_gather(&self, device: &Device, commands: vk::CommandBuffer) {
        self.gather.dispatch_indirect(commands, &self.bindings, self.totals(), RECORD_GROUPS);
        let written = [Use::ComputeWrite, Use::Indirect];
        memory_barrier(device, commands, &[Use::ComputeWrite], &written);
        self.count_big.dispatch_indirect(commands, &self.bindings, self.totals(), BIG_GROUPS);
    }

    /// Records the room of the tiles' lists, after [`Tiles::record_gather`] and a barrier.
    pub fn record_offsets(&self, commands: vk::CommandBuffer) {
        let groups = [self.count.div_ceil(64), 1, 1];
        self.offsets.dispatch(commands, &self.bindings, 0, &[], groups);
    }

    /// Records the drops' entry into the lists, after [`Tiles::record_offsets`] and a barrier.
    pub fn record_fill(&self, commands: vk::CommandBuffer) {
        self.fill.dispatch_indirect(commands, &self.bindings, self.totals(), RECORD_GROUPS);
        self.fill_big.dispatch_indirect(commands, &self.bindings, self.totals(), BIG_GROUPS);
    }

    /// Records the sorting of the lists, after [`Tiles::record_fill`] and a barrier.
    pub fn record_order(&self, commands: vk::CommandBuffer) {
        let groups = [(self.count * self.slabs).div_ceil(64), 1, 1];
        self.order.dispatch(commands, &self.bindings, 0, &[], groups);
    }
}
