//! What the passes of the tiles count together, as `Totals` in `glsl/include/tile_buffers.glsl` has it: arguments of
//! indirect dispatches, counts, and where each bin of clusters begins.

use super::tile_grid::MAX_REGIONS;

/// Bands of depth at most, as in the shaders.
pub(super) const MAX_BANDS: u32 = 16;
pub(super) const MAX_BINS: usize = (MAX_BANDS * MAX_REGIONS) as usize;

/// Byte offsets of the indirect arguments in the totals.
pub(super) const SORT_GROUPS: u64 = 0;
pub(super) const GATHER_GROUPS: u64 = 16; // of the first band
pub(super) const LARGE_GROUPS: u64 = GATHER_GROUPS + 16 * MAX_BANDS as u64;
pub(super) const BIG_GROUPS: u64 = LARGE_GROUPS + 16;
pub(super) const BLOCK_GROUPS: u64 = BIG_GROUPS + 16;
pub(super) const RAY_GROUPS: u64 = BLOCK_GROUPS + 16;
pub(super) const DISORDERED_GROUPS: u64 = RAY_GROUPS + 16;
/// Words of all arguments, of these and the counts that follow, and of the totals, which end with the bins'.
pub(super) const GROUPS_WORDS: usize = DISORDERED_GROUPS as usize / 4 + 4;
pub(super) const COUNTS_WORDS: usize = GROUPS_WORDS + 9;
pub(super) const TOTALS_WORDS: usize = COUNTS_WORDS + MAX_BINS + MAX_BINS + 1;
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
    /// Of those, drawn by rays.
    pub ray_fragments: u64,
    /// Tiles drawn a second time, their lists sorted.
    pub tiles_again: u64,
    /// Whether something was lost for which more room can be made.
    pub lacks_room: bool,
}

impl TileCounts {
    /// Reads what [`COUNTS`] holds: the shaders' `Totals` from `larges` on.
    pub(crate) fn of(words: &[u32]) -> Self {
        let word = |at: usize| u64::from(words[at]);
        Self {
            large: word(0),
            fragments: word(2),
            ray_fragments: word(3),
            tiles_again: word(4),
            clusters: word(5),
            lacks_room: word(8) != 0,
        }
    }
}
