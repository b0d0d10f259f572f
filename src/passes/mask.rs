//! The paper's section 3.2: the mask, ray traced once by `glsl/mask.comp`.
//!
//! Two layers of one mip-mapped image array: reflected direction and Fresnel reflectance;
//! twice-refracted direction and coverage. Level i is not a filtered level 0 but the drop seen from
//! its own distance, half-angle atan(2^-i) (Table I). Where the paper stores zeros beyond the rim,
//! the rim is continued: bilinear filtering with zeros would shorten vectors to 0.07 and let the
//! reflectance fall where it rises to 1. Coverage alone tells the edge: where the paper takes 32 random
//! subsamples of a rim texel, 32 columns of it are each integrated exactly.
//!
//! A *single* mask has every level seen from infinity: what remains of the method without its
//! hierarchy (Rousseau et al. 2006), up to 14° wrong at 4 radii.
//!
//! Cost: 11 dispatches, once. Memory at 1024: 22.4 MB at float16, 44.7 MB at float32. Error: float16
//! directions are off by 0.022° at most; what counts is the bilinear reconstruction of small levels
//! (`docs/method.md`).

use std::sync::Arc;

use ash::vk;

use super::light_constants;
use crate::Result;
use crate::gpu::sets::{group, mask as slot};
use crate::gpu::{
    Bindings, Buffer, Commands, ComputePipeline, Device, Image, ImageInfo, Resource, Sampler, Use,
    copy_to_buffer, image_barrier, memory_barrier, shaders,
};
use crate::optics::level_half_angle;
use crate::plan::Light;
use crate::scene::model::Optics;

/// The mask on the device, ready to be sampled.
pub struct Mask {
    /// Layers: reflection, transmission. Levels: from `size` down to 1.
    pub image: Image,
    /// Trilinear, clamped.
    pub sampler: Sampler,
}

/// A level read back: `size * size` texels a layer, row by row from the top.
pub struct MaskLevel {
    /// Texels an edge.
    pub size: u32,
    /// Reflected direction, Fresnel reflectance.
    pub reflection: Vec<[f32; 4]>,
    /// Twice-refracted direction, coverage.
    pub transmission: Vec<[f32; 4]>,
}

impl Mask {
    /// Traces a mask whose finest level has `size` texels an edge.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLacks`] if the device cannot store and filter the format that the optics need;
    /// [`crate::Error::Limit`] if `size` is over its limit for images; [`crate::Error::Memory`] if it has no
    /// room for the mask; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn trace(device: &Arc<Device>, size: u32, optics: Optics, light: &Light) -> Result<Self> {
        let format = match optics {
            Optics::MaskF32 => vk::Format::R32G32B32A32_SFLOAT,
            Optics::MaskSnorm16 => vk::Format::R16G16B16A16_SNORM,
            _ => vk::Format::R16G16B16A16_SFLOAT,
        };
        let needs = vk::FormatFeatureFlags::STORAGE_IMAGE
            | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
        if !device.format_features(format).contains(needs) {
            let missing = format!("storing and filtering {format:?}, which {optics} needs");
            return Err(device.report.lacking(missing));
        }
        let levels = size.ilog2() + 1;
        let usage = vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC;
        let flat = ImageInfo::flat("mask", [size; 2], format, usage);
        let image = Image::new(device, &ImageInfo { levels, layers: 2, ..flat })?;
        let of_level = |level| [(slot::LEVEL_IMAGE, Resource::Storage(&image, level))];
        let bindings = Bindings::each(device, "mask", levels, of_level)?;
        let constants = light_constants(light);
        let pipeline = ComputePipeline::new(device, shaders::MASK_COMP, &bindings, 8, &constants)?;
        device.count(|made| &mut made.tables);
        Commands::once(device, "mask", |commands| {
            image_barrier(device, commands, &image, Use::Nothing, Use::ComputeWrite);
            for level in 0..levels {
                let half_angle = match optics {
                    Optics::SingleMask => 0.0, // seen from infinity
                    _ => level_half_angle(level),
                };
                let (sine, cosine) = half_angle.sin_cos();
                let groups = (size >> level).div_ceil(group::MASK_COMP[0]);
                let push = [sine as f32, cosine as f32];
                let push = bytemuck::cast_slice(&push);
                pipeline.dispatch(commands, &bindings, level as usize, push, [groups, groups, 1]);
            }
            image_barrier(device, commands, &image, Use::ComputeWrite, Use::GraphicsRead);
        })?;
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler = Sampler::linear(device, "mask", clamp, clamp)?;
        Ok(Self { image, sampler })
    }

    /// Reads a level back.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if there is no room for the copy; [`crate::Error::Vulkan`] if it fails.
    pub fn read(&self, device: &Arc<Device>, level: u32) -> Result<MaskLevel> {
        let size = self.image.width >> level;
        let texels = 2 * size as usize * size as usize;
        let bytes = texels as u64 * self.bytes_a_texel();
        let staging = Buffer::readback(device, "mask read back", bytes)?;
        Commands::once(device, "read mask", |commands| {
            image_barrier(device, commands, &self.image, Use::GraphicsRead, Use::TransferRead);
            copy_to_buffer(device, commands, (&self.image, level), (&staging, 0));
            image_barrier(device, commands, &self.image, Use::TransferRead, Use::GraphicsRead);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        let mut reflection: Vec<[f32; 4]> = match self.image.format {
            vk::Format::R32G32B32A32_SFLOAT => staging.read(texels),
            vk::Format::R16G16B16A16_SNORM => {
                let words: Vec<[i16; 4]> = staging.read(texels);
                let value = |word: i16| (f32::from(word) / 32_767.0).max(-1.0);
                words.iter().map(|texel| texel.map(value)).collect()
            }
            _ => {
                let halves: Vec<[half::f16; 4]> = staging.read(texels);
                halves.iter().map(|texel| texel.map(half::f16::to_f32)).collect()
            }
        };
        let transmission = reflection.split_off(texels / 2);
        Ok(MaskLevel { size, reflection, transmission })
    }

    /// Bytes of texels in all levels and layers.
    pub fn texel_bytes(&self) -> u64 {
        let texel = self.bytes_a_texel();
        (0..self.image.levels)
            .map(|level| 2 * texel * u64::from(self.image.width >> level).pow(2))
            .sum()
    }

    fn bytes_a_texel(&self) -> u64 {
        if self.image.format == vk::Format::R32G32B32A32_SFLOAT { 16 } else { 8 }
    }
}
