//! float16: how values are rounded into a target, by blending, and by `packHalf2x16`.

use std::sync::Arc;

use ash::vk;
use half::f16;
use serde::Serialize;

use super::canvas::Canvas;
use crate::Result;
use crate::gpu::sets::{constant, probe_half as slot};
use crate::gpu::{
    Alpha, Bindings, Buffer, Device, GraphicsPipeline, GraphicsState, Recorder, Resource, shaders,
};

const HALF: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// How a value between two halves becomes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// To the nearest, ties to even, as IEEE 754 has it.
    Nearest,
    /// Towards zero.
    TowardZero,
    /// Neither.
    Other,
}

/// What a device does with float16.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Halves {
    /// How a value that is written to a colour target is rounded.
    pub written: Rounding,
    /// How `packHalf2x16` rounds.
    pub packed: Rounding,
    /// What a target holds of 65,520, which is nearer to infinity than to the largest half, 65,504.
    pub overflow: f32,
    /// Whether halves under 2^-14 are kept.
    pub keeps_denormals: bool,
    /// Least alpha, as a power of two, that moves a target from 1 towards 2.
    pub least_alpha_log2: i32,
}

/// Values in eighths of a step about 1 and 1000, and their negatives.
fn between() -> Vec<f32> {
    (0..=16)
        .flat_map(|eighth| {
            let part = eighth as f32 / 8.0;
            [1.0 + part / 1024.0, 1000.0 + part / 2.0, -1.0 - part / 1024.0]
        })
        .collect()
}

/// The half next to `value` in the direction of zero.
fn toward_zero(value: f32) -> f16 {
    let nearest = f16::from_f32(value);
    if nearest.to_f32().abs() > value.abs() {
        f16::from_bits(nearest.to_bits() - 1)
    } else {
        nearest
    }
}

/// The rule that turned `values` into `halves`.
pub fn rounding(values: &[f32], halves: &[f16]) -> Rounding {
    let is = |rule: &dyn Fn(f32) -> f16| values.iter().zip(halves).all(|(v, h)| rule(*v) == *h);
    if is(&f16::from_f32) {
        Rounding::Nearest
    } else if is(&toward_zero) {
        Rounding::TowardZero
    } else {
        Rounding::Other
    }
}

impl Halves {
    /// Probes a device.
    pub(super) fn of(device: &Arc<Device>) -> Result<Self> {
        let between = between();
        let count = between.len();
        let mut values = between.clone();
        values.extend([65_520.0, 3.0 * (-24.0f32).exp2(), 1.0]);
        let buffer =
            Buffer::upload(device, "probe", &values, vk::BufferUsageFlags::STORAGE_BUFFER)?;
        let slots = [(slot::VALUES, Resource::Buffer(&buffer))];
        let bindings = Bindings::of(device, "probe halves", &slots)?;
        let pipeline = |format, alpha, packed| {
            let stages = [shaders::FULLSCREEN_VERT, shaders::PROBE_HALF_FRAG];
            let state = GraphicsState { alpha, ..GraphicsState::triangles(format) };
            let constants = [[constant::PACKED, packed]];
            GraphicsPipeline::new(device, stages, &bindings, 8, &constants, &state)
        };
        let size = (values.len() as u32, 1);
        let draw =
            |commands: Recorder<'_>, pipeline: &GraphicsPipeline, alpha_and_scale: [f32; 2]| {
                pipeline.draw_triangle(commands, &bindings, bytemuck::bytes_of(&alpha_and_scale));
            };

        let overwrite = pipeline(HALF, Alpha::Ignored, 0)?;
        let canvas = Canvas::new(device, size, HALF)?;
        let pixels: Vec<[f16; 4]> = canvas.draw(|commands| draw(commands, &overwrite, [1.0; 2]))?;
        let written: Vec<f16> = pixels.iter().map(|pixel| pixel[0]).collect();

        let float = vk::Format::R32G32B32A32_SFLOAT;
        let pack = pipeline(float, Alpha::Ignored, 1)?;
        let wide = Canvas::new(device, size, float)?;
        let pixels: Vec<[f32; 4]> = wide.draw(|commands| draw(commands, &pack, [1.0; 2]))?;
        let packed: Vec<f16> = pixels.iter().map(|p| f16::from_bits(p[0] as u16)).collect();

        let blend = pipeline(HALF, Alpha::Blended, 0)?;
        let mut least_alpha_log2 = 0;
        for log2 in -16..0 {
            let pixels: Vec<[f16; 4]> = canvas.draw(|commands| {
                draw(commands, &overwrite, [1.0, 1.0]);
                draw(commands, &blend, [(log2 as f32).exp2(), 2.0]);
            })?;
            if pixels[count + 2][0] != f16::ONE {
                least_alpha_log2 = log2;
                break;
            }
        }
        Ok(Self {
            written: rounding(&between, &written[..count]),
            packed: rounding(&between, &packed[..count]),
            overflow: written[count].to_f32(),
            keeps_denormals: written[count + 1].to_bits() == 3,
            least_alpha_log2,
        })
    }
}
