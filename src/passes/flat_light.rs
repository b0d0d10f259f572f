//! What far rain shows of bright sources if its drops of over a millimetre are flattened: light of the medium and of the
//! streaks of one colour.
//!
//! Far drops are too small to show their shape, but a flattened one sends a bare sun's light elsewhere than its sphere
//! does. So rain of such drops has a table by direction: rays from each source meet shapes of drops that block as much
//! as each other, and wherever light leaves, it is counted for the direction in which a camera sees it
//! (`glsl/flat_rays.comp`); the sums over solid angle and outline, and what the outside reflects, are the mean light
//! (`glsl/flat_light.comp`). It takes the place of the spheres' light by angle (`bow` in `glints.rs`) so far as drops are
//! flattened. The spheres among the drops keep theirs, and with it sharp bows. Of the environment without its bright
//! sources flattened drops show what spheres do.
//!
//! Error: within 5 % over cones of 12°, where spheres have up to 31 % (`tests/drawn/flat_light.rs`). A direction's
//! light is a mean over some 2°. One mean stands for all sizes, so that the drops nearest to being drawn, which are the
//! larger ones, are as flat as the others. Light has one colour: flattened drops of many sizes have no bows.

use std::sync::Arc;

use ash::vk;

use super::glints::Glints;
use super::light_constants;
use super::shapes::of_diameter;
use crate::Result;
use crate::abi::{FLAT_DIRECTIONS, FLAT_RAYS, FLAT_SHAPES};
use crate::gpu::sets::{flat_light as slot, group};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, memory_barrier,
    shaders,
};
use crate::plan::Light;
use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED};
use crate::scene::Scene;
use crate::scene::model::{DropShape, ShapeModel};

/// The flattened drops of a rain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlatRain {
    /// Diameters in mm of drops that block as much as each other.
    diameters: [f64; FLAT_SHAPES as usize],
    /// Of what all drops block, seen level, the part by those that are spheres.
    round_share: f64,
}

impl FlatRain {
    /// That of a scene's rain; none where its drops are spheres, or are drawn as such because the scene asks.
    pub fn of(scene: &Scene) -> Option<Self> {
        let rain = scene.real_rain()?;
        let law = rain.law();
        let is_flat = rain.shape == DropShape::Equilibrium && law.to > SMALLEST_FLATTENED;
        (is_flat && scene.model.shape != Some(ShapeModel::Sphere)).then(|| Self::of_law(&law))
    }

    fn of_law(law: &Law) -> Self {
        let from = law.from.max(SMALLEST_FLATTENED);
        let share = |number: usize| (number as f64 + 0.5) / f64::from(FLAT_SHAPES);
        let diameters =
            std::array::from_fn(|number| law.quantile_between(2.0, share(number), from, law.to));
        let level = diameters.map(|diameter| Halves::of_diameter(diameter).outline_area(0.0));
        let outline = level.iter().sum::<f64>() / f64::from(FLAT_SHAPES);
        let flat = law.moment_between(2.0, from, law.to) * outline;
        let round = law.moment_between(2.0, law.from, from);
        Self { diameters, round_share: round / (round + flat) }
    }
}

/// The table and the passes that make it.
pub(crate) struct FlatLight {
    /// In the place of [`Glints`]' `bow`: that, so far as drops are spheres, and after it four floats a direction.
    pub table: Buffer,
    most_sources: u32,
    /// Rays by source and direction.
    sums: Buffer,
    bindings: Bindings,
    rays: ComputePipeline,
    light: ComputePipeline,
    _shapes: Buffer,
}

impl FlatLight {
    /// A table that is yet to be recorded, of the sources of `glints`.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        glints: &Glints,
        rain: &FlatRain,
        light: &Light,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let storage = Usage::STORAGE_BUFFER;
        let entries = u64::from(FLAT_DIRECTIONS * FLAT_DIRECTIONS);
        let bytes = glints.bow.size + 16 * entries;
        let table = Buffer::new(device, "flat light", bytes, storage, Memory::Device)?;
        let bytes = 4 * entries * u64::from(glints.count);
        let usage = storage | Usage::TRANSFER_DST;
        let sums = Buffer::new(device, "rays in flat drops", bytes, usage, Memory::Device)?;
        let shapes = rain.diameters.map(|mm| of_diameter(ShapeModel::Equilibrium, mm));
        let shapes = shapes.into_iter().flatten().chain([rain.round_share]);
        let shapes: Vec<f32> = shapes.map(|value| value as f32).collect();
        let shapes = Buffer::upload(device, "shapes of far drops", &shapes, storage)?;
        let slots = [
            (slot::SOURCES, Resource::Buffer(&glints.sources)),
            (slot::FLAT_RAIN, Resource::Buffer(&shapes)),
            (slot::FLAT_SUMS, Resource::Buffer(&sums)),
            (slot::BOW, Resource::Buffer(&glints.bow)),
            (slot::FLAT_LIGHT, Resource::Buffer(&table)),
        ];
        let bindings = Bindings::of(device, "flat light", &slots)?;
        let constants = light_constants(&Light { indices: [light.indices[1]; 3], ..*light });
        let pipeline = |shader| ComputePipeline::new(device, shader, &bindings, 0, &constants);
        let (rays, light) = rayon::join(
            || pipeline(shaders::FLAT_RAYS_COMP),
            || pipeline(shaders::FLAT_LIGHT_COMP),
        );
        Ok(Self {
            table,
            most_sources: glints.count,
            rays: rays?,
            light: light?,
            sums,
            bindings,
            _shapes: shapes,
        })
    }

    /// Records the table, after that of the spheres. What reads it must wait for it.
    pub fn record(&self, device: &Device, commands: Recorder<'_>) {
        let barrier =
            |before: &[Use], after: &[Use]| memory_barrier(device, commands, before, after);
        // Of an earlier frame, where the sources are renewed.
        barrier(&[Use::ComputeWrite, Use::ComputeRead], &[Use::TransferWrite]);
        let raw = self.sums.raw();
        // SAFETY: the command buffer is recorded outside of rendering; it is the whole buffer.
        unsafe { device.raw().cmd_fill_buffer(commands.raw(), raw, 0, vk::WHOLE_SIZE, 0) };
        barrier(&[Use::TransferWrite], &[Use::ComputeWrite, Use::ComputeRead]);
        let rays = 2 * FLAT_SHAPES * FLAT_RAYS / group::FLAT_RAYS_COMP[0];
        let groups = [rays, self.most_sources, 1];
        self.rays.dispatch(commands, &self.bindings, 0, &[], groups);
        barrier(&[Use::ComputeWrite], &[Use::ComputeRead, Use::ComputeWrite]);
        let entries = (self.table.size / 16) as u32;
        let groups = [entries.div_ceil(group::FLAT_LIGHT_COMP[0]), 1, 1];
        self.light.dispatch(commands, &self.bindings, 0, &[], groups);
    }
}
