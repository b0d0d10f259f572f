//! The environment on the device: a latitude-longitude texture with levels for minification.
//!
//! A flat map and not a cube: it holds the file's texels unchanged, so that the finest level is what
//! the truth interpolates, and a fetch costs a third less on CPU drivers. What a flat map lacks, equal
//! footprints up to the poles, its prefilter supplies (`src/environment/levels.rs`).
//!
//! Texels are float16 times a power of two that brings the brightest under float16's largest value, where an
//! overflow to infinity would spread as NaN. Error: 2^-11 relative. But the power is bounded, so that a bright source
//! never takes the digits of what is around it: a texel beyond 10⁹ times the mean of the rest is stored as that
//! much, and [`lost_light`] tells what that leaves out.

use std::sync::Arc;

use ash::vk;
use glam::Vec3;
use half::f16;

use crate::Result;
use crate::environment::Environment;
use crate::environment::levels::for_each_level;
use crate::gpu::{Commands, Device, Image, ImageInfo, Sampler, Upload, Use, image_barrier};

/// Largest radiance that is stored.
const MAX_STORED: f32 = crate::abi::MAX_STORED as f32;

/// Least mean that is stored, of all but small bright sources: float16 steps by 2^-24 there, a thousandth of it.
const LEAST_MEAN: f64 = 1.0 / 32_768.0;

/// Mean of the rest that counts as black beside a source beyond float16: there is nothing to keep.
const BLACK: f64 = 1e-11;

/// Radiance of a stored 1: a power of two, so that texels keep their digits. 1, but for suns beyond float16, and for
/// nights so dark that float16 would lose them.
pub fn stored_scale(environment: &Environment) -> f32 {
    let brightest = environment.max_radiance();
    let exponent = if brightest > MAX_STORED {
        let whole = (brightest / MAX_STORED).log2().ceil();
        let mean = environment.ordinary_luminance();
        let bound = (mean / LEAST_MEAN).log2().floor() as f32;
        if mean > BLACK { whole.min(bound) } else { whole }
    } else if brightest > 0.0 && brightest < 1.0 {
        brightest.log2().floor().max(f32::MIN_EXP as f32)
    } else {
        0.0
    };
    exponent.exp2()
}

/// The part of an environment's light that its texture leaves out, 0 to 1: that of texels too bright to be stored beside
/// the rest. Drops on tiles show it all the same; the sky behind them is white there.
pub fn lost_light(environment: &Environment) -> f64 {
    let most = Vec3::splat(stored_scale(environment) * MAX_STORED);
    if environment.max_radiance() <= most.x {
        return 0.0;
    }
    1.0 - environment.mean_luminance_of(|texel| texel.min(most)) / environment.mean_luminance()
}

/// The environment, ready to be sampled.
pub struct EnvironmentMap {
    /// Radiance over [`EnvironmentMap::radiance_scale`], every level.
    pub image: Image,
    /// Trilinear, around the seam, clamped at the poles.
    pub sampler: Sampler,
    /// Radiance of a stored 1, by [`stored_scale`].
    pub radiance_scale: f32,
    /// Angle of a texel of the finest level, in radians.
    pub texel_angle: f32,
}

impl EnvironmentMap {
    /// A black one of so many rows, which shaders can write.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn black(device: &Arc<Device>, height: u32, radiance_scale: f32) -> Result<Self> {
        use vk::ImageUsageFlags as Usage;
        let usage = Usage::SAMPLED | Usage::STORAGE | Usage::TRANSFER_DST;
        let image = environment_image(device, (2 * height, height), usage)?;
        Commands::once(device, "black environment", |commands| {
            image_barrier(device, commands, &image, Use::Nothing, Use::TransferWrite);
            let range = [vk::ImageSubresourceRange::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .level_count(image.levels)
                .layer_count(1)];
            let (layout, black) =
                (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ClearColorValue::default());
            let raw = image.raw();
            // SAFETY: the image is in this layout, and has these levels.
            unsafe {
                device.raw().cmd_clear_color_image(commands.raw(), raw, layout, &black, &range);
            }
            image_barrier(device, commands, &image, Use::TransferWrite, Use::ShaderRead);
        })?;
        Self::of(device, image, radiance_scale)
    }

    fn of(device: &Arc<Device>, image: Image, radiance_scale: f32) -> Result<Self> {
        let sampler = Sampler::linear(
            device,
            "environment",
            vk::SamplerAddressMode::REPEAT,
            vk::SamplerAddressMode::CLAMP_TO_EDGE,
        )?;
        let texel_angle = std::f32::consts::PI / image.height as f32;
        Ok(Self { image, sampler, radiance_scale, texel_angle })
    }

    /// Prefilters and uploads, divided by `radiance_scale`.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if an edge is over the device's limit for images; [`crate::Error::Memory`]
    /// if the device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        environment: &Environment,
        radiance_scale: f32,
    ) -> Result<Self> {
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let size = (environment.width(), environment.height());
        let image = environment_image(device, size, usage)?;
        let stored = |texel: &Vec3| -> [f16; 4] {
            (*texel / radiance_scale)
                .min(Vec3::splat(MAX_STORED))
                .extend(1.0)
                .to_array()
                .map(f16::from_f32)
        };
        device.count(|made| &mut made.environments);
        let mut upload = Upload::new(device, "environment upload", &image)?;
        let mut level = 0;
        for_each_level(environment, |_, _, texels| {
            upload.level(level, texels, &stored)?;
            level += 1;
            Ok::<_, crate::Error>(())
        })?;
        upload.end()?;
        Self::of(device, image, radiance_scale)
    }
}

/// An image with all levels of an environment.
fn environment_image(
    device: &Arc<Device>,
    size: (u32, u32),
    usage: vk::ImageUsageFlags,
) -> Result<Image> {
    let format = vk::Format::R16G16B16A16_SFLOAT;
    let flat = ImageInfo::flat("environment", size.into(), format, usage);
    Image::new(device, &ImageInfo { levels: size.1.ilog2() + 1, ..flat })
}
