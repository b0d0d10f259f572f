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
    pub nodes: Texels,
    pub heads: Texels,
    pub larges: Texels,
    pub pictures: Texels,
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
        let of_totals = storage | Usage::INDIRECT_BUFFER | Usage::TRANSFER_DST | copied;
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
            blocks: make("blocks", 8, room.blocks, storage)?,
        })
    }
}

impl TileTexels {
    /// None where the device takes no texel buffers so large.
    ///
    /// # Errors
    /// See [`Texels::new`].
    pub fn of(device: &Arc<Device>, lists: &Lists, pictures: &Buffer) -> Result<Option<Self>> {
        let (nodes, heads, larges) = (&lists.nodes, &lists.heads, &lists.larges);
        let four = Texel::FourWords;
        let fit = [(nodes, four), (heads, four), (larges, four), (pictures, Texel::Word)]
            .iter()
            .all(|(buffer, words)| Texels::fit(device, buffer, *words));
        if !fit {
            return Ok(None);
        }
        Ok(Some(Self {
            nodes: Texels::new(device, "texels of nodes", nodes, four)?,
            heads: Texels::new(device, "texels of lists", heads, four)?,
            larges: Texels::new(device, "texels of large drops", larges, four)?,
            pictures: Texels::new(device, "texels of pictures", pictures, Texel::Word)?,
        }))
    }
}
