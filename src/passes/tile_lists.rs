//! The lists of the drops on each tile, and what the passes of the tiles count: the buffers that
//! `glsl/include/tile_buffers.glsl` declares, which says what stands in them.

use std::sync::Arc;

use ash::vk;

use super::room::Room;
use crate::Result;
use crate::abi::{Large, MOST_TILES, NODE, Totals};
use crate::gpu::{Buffer, Device, Memory, Texel, Texels};

/// Bytes of a splat's node, of which a block's takes two, and of a large drop.
pub(super) const NODE_BYTES: u64 = 4 * NODE as u64;
pub(super) const LARGE_BYTES: u64 = size_of::<Large>() as u64;
/// Least tiles of a drop whose blocks a workgroup gives out.
const TILES_OF_BIG: u64 = MOST_TILES as u64 + 1;

/// The buffers, by the names that shaders give them.
pub(crate) struct Lists {
    pub(super) totals: Buffer,
    /// Entries, linked.
    pub nodes: Buffer,
    /// The first entry of each tile.
    pub heads: Buffer,
    pub(super) larges: Buffer,
    pub(super) bigs: Buffer,
    pub(super) blocks: Buffer,
}

/// Views of what passes read a texel at a time.
pub(super) struct TileTexels {
    pub totals: Texels,
    pub nodes: Texels,
    pub heads: Texels,
    pub larges: Texels,
    pub blocks: Texels,
    pub pictures: Texels,
    pub order: Texels,
    pub boxes: Texels,
    pub in_view: Texels,
    pub placed: Texels,
    pub shapes: Texels,
    pub sources: Texels,
    pub tables: [Texels; 2],
}

impl Lists {
    /// With so much room, for so many tiles.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub(super) fn new(device: &Arc<Device>, room: &Room, tiles: u32) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let storage = Usage::STORAGE_BUFFER;
        let by_four = storage | Usage::UNIFORM_TEXEL_BUFFER;
        let copied = Usage::TRANSFER_SRC;
        let make = |name, bytes: u64, count: u64, usage| {
            Buffer::new(device, name, bytes * count, usage, Memory::Device)
        };
        let of_totals = by_four | Usage::INDIRECT_BUFFER | Usage::TRANSFER_DST | copied;
        Ok(Self {
            totals: make("totals", size_of::<Totals>() as u64, 1, of_totals)?,
            nodes: make("nodes", NODE_BYTES, room.nodes, by_four | copied)?,
            heads: make(
                "lists",
                16,
                tiles.div_ceil(4).into(),
                by_four | Usage::TRANSFER_DST | copied,
            )?,
            larges: make("large drops", LARGE_BYTES, room.larges, by_four)?,
            bigs: make("big drops", 8, room.blocks / TILES_OF_BIG + 1, storage)?,
            blocks: make("blocks", 8, room.blocks, storage | Usage::UNIFORM_TEXEL_BUFFER)?,
        })
    }
}

impl TileTexels {
    /// `order`, `boxes`, `in_view`, `tables`: of `glsl/include/population.glsl` and `rain_field.glsl`.
    ///
    /// # Errors
    /// See [`Texels::new`].
    pub fn of(
        device: &Arc<Device>,
        lists: &Lists,
        [pictures, order, boxes, in_view, placed, shapes, sources, tables]: [&Buffer; 8],
    ) -> Result<Self> {
        let texels = |name, buffer, texel| Texels::new(device, name, buffer, texel);
        Ok(Self {
            totals: texels("words of totals", &lists.totals, Texel::Word)?,
            nodes: texels("texels of nodes", &lists.nodes, Texel::FourWords)?,
            heads: texels("texels of lists", &lists.heads, Texel::FourWords)?,
            larges: texels("texels of large drops", &lists.larges, Texel::FourWords)?,
            blocks: texels("words of blocks", &lists.blocks, Texel::Word)?,
            pictures: texels("words of pictures", pictures, Texel::Word)?,
            order: texels("words of the drop order", order, Texel::Word)?,
            boxes: texels("texels of clusters", boxes, Texel::FourWords)?,
            in_view: texels("words of clusters in view", in_view, Texel::Word)?,
            placed: texels("texels of placed drops", placed, Texel::FourWords)?,
            shapes: texels("texels of shapes", shapes, Texel::FourWords)?,
            sources: texels("texels of bright sources", sources, Texel::FourWords)?,
            tables: [
                texels("words of rain tables", tables, Texel::Word)?,
                texels("texels of rain tables", tables, Texel::FourWords)?,
            ],
        })
    }

    /// Whether the device takes texel buffers so large.
    pub fn are_whole(&self) -> bool {
        let Self { totals, nodes, heads, larges, blocks, pictures, order, boxes, .. } = self;
        let Self { in_view, placed, shapes, sources, tables, .. } = self;
        [
            totals, nodes, heads, larges, blocks, pictures, order, boxes, in_view, placed, shapes,
            sources,
        ]
        .into_iter()
        .chain(tables)
        .all(|texels| texels.is_whole)
    }
}
