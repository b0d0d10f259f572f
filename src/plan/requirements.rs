//! What a device must have for a preset, or for a plan: known before the device is made.

use super::FramePlan;
use crate::gpu::Requirements;
use crate::scene::model::{Preset, Primitive};

/// What a device must have to draw by a preset, whatever else a scene's `[model]` says that goes with it. `fast` and
/// `exact` draw on tiles, which need neither large points nor images that are written without a format; `auto` may
/// choose the paper's billboards.
pub fn requirements(preset: Preset) -> Requirements {
    match preset {
        Preset::Fast | Preset::Exact => Requirements::new(false, false),
        Preset::Auto => Requirements::new(true, false),
        Preset::Paper | Preset::PaperCompact => Requirements::new(true, true),
    }
}

impl FramePlan {
    /// What a device must have to draw by this plan.
    pub fn requirements(&self) -> Requirements {
        Requirements::new(self.primitive == Primitive::Point, self.optics.is_mask())
    }
}
