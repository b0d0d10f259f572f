//! Texture units: which level is read, explicitly asked for or implied by a derivative, and how finely
//! levels and texels are blended.

use std::sync::Arc;

use ash::vk;
use half::f16;
use serde::Serialize;

use super::canvas::Canvas;
use crate::Result;
use crate::gpu::sets::probe_sample as slot;
use crate::gpu::{
    Bindings, Device, GraphicsPipeline, GraphicsState, Image, ImageInfo, Resource, Sampler, Upload,
    shaders,
};

const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Edge of the texture whose levels are numbered, and its levels.
const EDGE: u32 = 64;
const LEVELS: u32 = 7;
/// Pixels of a row: a sweep of levels from -1/2 to 15 1/2 in 1/32, of places over half a texel.
const WIDTH: u32 = 512;
/// Rows for each scale of the implicit derivative, whole quads.
const BAND: u32 = 2;
/// Scales a level.
const SCALES_A_LEVEL: u32 = 4;

/// What a device's texture units do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sampling {
    /// Largest error of the level where it is given.
    pub explicit_level_error: f32,
    /// Largest error of the level where a derivative implies it.
    pub implicit_level_error: f32,
    /// Distinct blends of two levels, in 32 steps from one to the next.
    pub blends_a_level: u32,
    /// Distinct blends of two texels, in 512 steps from the middle of one to that of the other.
    pub blends_a_texel: u32,
}

/// An image with these texels in all its levels, ready for sampling.
fn texture(device: &Arc<Device>, size: (u32, u32), levels: &[Vec<f16>]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let format = vk::Format::R16G16B16A16_SFLOAT;
    let flat = ImageInfo::flat("probe texture", size.into(), format, usage);
    let image = Image::new(device, &ImageInfo { levels: levels.len() as u32, ..flat })?;
    let mut upload = Upload::new(device, "probe texture", &image)?;
    for (level, values) in (0..).zip(levels) {
        upload.level(level, values, |value| [*value; 4])?;
    }
    upload.end()?;
    Ok(image)
}

impl Sampling {
    /// Probes a device.
    pub(super) fn of(device: &Arc<Device>) -> Result<Self> {
        let numbered: Vec<Vec<f16>> = (0..LEVELS)
            .map(|level| vec![f16::from_f32(level as f32); (EDGE >> level).pow(2) as usize])
            .collect();
        let levels = texture(device, (EDGE, EDGE), &numbered)?;
        let edge = texture(device, (2, 1), &[vec![f16::ZERO, f16::ONE]])?;
        let repeat = vk::SamplerAddressMode::REPEAT;
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let repeating = Sampler::linear(device, "probe levels", repeat, repeat)?;
        let clamped = Sampler::linear(device, "probe edge", clamp, clamp)?;
        let slots = [
            (slot::LEVELS, Resource::Sampled(&levels, &repeating)),
            (slot::EDGE, Resource::Sampled(&edge, &clamped)),
        ];
        let bindings = Bindings::of(device, "probe sampling", &slots)?;
        let stages = [shaders::FULLSCREEN_VERT, shaders::PROBE_SAMPLE_FRAG];
        let state = GraphicsState::triangles(FORMAT);
        let pipeline = GraphicsPipeline::new(device, stages, &bindings, 4, &[], &state)?;

        // From half a level over the finest to half a level short of the coarsest but one.
        let implied: Vec<f32> = (0..SCALES_A_LEVEL * (LEVELS - 2))
            .map(|step| step as f32 / SCALES_A_LEVEL as f32)
            .collect();
        let canvas = Canvas::new(device, (WIDTH, BAND * implied.len() as u32), FORMAT)?;
        let pixels: Vec<[f32; 4]> = canvas.draw(|commands| {
            for (number, level) in (0..).zip(&implied) {
                let scissor = vk::Rect2D {
                    offset: vk::Offset2D { x: 0, y: number * BAND as i32 },
                    extent: vk::Extent2D { width: WIDTH, height: BAND },
                };
                // SAFETY: the command buffer is recorded; the scissor is in the canvas.
                unsafe { device.raw().cmd_set_scissor(commands.raw(), 0, &[scissor]) };
                pipeline.draw_triangle(commands, &bindings, bytemuck::bytes_of(&level.exp2()));
            }
        })?;
        let first = &pixels[..WIDTH as usize];
        let asked = |x: usize| (x as f32 / 32.0 - 0.5).clamp(0.0, (LEVELS - 1) as f32);
        let explicit_level_error = first
            .iter()
            .enumerate()
            .map(|(x, pixel)| (pixel[0] - asked(x)).abs())
            .fold(0.0, f32::max);
        let band = |number: usize| {
            let rows = WIDTH as usize * BAND as usize;
            &pixels[rows * number..rows * (number + 1)]
        };
        let implicit_level_error = implied
            .iter()
            .enumerate()
            .flat_map(|(number, level)| band(number).iter().map(move |p| (p[1] - level).abs()))
            .fold(0.0, f32::max);
        // Levels 0 to 1 begin at pixel 16.
        Ok(Self {
            explicit_level_error,
            implicit_level_error,
            blends_a_level: distinct(first[16..48].iter().map(|pixel| pixel[0])),
            blends_a_texel: distinct(first.iter().map(|pixel| pixel[2])),
        })
    }
}

fn distinct(values: impl Iterator<Item = f32>) -> u32 {
    let mut bits: Vec<u32> = values.map(f32::to_bits).collect();
    bits.dedup();
    bits.len() as u32
}
