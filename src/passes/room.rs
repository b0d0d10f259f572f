//! How much room a view's lists have: bounded when it is made, by what may be in view and not by how many drops there
//! are. What does not fit is counted, and told once the frame has retired; whoever owns the view may then make one with
//! more ([`crate::renderer::Renderer::grow`], [`crate::renderer::View::grow`]).

use super::tile_lists::{LARGE_BYTES, NODE_BYTES};
use crate::abi::{CLUSTER, LargeShape};
use crate::gpu::DeviceReport;
use crate::plan::FramePlan;

/// Drops that are all given a place, wherever the camera stands; and the share of more of them that is: at the paper's
/// 90° some 0.18 are in view, in 0.25 of the clusters.
const LEAST_DROPS: u64 = 1 << 20;
const SHARE: f64 = 0.28;
/// One drop in this many that may be in view is larger than a splat and needs a block, where splats are drawn.
const DROPS_A_LARGE: u64 = 4;
/// Blocks for each tile besides: so many layers of the whole image may be large drops.
const BLOCKS_A_TILE: u64 = 4;
/// Part of the largest allocation that blocks may take: a large image has many tiles, few of them full of large drops.
const BLOCKS_SHARE: u64 = 8;
/// Blocks in any case: on images of a few tiles many drops share one.
const LEAST_BLOCKS: u64 = 16_384;

/// Bytes of the largest record that each larger drop has: all of these are one binding.
const MOST_LARGE_BYTES: u64 = {
    let shape = size_of::<LargeShape>() as u64;
    if shape > LARGE_BYTES { shape } else { LARGE_BYTES }
};

/// Numbers of records.
pub(super) struct Room {
    /// Splats, and twice the blocks.
    pub nodes: u64,
    /// Tiles of larger drops.
    pub blocks: u64,
    /// Larger drops.
    pub larges: u64,
}

impl Room {
    /// That of a view of so many `tiles`, on a device and by a plan, whose `room` is a factor. `drops` are those that
    /// there are in so many `clusters`; `from_cells`: they are those of cells in view, but for a few, and hold the factor
    /// already (`Cells::room`).
    pub fn of(
        device: &DeviceReport,
        plan: &FramePlan,
        tiles: u32,
        (drops, clusters): (u64, u32),
        from_cells: bool,
    ) -> Self {
        let range = u64::from(device.limits.max_storage_buffer_range);
        let groups = u64::from(device.limits.max_compute_work_group_count[0]);
        let factor = u64::from(plan.room);
        let in_view = |all: u64| match from_cells {
            true => all,
            false => all.min(LEAST_DROPS.max((SHARE * all as f64) as u64)),
        };
        let drops_a_large = if plan.splat_px > 0.0 { DROPS_A_LARGE } else { 1 };
        let usual = if from_cells { drops / factor } else { drops };
        let larges = (in_view(usual) / drops_a_large).max(LEAST_DROPS / DROPS_A_LARGE);
        // A place for each drop of a cluster in view.
        let places = u64::from(clusters) * u64::from(CLUSTER);
        let splats = match plan.splat_px > 0.0 {
            true => in_view(places).saturating_mul(factor).min(places),
            false => 0,
        };
        let blocks = (BLOCKS_A_TILE * u64::from(tiles) + larges.min(usual))
            .max(LEAST_BLOCKS)
            .saturating_mul(factor)
            .min(range / (2 * NODE_BYTES))
            .min(device.max_allocation / (BLOCKS_SHARE * 2 * NODE_BYTES));
        // Where that is less than both may take, blocks have the places of the clusters out of view.
        let nodes = (splats + 2 * blocks).min(range / (2 * NODE_BYTES) * 2);
        let most_larges = (range / MOST_LARGE_BYTES).min(64 * groups);
        let larges = larges.saturating_mul(factor).min(drops).min(most_larges);
        Self { nodes, blocks, larges }
    }
}
