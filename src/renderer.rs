//! One frame, top to bottom: every barrier between passes is here.

use std::sync::Arc;

use ash::vk;

use crate::environment::Environment;
use crate::gpu::{
    Buffer, Commands, Device, Image, ImageInfo, Memory, Timestamps, Use, image_barrier,
    image_discard, memory_barrier,
};
use crate::passes::drops::{Drops, guard_band};
use crate::passes::environment::EnvironmentMap;
use crate::passes::frame::{Frame, FrameBuffer, Surroundings};
use crate::passes::mask::Mask;
use crate::passes::simulate::{Counts, Simulate};
use crate::passes::sky::Sky;
use crate::passes::tone_map::{DELTA, DISPLAY, ToneMap};
use crate::picture::Picture;
use crate::plan::FramePlan;
use crate::rain::{Tick, tick_of_seconds};
use crate::scene::Scene;
use crate::{Error, Result};

/// Frames that may be under way at once: one is recorded while the other is drawn.
const FLIGHTS: usize = 2;

/// Format of the radiance image. Colour is blended in it; the alpha of a drop that is smaller than a
/// pixel is its area, well over float16's resolution in every scene with less than 10⁴ drops behind
/// one pixel.
const RADIANCE: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// What a finished frame says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameReport {
    /// What the simulation counted.
    pub counts: Counts,
    /// GPU milliseconds of each pass, in order; empty where the device has no timestamps.
    pub passes_ms: Vec<(&'static str, f64)>,
}

/// What a frame under way needs for itself.
struct Flight {
    commands: Commands,
    timestamps: Timestamps,
    counters: Buffer,
}

impl Flight {
    /// What the last frame counted and took, once it is done; none before the first.
    fn report(&self, has_drops: bool) -> Result<Option<FrameReport>> {
        if !self.timestamps.is_used() {
            return Ok(None);
        }
        let counts = if has_drops {
            Simulate::counts(&self.counters.read(Simulate::COUNTER_WORDS))
        } else {
            Counts::default()
        };
        Ok(Some(FrameReport { counts, passes_ms: self.timestamps.read_ms()? }))
    }
}

/// The passes that show drops; none in a scene without.
struct Rain {
    simulate: Simulate,
    drops: Drops,
    depth: Image,
}

/// The pass that turns radiance into display colour, and its target.
struct Display {
    tone_map: ToneMap,
    image: Image,
}

/// Renders a scene by a frame plan.
///
/// Device, image size, drop count and models are fixed when it is made; camera, time, seed and tone
/// mapping key are taken from the scene of each frame.
pub struct Renderer {
    flights: [Flight; FLIGHTS],
    next: usize,
    frame: FrameBuffer,
    surroundings: Surroundings,
    radiance: Image,
    sky: Sky,
    rain: Option<Rain>,
    display: Option<Display>,
    stored_at: Option<Tick>,
    // Sampled by the passes.
    _environment: EnvironmentMap,
    _mask: Option<Mask>,
    // Last: all of the above is freed before it.
    device: Arc<Device>,
}

