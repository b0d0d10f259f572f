//! Which tiles a view draws, and the regions of them by which clusters are sorted within their band of depth and tiles are
//! drawn: what is near on the screen is near in memory.

use crate::abi::{MAX_REGIONS, REGION_ACROSS, REGION_DOWN, TILE_ACROSS, TILE_DOWN};
use crate::scene::projection::View;

/// A tile in pixels.
pub(crate) const TILE: (u32, u32) = (TILE_ACROSS, TILE_DOWN);
pub(super) const TILE_PIXELS: u64 = (TILE_ACROSS * TILE_DOWN) as u64;
/// Tiles of the smallest regions.
const REGION: (u32, u32) = (REGION_ACROSS, REGION_DOWN);

/// The parts of an image by which clusters are sorted within their band, and tiles are drawn.
pub(super) struct Regions {
    /// Each has [`REGION`] tiles, times 2^this along both axes.
    pub shift: u32,
    pub across: u32,
    pub count: u32,
    /// Tiles of all of them, those beyond the image's edges included.
    pub tiles: u32,
}

impl Regions {
    /// The smallest of which an image of so many tiles has [`MAX_REGIONS`] at most.
    pub fn of(tiles_across: u32, tiles_down: u32) -> Self {
        let mut shift = 0;
        loop {
            let across = tiles_across.div_ceil(REGION.0 << shift);
            let count = across * tiles_down.div_ceil(REGION.1 << shift);
            if count <= MAX_REGIONS {
                let tiles = count * ((REGION.0 * REGION.1) << (2 * shift));
                return Self { shift, across, count, tiles };
            }
            shift += 1;
        }
    }
}

/// The first tile of what a view draws, and the one after the last, as `tile_buffers.glsl` has them: those that its
/// pixels are in and, within the whole picture, one more around them, whose fragments glints ask for their coverage.
pub(crate) fn of_view(view: &View) -> ([u32; 2], [u32; 2]) {
    let (edges, sizes) = ([TILE.0, TILE.1], [view.width, view.height]);
    let first = |axis: usize| (view.origin[axis] / edges[axis]).saturating_sub(1);
    let end = |axis: usize| {
        let last = (view.origin[axis] + sizes[axis]).div_ceil(edges[axis]) + 1;
        last.min(view.whole[axis].div_ceil(edges[axis]))
    };
    ([first(0), first(1)], [end(0), end(1)])
}
