//! What the passes over the tiles are specialized by.

use crate::gpu::sets::constant;
use crate::passes::light_constants;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::{Lens, Motion, ShapeModel};

/// Specialization constants of all passes over the tiles but those that the device decides.
pub fn constants_of(
    scene: &Scene,
    plan: &FramePlan,
    [has_cells, has_depth]: [bool; 2],
) -> Vec<[u32; 2]> {
    let is_several = scene.populations().len() > 1;
    let shape = match plan.shape.model {
        ShapeModel::Sphere => 0,
        ShapeModel::Stretched => 1,
        ShapeModel::Spheroid | ShapeModel::Equilibrium => {
            2 + u32::from(!plan.shape.shows_sources_once(scene))
        }
    };
    let own = [
        [constant::HAS_LENS, (plan.lens != Lens::Pinhole).into()],
        [constant::SPLAT_PX, plan.splat_px.to_bits()],
        [constant::RAYS_PX, plan.rays_px.to_bits()],
        [constant::HAS_PLACED, (has_cells || is_several || scene.placed_count() > 0).into()],
        [constant::SAMPLES, plan.samples],
        [constant::MOST_RAYS, plan.most_rays],
        [constant::UNSURE_RAYS, plan.unsure_rays],
        [constant::SEVERAL, is_several.into()],
        [constant::HAS_DEPTH, has_depth.into()],
        [constant::NEAREST, plan.nearest.into()],
        [constant::GRAIN, plan.is_grainy().into()],
        [constant::MOTION, (plan.motion != Motion::Instant).into()],
        [constant::SHAPE, shape],
        [constant::FLAT_RAIN, plan.shape.flattens_rain(scene).into()],
        [constant::FLAT_PLACED, plan.shape.flattens_placed(scene).into()],
        [constant::FLAT_RAYS_PX, plan.shape.rays_px.to_bits()],
    ];
    light_constants(&plan.light).into_iter().chain(own).collect()
}