impl Renderer {
    /// Makes everything that frames of `scene` by `plan` need.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        environment: &Environment,
        plan: &FramePlan,
    ) -> Result<Self> {
        let (width, height) = (scene.image.width, scene.image.height);
        let target = |name, format, usage| {
            Image::new(
                device,
                &ImageInfo { name, width, height, levels: 1, layers: 1, format, usage },
            )
        };
        let frame = FrameBuffer::new(device)?;
        let environment = EnvironmentMap::new(device, environment)?;
        let radiance = target(
            "radiance",
            RADIANCE,
            vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::SAMPLED
                | vk::ImageUsageFlags::TRANSFER_SRC,
        )?;
        let sky = Sky::new(device, &frame, &environment, RADIANCE)?;
        let (guard_px, point_limit_px) = guard_band(device, width, height);
        let count = scene.drop_count();
        let mut mask = None;
        let rain = if count > 0 {
            let mask = mask.insert(Mask::trace(device, plan.mask_size, plan.optics)?);
            Some(Rain {
                simulate: Simulate::new(device, &frame, scene, plan.simulation)?,
                drops: Drops::new(device, &frame, &environment, mask, RADIANCE, count, guard_px)?,
                depth: target(
                    "depth",
                    vk::Format::D32_SFLOAT,
                    vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
                )?,
            })
        } else {
            None
        };
        let display = match plan.tone_map {
            Some(operator) => Some(Display {
                tone_map: ToneMap::new(device, &frame, &radiance, operator)?,
                image: target(
                    "display",
                    DISPLAY,
                    vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
                )?,
            }),
            None => None,
        };
        let flight = || {
            Ok(Flight {
                commands: Commands::new(device, "frame")?,
                timestamps: Timestamps::new(device)?,
                counters: Buffer::new(
                    device,
                    "counters read back",
                    4 * Simulate::COUNTER_WORDS as u64,
                    vk::BufferUsageFlags::TRANSFER_DST,
                    Memory::Readback,
                )?,
            })
        };
        let surroundings = Surroundings {
            point_limit_px,
            texel_angle: environment.texel_angle,
            radiance_scale: environment.radiance_scale,
            delta: (DELTA * environment.mean_luminance / f64::from(environment.radiance_scale))
                .max(f64::from(f32::MIN_POSITIVE)) as f32,
        };
        Ok(Self {
            flights: [flight()?, flight()?],
            next: 0,
            frame,
            surroundings,
            radiance,
            sky,
            rain,
            display,
            stored_at: None,
            _environment: environment,
            _mask: mask,
            device: device.clone(),
        })
    }

    /// Records and submits a frame of `scene`, which may differ in camera, time, seed and key from
    /// the one that the renderer was made for. Waits for the frame before the last, and returns its
    /// report.
    pub fn submit(&mut self, scene: &Scene) -> Result<Option<FrameReport>> {
        let frame = Frame::new(scene, &self.surroundings, self.stored_at);
        self.stored_at = Some(tick_of_seconds(scene.time));
        let device = &*self.device;
        let flight = &mut self.flights[self.next];
        self.next = (self.next + 1) % FLIGHTS;
        let commands = flight.commands.begin()?;
        let finished = flight.report(self.rain.is_some())?;
        let time = &mut flight.timestamps;
        time.reset();

        // The frame before may still be read from.
        memory_barrier(
            device,
            commands,
            &[Use::Uniform, Use::VertexInput, Use::Indirect, Use::ComputeWrite, Use::TransferRead],
            &[Use::TransferWrite, Use::ComputeWrite],
        );
        self.frame.record(device, commands, &frame);
        if let Some(rain) = &self.rain {
            rain.simulate.record_reset(device, commands);
        }

        // A pass's time includes the wait for its input: drivers that defer drawing do it there.
        time.time(commands, "simulate", || {
            let written = [Use::Uniform, Use::ComputeWrite];
            memory_barrier(device, commands, &[Use::TransferWrite], &written);
            if let Some(rain) = &self.rain {
                rain.simulate.record(device, commands);
            }
        });
        if let Some(rain) = &self.rain {
            memory_barrier(
                device,
                commands,
                &[Use::ComputeWrite],
                &[Use::VertexInput, Use::Indirect, Use::TransferRead],
            );
        }

        let readers = [Use::ComputeRead, Use::GraphicsRead, Use::TransferRead];
        image_discard(device, commands, &self.radiance, &readers, Use::ColorAttachment);
        time.time(commands, "sky", || self.sky.record(device, commands, &self.radiance));

        if let Some(rain) = &self.rain {
            time.time(commands, "drops", || {
                let drawn = Use::ColorAttachment;
                image_barrier(device, commands, &self.radiance, drawn, drawn);
                let depth = Use::DepthAttachment;
                image_discard(device, commands, &rain.depth, &[depth], depth);
                rain.drops.record(device, commands, &rain.simulate, &self.radiance, &rain.depth);
            });
        }

        if let Some(display) = &self.display {
            let tone_map = &display.tone_map;
            image_barrier(device, commands, &self.radiance, Use::ColorAttachment, Use::ShaderRead);
            if tone_map.needs_log_average() {
                time.time(commands, "log luminance", || {
                    tone_map.record_log_luminance(device, commands);
                });
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::GraphicsRead]);
            }
            let readers = [Use::TransferRead];
            image_discard(device, commands, &display.image, &readers, Use::ColorAttachment);
            time.time(commands, "tone map", || tone_map.record(device, commands, &display.image));
        }

        if let Some(rain) = &self.rain {
            let region =
                [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: flight.counters.size }];
            let (from, to) = (rain.simulate.counters.raw(), flight.counters.raw());
            // SAFETY: both buffers are that large; the barrier after the simulation covers the read.
            unsafe { device.raw().cmd_copy_buffer(commands, from, to, &region) };
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        }
        flight.commands.submit()?;
        Ok(finished)
    }

    /// Waits for the last submitted frame and reports on it.
    pub fn finish(&self) -> Result<FrameReport> {
        let flight = &self.flights[(self.next + FLIGHTS - 1) % FLIGHTS];
        flight.commands.wait()?;
        Ok(flight.report(self.rain.is_some())?.unwrap_or_default())
    }

    /// Linear radiance of the last frame.
    pub fn read_radiance(&self) -> Result<Picture> {
        let last = if self.display.is_some() { Use::ShaderRead } else { Use::ColorAttachment };
        let scale = self.surroundings.radiance_scale;
        let halves: Vec<[half::f16; 4]> = self.read(&self.radiance, last)?;
        let pixels = halves
            .iter()
            .map(|p| glam::Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32()) * scale)
            .collect();
        Ok(Picture { width: self.radiance.width, height: self.radiance.height, pixels })
    }

    /// Display colour of the last frame: sRGB, three bytes a pixel, row by row from the top.
    ///
    /// # Errors
    /// If the renderer was made for a radiance output.
    pub fn read_display(&self) -> Result<Vec<u8>> {
        let Some(display) = &self.display else {
            return Err(Error::Scene {
                place: "the frame plan".into(),
                problem: "it has no display output to read".into(),
            });
        };
        let pixels: Vec<[u8; 4]> = self.read(&display.image, Use::ColorAttachment)?;
        Ok(pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// Drop records of the last frame: centre in view space and radius, by index; radius 0 for those
    /// out of view or drawn as quads.
    pub fn read_drops(&self) -> Result<Vec<[f32; 4]>> {
        self.finish()?;
        let Some(rain) = &self.rain else { return Ok(Vec::new()) };
        let drops = &rain.simulate.drops;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let staging =
            Buffer::new(&self.device, "drops read back", drops.size, usage, Memory::Readback)?;
        Commands::once(&self.device, "read drops", |commands| {
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: drops.size }];
            // SAFETY: both buffers are that large; the frame is done and was made available by its
            // last barrier but for this read, which the next frame's first barrier waits for.
            unsafe {
                self.device.raw().cmd_copy_buffer(commands, drops.raw(), staging.raw(), &region);
            }
            memory_barrier(&self.device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(staging.read((drops.size / 16) as usize))
    }

    /// Copies an image that was last used as `last`, and leaves it so.
    fn read<T: bytemuck::Pod>(&self, image: &Image, last: Use) -> Result<Vec<T>> {
        self.finish()?;
        let count = image.width as usize * image.height as usize;
        let bytes = (count * size_of::<T>()) as u64;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let staging = Buffer::new(&self.device, "read back", bytes, usage, Memory::Readback)?;
        let device = &*self.device;
        Commands::once(&self.device, "read back", |commands| {
            image_barrier(device, commands, image, last, Use::TransferRead);
            // SAFETY: the buffer holds the image, which is in this layout.
            unsafe {
                device.raw().cmd_copy_image_to_buffer(
                    commands,
                    image.raw(),
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                    staging.raw(),
                    &[image.level_copy(0, 0)],
                );
            }
            image_barrier(device, commands, image, Use::TransferRead, last);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(staging.read(count))
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // Frames under way use what is about to be freed; a lost device has none.
        let _ = self.device.wait_idle();
    }
}
