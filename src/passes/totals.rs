//! What the passes of the tiles count together, as `Totals` in `glsl/include/tile_buffers.glsl` has it: arguments of
//! indirect dispatches, counts, and where each bin of clusters begins.

use std::mem::offset_of;

use crate::abi::{LISTS, MAX_BANDS, MAX_REGIONS, RAY_PIECES, Totals};

pub(super) const MAX_BINS: usize = (MAX_BANDS * MAX_REGIONS) as usize;

// The word that the shaders count to.
const _: () = {
    let word = 4 * (10 + MAX_BANDS + RAY_PIECES + LISTS) as usize + LISTS as usize + 13 + MAX_BINS;
    assert!(offset_of!(Totals, bin_starts) == 4 * word);
};

/// Byte offsets of the indirect arguments in the totals.
pub(super) const SORT_GROUPS: u64 = offset_of!(Totals, sort_groups) as u64;
pub(super) const GATHER_GROUPS: u64 = offset_of!(Totals, gather_groups) as u64; // of the first band
pub(super) const LARGE_GROUPS: u64 = offset_of!(Totals, large_groups) as u64;
pub(super) const BIG_GROUPS: u64 = offset_of!(Totals, big_groups) as u64;
pub(super) const BLOCK_GROUPS: u64 = offset_of!(Totals, block_groups) as u64;
pub(super) const RAY_GROUPS: u64 = offset_of!(Totals, ray_groups) as u64; // of the first piece
pub(super) const LISTED_GROUPS: u64 = offset_of!(Totals, listed_groups) as u64; // of the first list
pub(super) const DISORDERED_GROUPS: u64 = offset_of!(Totals, disordered_groups) as u64;
pub(super) const CROWDED_GROUPS: u64 = offset_of!(Totals, crowded_groups) as u64;
pub(super) const ORDER_GROUPS: u64 = offset_of!(Totals, order_groups) as u64;
pub(super) const UNFINISHED_GROUPS: u64 = offset_of!(Totals, unfinished_groups) as u64;
pub(super) const LINE_GROUPS: u64 = offset_of!(Totals, line_groups) as u64;
pub(super) const SHARED_GROUPS: u64 = offset_of!(Totals, shared_groups) as u64;
/// Words of all arguments, and of these and the counts that follow; then come the bins'.
pub(super) const GROUPS_WORDS: usize = offset_of!(Totals, larges) / 4;
pub(super) const COUNTS_WORDS: usize = offset_of!(Totals, bin_counts) / 4;
/// Where the counts stand in the totals, in bytes, and how many words of them there are.
pub(crate) const COUNTS: (u64, usize) = (4 * GROUPS_WORDS as u64, COUNTS_WORDS - GROUPS_WORDS);
/// What a frame by tiles came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileCounts {
    /// Clusters of drops in view.
    pub clusters: u64,
    /// Drops in view that are larger than a splat.
    pub large: u64,
    /// Tile fragments of those: one for each tile that one of them touches.
    pub fragments: u64,
    /// Fragments that are drawn by rays.
    pub ray_fragments: u64,
    /// Fragments by rays of the dispatch that draws most of them.
    pub ray_fragments_a_dispatch: u64,
    /// Tiles drawn a second time, their lists sorted.
    pub tiles_again: u64,
    /// Tiles, of those drawn again, that get a workgroup each, as they have too many streaks for one invocation.
    pub crowded_tiles: u64,
    /// Tiles whose lists are longer than one dispatch goes through, 65,536 entries.
    pub long_tiles: u64,
    /// Whether something was lost for which more room can be made.
    pub lacks_room: bool,
}

impl TileCounts {
    /// Reads what [`COUNTS`] holds: the shaders' `Totals` from `larges` on. `ray_piece`: fragments that a dispatch draws by
    /// rays, at most.
    pub(crate) fn of(words: &[u32], ray_piece: u32) -> Self {
        let word = |offset: usize| u64::from(words[offset / 4 - GROUPS_WORDS]);
        Self {
            large: word(offset_of!(Totals, larges)),
            fragments: word(offset_of!(Totals, blocks)),
            ray_fragments: word(offset_of!(Totals, ray_blocks)),
            ray_fragments_a_dispatch: word(offset_of!(Totals, ray_blocks)).min(ray_piece.into()),
            tiles_again: word(offset_of!(Totals, disordered)),
            crowded_tiles: word(offset_of!(Totals, crowded)),
            long_tiles: word(offset_of!(Totals, unfinished)),
            clusters: word(offset_of!(Totals, in_view)),
            lacks_room: word(offset_of!(Totals, lacks_room)) != 0,
        }
    }
}
