//! What the first passes over the tiles take drops from: clusters that never change, or a frame's cells of real rain.

use std::sync::Arc;

use ash::vk;

use super::super::cells::Cells;
use super::super::rain_field::{RainField, SortedDrops};
use crate::Result;
use crate::abi::CLUSTER;
use crate::gpu::{Buffer, Device, Memory};
use crate::scene::Scene;

/// Where drops come from.
pub(super) enum Source {
    /// Drops in a box and placed ones, in clusters that never change.
    Clusters(Arc<SortedDrops>),
    /// Real rain's cells, and placed drops; the drops' order, and the `RainField`.
    Cells(Box<(Cells, [Buffer; 2])>),
}

impl Source {
    /// The drops of `cells`, else those of `rain`; with how many clusters there is room for (see [`Cells::room`],
    /// [`SortedDrops::counts`]).
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        rain: &RainField,
        cells: Option<(Cells, Buffer)>,
    ) -> Result<(Self, [u32; 2])> {
        let Some((cells, field)) = cells else {
            let sorted = rain.sorted(scene)?;
            let counts = sorted.counts;
            return Ok((Self::Clusters(sorted), counts));
        };
        let room = cells.room;
        let bytes = 4 * u64::from(CLUSTER) * u64::from(room[0]);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let order = Buffer::new(device, "drop order", bytes, usage, Memory::Device)?;
        Ok((Self::Cells(Box::new((cells, [order, field]))), room))
    }

    /// The drops' order; the boxes of clusters and the `RainField`, one of which is missing.
    pub fn buffers(&self) -> (&Buffer, [Option<&Buffer>; 2]) {
        match self {
            Self::Clusters(sorted) => (&sorted.order, [Some(&sorted.boxes), None]),
            Self::Cells(cells) => (&cells.1[0], [None, Some(&cells.1[1])]),
        }
    }
}
