//! The environment from a host's image, within a frame's commands (`glsl/renew_*.comp`): what moves near the rain shows in
//! the drops of the same frame, and nothing is read back.
//!
//! `renew_map` turns a cube map or a latitude-longitude image into the finest level of two maps, float16 in stored units:
//! the whole, which is behind the drops, and the rest, which drops see. `renew_bright` finds the small bright parts and
//! takes them out of the rest: drops show these as points of light (`glints.rs`). `renew_level` blurs each level for the
//! next. Then a far drop's pictures and glints are made as for any environment.
//!
//! Against `src/environment` on the CPU: levels are of float16 instead of float32, an error of 2^-11 relative; a bright
//! part is what is brighter than a bound within some 5° of its brightest texel, instead of the texels that touch, so that of
//! two lamps alike that are nearer to each other neither is a source; the threshold is found in four rounds, enough for a
//! part that outshines the rest a hundred thousand times.

use std::sync::Arc;

use ash::vk;
use glam::Mat3;

use super::environment::EnvironmentMap;
use super::glints::MOST_SOURCES;
use super::output::FORMATS;
use crate::abi::{RenewalPush, STRIDES, Work};
use crate::gpu::sets::{group, renew_bright, renew_level, renew_map};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, HostImage, Memory, Recorder, Resource, Sampler, Use,
    image_barrier, image_discard, memory_barrier, shaders,
};
use crate::{Error, Result};

/// Invocations a workgroup, of each pass.
const GROUP: u32 = group::RENEW_MAP_COMP[0];
const _: () = assert!(GROUP == group::RENEW_BRIGHT_COMP[0] && GROUP == group::RENEW_LEVEL_COMP[0]);
/// Rounds in which the threshold is found; even, so that the last one's number is odd.
const ROUNDS: u32 = 4;
/// Most samples along an edge of a texel of the map.
const MOST_EDGE: u32 = 8;

/// An environment that a host renews.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveInfo {
    /// Rows of the map that it is kept as, 16 to 1024, with twice as many columns. What is smaller than a texel is blurred.
    pub height: u32,
    /// Whether the host's images are cube maps; else latitude-longitude images, as environments in files are.
    pub cube: bool,
    /// Frames that the host may have under way at once.
    pub frames_in_flight: usize,
    /// The largest radiance that is kept, over 32,768; what is brighter is clipped. A power of two.
    pub radiance_scale: f32,
}

impl Default for LiveInfo {
    /// A cube map, kept as 512 x 256 texels, with two frames in flight.
    fn default() -> Self {
        Self { height: 256, cube: true, frames_in_flight: 2, radiance_scale: 1.0 }
    }
}

/// What is around the rain in a frame, in a host's image.
#[derive(Clone, Copy, Debug)]
pub struct HostEnvironment {
    /// The image: a cube view, or one of a latitude-longitude image.
    pub image: HostImage,
    /// From a direction in the rain's world to one in the image's. A cube map has the faces of Vulkan; a latitude-longitude
    /// image has -z in its middle and y up.
    pub to_image: Mat3,
    /// Radiance of a 1.
    pub radiance: f32,
}

impl HostEnvironment {
    /// An image whose directions are those of the rain's world, in the scene's unit of radiance.
    pub fn new(image: HostImage) -> Self {
        Self { image, to_image: Mat3::IDENTITY, radiance: 1.0 }
    }

