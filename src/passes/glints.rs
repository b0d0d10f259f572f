//! The images of small bright sources in drops, found instead of met by chance.
//!
//! A drop shows a bare sun on some 10⁻⁵ of its disc. A few rays miss it or make a whole pixel of it, and a mean over the
//! disc makes snow of rain: each of the drop's pixels is white, where one should be. So drops see the
//! environment without its few brightest small parts (`src/environment/bright.rs`), and each of those, taken for a
//! disc, is drawn as a point of light where its image is (`glsl/include/glints.glsl`; the derivation stands in
//! `src/reference/glints.rs`): by the reflection outside and after 0, 1 and 2 internal reflections, which
//! carry all of the light but 0.1 %. That is left out; but large drops show the sun after 3, too, if the model follows so many.
//!
//! - **Splats**: a far drop's images of a source depend on the angle between the two alone. Once an environment,
//!   `far_glints` finds the two brightest at each of 2,048 angles; the others' light is spread over the drop. When the view
//!   turns, `splat_table` puts them beside the colours of a drop's upper and lower half on the screen. `composite` reads a
//!   splat's colours by its direction, and for each source its images by their angle.
//! - **Tile fragments**: `glints` adds the images to the pixels of each large drop after their colours are known. Far
//!   drops under four pixels of radius, nineteen of twenty, have those of the table if any are by internal reflections;
//!   otherwise they are solved, with the drop's true distance. The reflection outside and the way straight through have a
//!   closed form. A source whose image is wide is cut into parts.
//! - **Traced drops**, which are no spheres, show the images outside and straight through where Newton's method finds them
//!   (`glsl/include/shape_images.glsl`). Their rays meet the others. The reference searches for all of them
//!   (`src/reference/flat_glints.rs`).
//!
//! - **Far rain** as a medium shows all images of a source as one mean, by the angle between source and drop (`bow`):
//!   there the bows are, finer than any table of directions. Along streaks of one colour the two brightest draw lines
//!   (`streak_layer.rs`).
//!
//! The light of an image is that of its source's mean magnification, so that a rainbow's has a bound. It goes to
//! one pixel, whole: the box filter of a point. Error: a place is off by up to 0.001 of the radius (of splats see
//! above); a source's shape is a disc.

use std::sync::Arc;

use ash::vk;

use super::appearance::{ALL_DIRECTIONS, FarDrop};
use super::light_constants;
use super::tiles::Tiles;
use crate::Result;
use crate::abi::{BOW_ANGLES, GLINT_ANGLES, Source};
use crate::environment::Environment;
use crate::environment::bright::{Bright, split_off};
use crate::gpu::sets::{constant, glints as slot, group, splat_table as of_splats};
use crate::gpu::{Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, shaders};
use crate::plan::Light;

/// Most sources.
pub const MOST_SOURCES: usize = crate::abi::MOST_SOURCES as usize;

/// Largest angular radius of a source, in radians (2°). Of larger ones the shape is seen in large drops, and they are
/// wide enough for the environment's levels.
const LARGEST_SOURCE: f64 = 0.035;

/// Indices for which the shader finds all images but a thousandth of the light. Other drops show sources as all of the environment.
const INDICES: std::ops::RangeInclusive<f64> = 1.25..=1.41;

/// Bytes an entry of the splats' table, an angle of a source's images, and an angle of the table of bows.
const ENTRY_BYTES: u64 = 16;

/// The environment without its bright sources, where it has any that drops on tiles show apart.
pub fn bright_parts(environment: &Environment) -> Option<Bright> {
    split_off(environment, MOST_SOURCES, |region| {
        region.is_disc() && region.source().radius <= LARGEST_SOURCE
    })
}

/// Whether drops by this model show bright sources apart.
pub fn shows_apart(light: &Light) -> bool {
    light.indices.iter().all(|index| INDICES.contains(index))
}

/// The sources, and their images in far drops.
pub struct Glints {
    /// How many sources there are.
    pub count: u32,
    /// Their number and they themselves, as `Sources` of `glsl/include/sources.glsl` has them.
    pub(super) sources: Arc<Buffer>,
    /// A far drop's images of each source by angle, four words each.
    far_glints: Buffer,
    /// A far drop's mean light from each source by angle, four floats each.
    pub(super) bow: Buffer,
    bindings: Bindings,
    bow_pass: ComputePipeline,
    far: ComputePipeline,
}

/// What splats show in one view.
pub struct SplatTable {
    /// A splat's colours by direction, its glints by angle, four words each (`glsl/splat_table.comp`).
    pub(crate) table: Buffer,
    bindings: Bindings,
    pipeline: ComputePipeline,
}

