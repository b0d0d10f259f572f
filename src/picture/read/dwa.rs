//! What the DWA-compressed blocks of an EXR claim, checked before memory is taken for it.
//!
//! Each block begins with eleven counters, and exr 1.74 allocates what five of them say: a broken file
//! of 1.6 kB asked for 4 PB, which no `catch_unwind` survives.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::meta::header::Header;
use exr::prelude::Compression;

/// Counters at the start of a block that say how much comes out of it: bytes of other channels, of
/// run lengths packed and unpacked, numbers of cosine coefficients and of their means.
const CLAIMS: [usize; 5] = [1, 6, 7, 8, 9];

/// Refuses a block that claims more than its pixels could give. Whatever else is wrong is the decoder's to say.
pub(super) fn check_claim(header: &Header, chunk: &Chunk) -> Result<(), String> {
    match excess(header, chunk) {
        Some(claim) => Err(super::broken(format!("a block of it claims to hold {claim} values"))),
        None => Ok(()),
    }
}

/// A claim that the block cannot keep, if there is one.
fn excess(header: &Header, chunk: &Chunk) -> Option<u64> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return None;
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return None,
    };
    let place = header.get_block_data_indices(&chunk.compressed_block).ok()?;
    let size = header.get_absolute_block_pixel_coordinates(place).ok()?.size;
    if bytes.len() == size.area() * header.channels.bytes_per_pixel {
        return None; // stored as it is
    }
    // Cosines come in squares of eight, and run lengths may take more room than what they stand for.
    let padded = size.width().next_multiple_of(8) * size.height().next_multiple_of(8);
    let most = 2 * (padded * header.channels.bytes_per_pixel) as u64;
    let counters =
        bytes.chunks_exact(8).map(|b| b.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)));
    let counters: Vec<u64> = counters.take(11).collect();
    CLAIMS.iter().filter_map(|claim| counters.get(*claim)).copied().find(|claim| *claim > most)
}