    /// Refuses what cannot be read on this device as the environment that `info` says.
    pub(crate) fn check(&self, device: &Device, info: &LiveInfo) -> Result<()> {
        let name = "the environment";
        let refuse = |problem: String| Err(Error::scene(name, problem));
        let image = &self.image;
        let (layers, kind) =
            if info.cube { (6, "cube map") } else { (1, "latitude-longitude image") };
        if image.range.layer_count != layers {
            return refuse(format!(
                "{} layers; a {kind} has {layers}, and the light was made for one",
                image.range.layer_count
            ));
        }
        if !FORMATS.contains(&image.format) {
            return refuse(format!("its format is {:?}, no colour", image.format));
        }
        let filtered = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
        if !device.format_features(image.format).contains(filtered) {
            return refuse(format!(
                "the device filters no images of its format, {:?}",
                image.format
            ));
        }
        if image.size.0 == 0 || image.size.1 == 0 {
            return refuse("it has no texels".into());
        }
        let turns = (self.to_image * self.to_image.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-4);
        if !turns {
            return refuse("to_image is neither a rotation nor a mirror".into());
        }
        if !(self.radiance.is_finite() && self.radiance > 0.0) {
            return refuse(format!(
                "the radiance of a 1 is {}, not finite and over 0",
                self.radiance
            ));
        }
        image.check(name, image.size, true)
    }
}

/// The passes, and what they fill.
pub struct Renewal {
    /// What it is for.
    pub info: LiveInfo,
    /// The whole environment, and what drops see of it as a texture.
    pub whole: Arc<EnvironmentMap>,
    /// See above.
    pub rest: Arc<EnvironmentMap>,
    /// The sources that drops show apart, as [`super::glints::Glints`] has them.
    pub sources: Arc<Buffer>,
    sampler: Sampler,
    map: (Bindings, ComputePipeline),
    bright: (Bindings, ComputePipeline),
    levels: (Vec<[Bindings; 2]>, ComputePipeline),
}

impl Renewal {
    /// Maps that are black, and the passes.
    ///
    /// # Errors
    /// [`Error::Scene`] if a number of `info` is out of its range; [`Error::Memory`] if the device has no room for the
    /// maps; [`Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, info: LiveInfo) -> Result<Self> {
        let refuse = |problem: String| Err(Error::scene("the environment", problem));
        if !(16..=1024).contains(&info.height) {
            return refuse(format!("height = {} is not within 16 to 1024", info.height));
        }
        if info.frames_in_flight == 0 {
            return refuse("a host has one frame in flight at least".into());
        }
        let scale = info.radiance_scale;
        if !(scale.is_normal() && scale > 0.0 && scale.log2().fract() == 0.0) {
            return refuse(format!("radiance_scale = {scale} is no power of two"));
        }
        let [whole, rest] = [
            Arc::new(EnvironmentMap::black(device, info.height, scale)?),
            Arc::new(EnvironmentMap::black(device, info.height, scale)?),
        ];
        let words = vec![0u32; 4 + 8 * MOST_SOURCES];
        use vk::BufferUsageFlags as Usage;
        let storage = Usage::STORAGE_BUFFER;
        let usage = storage | Usage::UNIFORM_TEXEL_BUFFER;
        let sources = Arc::new(Buffer::upload_device(device, "bright sources", &words, usage)?);
        let bytes = size_of::<Work>() as u64;
        let work = Buffer::new(device, "bright parts", bytes, storage, Memory::Device)?;
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler =
            Sampler::linear(device, "host's environment", vk::SamplerAddressMode::REPEAT, clamp)?;

