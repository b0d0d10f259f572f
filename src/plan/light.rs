//! What a drop does to a ray of light: by the scene, its preset or `auto`.

use serde::{Deserialize, Serialize};

use super::{Choice, Models};
use crate::optics::WATER;
use crate::scene::Scene;
use crate::scene::model::{Fresnel, Lookup, Optics, Preset, Primitive, Reflection, Weights};

/// What a drop does to a ray of light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Most reflections inside a drop that are followed.
    pub internal_reflections: u32,
    /// Most in the pictures of far drops, which are made once: on tiles eight, unless a scene asks for another number. No
    /// file has it: it follows from the scene.
    #[serde(skip)]
    pub picture_reflections: u32,
    /// Level of the finest of these pictures, which has 2 to that many texels an edge; 0 where a drop has one colour. No file has
    /// it: it follows from the scene.
    #[serde(skip)]
    pub picture_level: u32,
    /// What becomes of the others' light.
    pub weights: Weights,
    /// Reflectance of the surface.
    pub fresnel: Fresnel,
    /// The reflection on the outside.
    pub reflection: Reflection,
    /// Level at which the environment is read.
    pub lookup: Lookup,
    /// Refractive index of the drops over that of what they are in, for red, green and blue.
    #[serde(default = "of_water")]
    pub indices: [f64; 3],
}

pub(super) fn of_water() -> [f64; 3] {
    [WATER; 3]
}

impl Default for Light {
    /// The paper's: no internal reflections, F and 1-F, the exact F.
    fn default() -> Self {
        Self {
            internal_reflections: 0,
            picture_reflections: 0,
            picture_level: 4,
            weights: Weights::Conserving,
            fresnel: Fresnel::Exact,
            reflection: Reflection::On,
            lookup: Lookup::Footprint,
            indices: of_water(),
        }
    }
}

/// Most internal reflections that are followed unless a scene asks for more.
const MOST_ORDERS: u32 = 8;

impl Light {
    /// What a scene asks for, else what `auto` has chosen, else the preset's. `is_traced`: in a shape without a closed form;
    /// `picture_level`: that of the drops' sizes ([`super::rays`]).
    pub(super) fn of(
        scene: &Scene,
        models: Models,
        chosen: Option<&Choice>,
        is_traced: bool,
        picture_level: u32,
    ) -> Self {
        let (choice, optics) = (&scene.model, models.optics);
        let usual = match chosen {
            Some(chosen) if !optics.is_mask() => chosen.light,
            _ => {
                // A ray follows no more orders than matter to it, so `exact` bounds them last.
                let most = if choice.preset == Preset::Exact { MOST_ORDERS } else { 2 };
                let orders = if models.primitive == Primitive::Tile { most } else { 0 };
                Light { internal_reflections: orders, ..Light::default() }
            }
        };
        // Under total reflection much light is still inside after eight orders, and would leave where none does. In the few
        // drops of real rain that `fast` traces it is little.
        let usual = match optics {
            Optics::ClosedForm if is_traced => Light { weights: Weights::Physical, ..usual },
            Optics::Appearance if is_traced && scene.real_rain().is_none() => {
                let internal_reflections = usual.internal_reflections.max(MOST_ORDERS);
                Light { weights: Weights::Physical, internal_reflections, ..usual }
            }
            _ => usual,
        };
        let is_tile = models.primitive == Primitive::Tile;
        let in_pictures = if is_tile { MOST_ORDERS } else { usual.internal_reflections };
        Self {
            internal_reflections: choice.internal_reflections.unwrap_or(usual.internal_reflections),
            picture_reflections: choice.internal_reflections.unwrap_or(in_pictures),
            picture_level,
            weights: choice.weights.unwrap_or(usual.weights),
            fresnel: choice.fresnel.unwrap_or(usual.fresnel),
            reflection: choice.reflection.unwrap_or(usual.reflection),
            lookup: choice.lookup.unwrap_or(usual.lookup),
            indices: scene.indices(),
        }
    }
}
