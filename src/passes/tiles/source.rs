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
    /// Real rain's cells, and placed drops; and the drops' order.
    Cells(Box<(Cells, Buffer)>),
}

impl Source {
    /// The drops of `cells`, else those of `rain`; with how many clusters there is room for (see [`Cells::room`],
    /// [`SortedDrops::counts`]).
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        rain: &RainField,
        cells: Option<Cells>,
    ) -> Result<(Self, [u32; 2])> {
        let Some(cells) = cells else {
            let sorted = rain.sorted(scene)?;
            let counts = sorted.counts;
            return Ok((Self::Clusters(sorted), counts));
        };
        let room = cells.room;
        let bytes = 4 * u64::from(CLUSTER) * u64::from(room[0]);
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let order = Buffer::new(device, "drop order", bytes, usage, Memory::Device)?;
        Ok((Self::Cells(Box::new((cells, order))), room))
    }

    /// The cells of real rain.
    pub fn cells(&self) -> Option<&Cells> {
        match self {
            Self::Clusters(_) => None,
            Self::Cells(cells) => Some(&cells.0),
        }
    }

    /// The drops' order.
    pub fn order(&self) -> &Buffer {
        match self {
            Self::Clusters(sorted) => &sorted.order,
            Self::Cells(cells) => &cells.1,
        }
    }

    /// The boxes of clusters.
    pub fn boxes(&self) -> Option<&Buffer> {
        match self {
            Self::Clusters(sorted) => Some(&sorted.boxes),
            Self::Cells(_) => None,
        }
    }
}