        // Until a host names its image, one of ours is there; nothing is dispatched before.
        let sampled = Resource::Sampled(&whole.image, &sampler);
        let slots = [
            (renew_map::HOST_IMAGE, sampled),
            (renew_map::WHOLE, Resource::Storage(&whole.image, 0)),
            (renew_map::REST, Resource::Storage(&rest.image, 0)),
        ];
        let sets = info.frames_in_flight as u32;
        let bindings = Bindings::all(device, "environment renewal", &slots, sets)?;
        let shader = if info.cube { shaders::RENEW_MAP_COMP_CUBE } else { shaders::RENEW_MAP_COMP };
        let push = size_of::<RenewalPush>() as u32;
        let map = (ComputePipeline::new(device, shader, &bindings, push, &[])?, bindings);
        let slots = [
            (renew_bright::REST, Resource::Storage(&rest.image, 0)),
            (renew_bright::SOURCES, Resource::Buffer(&sources)),
            (renew_bright::WORK, Resource::Buffer(&work)),
        ];
        let bindings = Bindings::of(device, "bright parts", &slots)?;
        let shader = shaders::RENEW_BRIGHT_COMP;
        let bright = (ComputePipeline::new(device, shader, &bindings, 8, &[])?, bindings);
        let level = |map: &EnvironmentMap, level| {
            let slots = [
                (renew_level::FINE, Resource::Storage(&map.image, level - 1)),
                (renew_level::COARSE, Resource::Storage(&map.image, level)),
            ];
            Bindings::of(device, "environment level", &slots)
        };
        let all = (1..whole.image.levels)
            .map(|number| Ok([level(&whole, number)?, level(&rest, number)?]));
        let levels: Vec<[Bindings; 2]> = all.collect::<Result<_>>()?;
        let shader = shaders::RENEW_LEVEL_COMP;
        let blur = ComputePipeline::new(device, shader, &levels[0][0], 0, &[])?;
        Ok(Self {
            info,
            whole,
            rest,
            sources,
            sampler,
            map: (map.1, map.0),
            bright: (bright.1, bright.0),
            levels: (levels, blur),
        })
    }

    /// Takes a host's image, which [`HostEnvironment::check`] lets pass, in descriptor set `set`.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the image stays until it is not again.
    pub unsafe fn set_image(&self, set: usize, environment: &HostEnvironment) -> Result<()> {
        let resource = Resource::SampledView(environment.image.view, &self.sampler);
        // SAFETY: by contract.
        unsafe { self.map.0.write(set, renew_map::HOST_IMAGE, &resource) }
    }

    /// Records the maps and the sources from the image of a descriptor set. What follows must wait for compute shaders.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        set: usize,
        environment: &HostEnvironment,
    ) {
        let image = &environment.image;
        let between =
            || memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        let maps = [&self.whole.image, &self.rest.image];
        for map in maps {
            image_discard(device, commands, map, &[Use::ShaderRead], Use::ComputeWrite);
        }
        let (width, height) = (self.whole.image.width, self.whole.image.height);
        let groups = [(width * height).div_ceil(GROUP), 1, 1];

        image.take(device, commands, Use::ComputeRead);
        // There are as many samples as the image has texels: a face of a cube is a quarter of the equator, and its texels are nowhere
        // the map's. An image of the map's size is taken as it is.
        let (across, least) =
            if self.info.cube { (4 * image.size.0, 2) } else { (image.size.0, 1) };
        let column = |number: usize| environment.to_image.col(number).extend(0.0).to_array();
        let push = RenewalPush {
            to_image: [column(0), column(1), column(2)],
            scale: environment.radiance / self.info.radiance_scale,
            edge: across.div_ceil(width).clamp(least, MOST_EDGE),
        };
        let (bindings, pass) = &self.map;
        pass.dispatch(commands, bindings, set, bytemuck::bytes_of(&push), groups);
        image.give_back(device, commands, Use::ComputeRead);

        let (bindings, pass) = &self.bright;
        let strides = [STRIDES / GROUP, 1, 1];
        let step = |number: u32, round: u32, groups| {
            between();
            pass.dispatch(commands, bindings, 0, bytemuck::bytes_of(&[number, round]), groups);
        };
        (0..ROUNDS).for_each(|round| step(0, round, strides));
        for source in 0..MOST_SOURCES as u32 {
            step(1, source, strides);
            step(2, source, strides);
            step(3, source, [1, 1, 1]);
        }
        step(4, 0, groups);

        let (levels, pass) = &self.levels;
        for (number, of_maps) in (1..).zip(levels) {
            between();
            let (width, height) = self.whole.image.level_size(number);
            let groups = [(width * height).div_ceil(GROUP), 1, 1];
            of_maps.iter().for_each(|bindings| pass.dispatch(commands, bindings, 0, &[], groups));
        }
        for map in maps {
            image_barrier(device, commands, map, Use::ComputeWrite, Use::ShaderRead);
        }
        between();
    }
}