impl Glints {
    /// The sources of `bright`; none where that is none. `radiance_scale`: radiance of a stored 1.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room for the tables; [`crate::Error::Vulkan`] if the
    /// driver refuses.
    pub fn new(
        device: &Arc<Device>,
        bright: Option<&Bright>,
        radiance_scale: f32,
        light: &Light,
    ) -> Result<Self> {
        let regions = bright.map_or(&[][..], |bright| &bright.regions);
        let mut records = vec![Source::default(); 1 + regions.len()];
        for (record, region) in records[1..].iter_mut().zip(regions) {
            let source = region.source();
            let light = (source.light / f64::from(radiance_scale)).as_vec3();
            record.toward = source.direction.as_vec3().extend(source.radius as f32).to_array();
            record.light = light.extend(0.0).to_array();
        }
        let mut words: Vec<u32> = bytemuck::cast_slice(&records)[4..].to_vec();
        words[..4].copy_from_slice(&[regions.len() as u32, 0, 0, 0]);
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let sources = Buffer::upload_device(device, "bright sources", &words, usage)?;
        Self::of(device, Arc::new(sources), regions.len() as u32, light)
    }

    /// Glints of sources that are written on the device: `most` of them, or fewer.
    ///
    /// # Errors
    /// Like [`Glints::new`].
    pub fn of(
        device: &Arc<Device>,
        sources: Arc<Buffer>,
        most: u32,
        light: &Light,
    ) -> Result<Self> {
        let (count, storage) = (most, vk::BufferUsageFlags::STORAGE_BUFFER);
        let bytes = ENTRY_BYTES * u64::from(GLINT_ANGLES * count.max(1));
        let far_glints = Buffer::new(device, "far glints", bytes, storage, Memory::Device)?;
        let bytes = ENTRY_BYTES * u64::from(BOW_ANGLES * count.max(1));
        let bow = Buffer::new(device, "bow", bytes, storage, Memory::Device)?;
        let slots = [
            (slot::SOURCES, Resource::Buffer(&sources)),
            (slot::FAR_GLINTS_OUT, Resource::Buffer(&far_glints)),
            (slot::BOW_OUT, Resource::Buffer(&bow)),
        ];
        let bindings = Bindings::of(device, "glints", &slots)?;
        let constants = light_constants(light);
        let pipeline = |shader| ComputePipeline::new(device, shader, &bindings, 0, &constants);
        let (far, bow_pass) = (pipeline(shaders::FAR_GLINTS_COMP)?, pipeline(shaders::BOW_COMP)?);
        Ok(Self { count, sources, far_glints, bow, bindings, bow_pass, far })
    }

    /// Records the images in far drops.
    pub fn record(&self, commands: Recorder<'_>) {
        if self.count > 0 {
            let groups = [GLINT_ANGLES * self.count / group::FAR_GLINTS_COMP[0], 1, 1];
            self.far.dispatch(commands, &self.bindings, 0, &[], groups);
            let groups = [(BOW_ANGLES * self.count).div_ceil(group::BOW_COMP[0]), 1, 1];
            self.bow_pass.dispatch(commands, &self.bindings, 0, &[], groups);
        }
    }
}

impl SplatTable {
    /// A table of what a far drop shows, and the far rain of `tiles`.
    ///
    /// # Errors
    /// Like [`Glints::new`].
    pub(crate) fn new(
        device: &Arc<Device>,
        FarDrop { appearance, glints, flat, .. }: &FarDrop,
        tiles: &Tiles,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER | Usage::TRANSFER_SRC;
        let read = [constant::FLAT_RAIN, constant::FLAT_PLACED];
        let constants: Vec<_> =
            tiles.constants.iter().filter(|[id, _]| read.contains(id)).copied().collect();
        let of_all = if flat.is_some() { ALL_DIRECTIONS } else { 0 };
        let entries =
            ALL_DIRECTIONS + crate::abi::MOST_SOURCES + GLINT_ANGLES * glints.count + of_all;
        let bytes = ENTRY_BYTES * u64::from(entries);
        let table = Buffer::new(device, "splat table", bytes, usage, Memory::Device)?;
        let slots = [
            (of_splats::FAR_GLINTS_IN, Resource::Buffer(&glints.far_glints)),
            (of_splats::SPLAT_TABLE, Resource::Buffer(&table)),
            (of_splats::SHAPES, Resource::Buffer(&tiles.shapes.given)),
            // Without flattened drops no shader reads it.
            (
                of_splats::FLAT_LIGHT,
                Resource::Buffer(flat.as_ref().map_or(&appearance.table, |flat| &flat.table)),
            ),
        ];
        let bindings = Bindings::of(device, "splat table", &slots)?.beside(&tiles.shared);
        let shader = shaders::SPLAT_TABLE_COMP;
        let pipeline = ComputePipeline::new(device, shader, &bindings, 0, &constants)?;
        Ok(Self { table, bindings, pipeline })
    }

    /// Records the table for the view of the frame's constants, after the images in far drops and the appearance.
    pub fn record(&self, commands: Recorder<'_>) {
        let groups = [ALL_DIRECTIONS / group::SPLAT_TABLE_COMP[0], 1, 1];
        self.pipeline.dispatch(commands, &self.bindings, 0, &[], groups);
    }
}
