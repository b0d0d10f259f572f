//! The passes from a scene to its radiance: of points, or of tiles.

use super::points::Points;
use super::tiled::Tiled;
use crate::gpu::{Buffer, Device, Recorder};
use crate::passes::pane::Pane;
use crate::passes::tone_map::Source;

/// From a scene to its radiance.
pub(super) enum Drawing {
    Points(Box<Points>),
    Tiled(Box<Tiled>),
}

impl Drawing {
    /// The passes over tiles; none of points.
    pub fn tiled(&self) -> Option<&Tiled> {
        match self {
            Self::Points(_) => None,
            Self::Tiled(tiled) => Some(tiled),
        }
    }

    pub fn counters(&self) -> Option<&Buffer> {
        match self {
            Self::Points(points) => points.simulate().map(|simulate| &simulate.counters),
            Self::Tiled(tiled) => Some(&tiled.tiles.counters),
        }
    }

    /// What the tiles' passes hand to each other, counts among it.
    pub fn totals(&self) -> Option<&Buffer> {
        self.tiled().map(|tiled| tiled.tiles.totals())
    }

    /// The pane's passes; none of a picture without one.
    pub fn pane(&self) -> Option<&Pane> {
        self.tiled()?.pane.as_ref()
    }

    /// Fragments that a dispatch draws by rays, at most; none without tiles.
    pub fn ray_piece(&self) -> Option<u32> {
        self.tiled().map(|tiled| tiled.tiles.ray_pieces.blocks)
    }

    /// What the passes after it read.
    pub fn source(&self) -> Source<'_> {
        match self {
            Self::Points(points) => Source::Image(&points.radiance),
            Self::Tiled(tiled) => tiled.source(),
        }
    }

    /// Makes the radiance ready to be read by a fragment shader.
    pub fn record_display(&self, device: &Device, commands: Recorder<'_>) {
        match self {
            Self::Points(points) => points.record_display(device, commands),
            Self::Tiled(tiled) => tiled.record_display(device, commands),
        }
    }

    /// Whether it has lists with more room than the other's.
    pub fn has_more_room_than(&self, other: &Self) -> bool {
        let both = self.tiled().zip(other.tiled());
        both.is_some_and(|(tiled, other)| tiled.tiles.has_more_room_than(&other.tiles))
    }

    /// What the table of a drop's light is, and the milliseconds that it took.
    pub fn table_ms(&self) -> Option<(&'static str, f64)> {
        match self {
            Self::Points(points) => points.table_ms(),
            Self::Tiled(_) => None,
        }
    }
}
