//! What a frame counts of its drops, in whichever way it draws them: `Counters` of `glsl/include/counters.glsl`.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::abi::Counters;
use crate::gpu::{Buffer, Device, Memory};
use crate::remark::Remark;
use crate::thousands::counted;

/// Words of the buffer.
pub const WORDS: usize = size_of::<Counters>() / 4;

/// A buffer for what is counted.
///
/// # Errors
/// See [`Buffer::new`].
pub fn buffer(device: &Arc<Device>) -> Result<Buffer> {
    use vk::BufferUsageFlags as Usage;
    let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
    Buffer::new(device, "counters", 4 * WORDS as u64, usage, Memory::Device)
}

/// What a frame counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Drops in view.
    pub visible: u64,
    /// Drops in view that are larger than a point may be; tiles count none.
    pub large: u64,
    /// Without room in a list, such as that of [`MAX_LARGE`](super::simulate::MAX_LARGE), and not drawn, or in part;
    /// and entries of tiles' lists that the driver did not go through, perhaps drawn out of order. And numbers without room in the
    /// cells of a pane, as of drops of a host's that overlap.
    pub overflow: u64,
    /// Drops with the camera inside, not drawn.
    pub camera_inside: u64,
    /// Drops whose outline reaches the camera plane; points and quads do not draw them. Tiles draw them, and count none.
    pub beside_camera: u64,
    /// A host's drops that are left out: not finite, out of the limits that it gave, or with a radius that is not over 0.
    pub unfit: u64,
    /// A host's drops that are left out: more, by their count, than the view was made for or their buffer holds.
    pub beyond: u64,
}

impl Counts {
    /// Reads the [`WORDS`] words of the buffer.
    pub fn of(words: &[u32]) -> Self {
        let counters: &Counters = bytemuck::from_bytes(bytemuck::cast_slice(words));
        Self {
            visible: counters.visible.iter().map(|n| u64::from(*n)).sum(),
            large: counters.large_count.into(),
            overflow: counters.lost.into(),
            camera_inside: counters.camera_inside.into(),
            beside_camera: counters.beside_camera.into(),
            unfit: counters.unfit.into(),
            beyond: counters.beyond.into(),
        }
    }

    /// Which drops were left out, and why; and whether their lists had to be larger than usual, by a factor of `room`.
    pub fn remarks(&self, room: u32) -> Vec<Remark> {
        let mut remarks = Vec::new();
        if room > 1 {
            remarks.push(Remark::note(format!(
                "more drops in view than was provided for: drawn again with {room} times the room"
            )));
        }
        let whys = [
            (
                self.overflow,
                "not drawn, or out of order",
                "more, tile by tile, than the lists hold or are put in order",
            ),
            (self.camera_inside, "not drawn", "the camera is inside"),
            (
                self.beside_camera,
                "not drawn",
                "they reach beside the camera, where a billboard has no shape",
            ),
            (
                self.unfit,
                "not drawn",
                "not finite, out of their limits, or with a radius that is not over 0",
            ),
            (self.beyond, "not drawn", "more of a host's than there is room for"),
        ];
        let undrawn = whys.into_iter().filter(|(count, ..)| *count > 0);
        remarks.extend(undrawn.map(|(count, what, why)| {
            Remark::warning(format!("{} {what}: {why}", counted(count, "drop")))
        }));
        remarks
    }

    /// Adds what another frame, or another part of the picture, counted.
    pub fn add(&mut self, other: &Self) {
        self.visible += other.visible;
        self.large += other.large;
        self.overflow += other.overflow;
        self.camera_inside += other.camera_inside;
        self.beside_camera += other.beside_camera;
        self.unfit += other.unfit;
        self.beyond += other.beyond;
    }
}
