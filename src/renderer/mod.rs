//! One frame, top to bottom. Every barrier between passes is here: in `points.rs` for the paper's
//! frame, in `tiled.rs` for the fast one, and for what both share in [`Renderer::submit`].

pub mod parts;
mod points;
pub mod stages;
mod tiled;

use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use half::f16;

use self::points::Points;
use self::tiled::Tiled;
use crate::environment::Environment;
use crate::gpu::{
    Buffer, Commands, Device, Image, ImageInfo, Memory, Samples, Timestamps, Use, image_barrier,
    image_discard, memory_barrier,
};
use crate::passes::drops::guard_band;
use crate::passes::environment::{EnvironmentMap, stored_scale};
use crate::passes::frame::{Frame, FrameBuffer, Surroundings};
use crate::passes::glints::bright_parts;
use crate::passes::simulate::{Counts, Simulate};
use crate::passes::tiles::{self, TileCounts};
use crate::passes::tone_map::{DELTA, DISPLAY, FinalSums, Source, ToneMap};
use crate::picture::Picture;
use crate::plan::FramePlan;
use crate::rain::{Tick, tick_of_seconds};
use crate::scene::Scene;
use crate::scene::model::Primitive;
use crate::{Error, Result};

/// Frames that may be under way at once: one is recorded while the other is drawn.
const FLIGHTS: usize = 2;

/// What a finished frame says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameReport {
    /// What the simulation counted.
    pub counts: Counts,
    /// What the tiles came to; none for a frame without them.
    pub tiles: Option<TileCounts>,
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
    fn new(device: &Arc<Device>) -> Result<Self> {
        let bytes = 4 * (Simulate::COUNTER_WORDS + tiles::COUNTS.1) as u64;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        Ok(Self {
            commands: Commands::new(device, "frame")?,
            timestamps: Timestamps::new(device)?,
            counters: Buffer::new(device, "counters read back", bytes, usage, Memory::Readback)?,
        })
    }

    /// What the last frame counted and took, once it is done; none before the first.
    fn report(&self, drawing: &Drawing) -> Result<Option<FrameReport>> {
        if !self.timestamps.is_used() {
            return Ok(None);
        }
        let words: Vec<u32> = self.counters.read(Simulate::COUNTER_WORDS + tiles::COUNTS.1);
        let (of_drops, of_tiles) = words.split_at(Simulate::COUNTER_WORDS);
        let counts = drawing.counters().map(|_| Simulate::counts(of_drops)).unwrap_or_default();
        let tiles = drawing.totals().map(|_| TileCounts::of(of_tiles));
        Ok(Some(FrameReport { counts, tiles, passes_ms: self.timestamps.read_ms()? }))
    }
}

/// From a scene to its radiance.
enum Drawing {
    Points(Box<Points>),
    Tiled(Box<Tiled>),
}

impl Drawing {
    fn counters(&self) -> Option<&Buffer> {
        match self {
            Self::Points(points) => points.simulate().map(|simulate| &simulate.counters),
            Self::Tiled(tiled) => Some(&tiled.tiles.counters),
        }
    }

    /// What the tiles' passes hand to each other, counts among it.
    fn totals(&self) -> Option<&Buffer> {
        match self {
            Self::Points(_) => None,
            Self::Tiled(tiled) => Some(tiled.tiles.totals()),
        }
    }
}

/// The pass that turns radiance into display colour, and its target.
struct Display {
    tone_map: ToneMap,
    image: Image,
    /// Whether the frame sums up the logarithms that a derived exposure needs.
    log_average: bool,
}

/// Renders a scene by a frame plan.
///
/// Device, image size, drops, seed and models are fixed when it is made; camera, time and tone
/// mapping key are taken from the scene of each frame.
pub struct Renderer {
    flights: [Flight; FLIGHTS],
    next: usize,
    frame: FrameBuffer,
    surroundings: Surroundings,
    size: (u32, u32),
    /// Tiles across and down.
    lattice: [u32; 2],
    /// In place of the frame's own: the sums of the whole picture that it is a part of, and that one's pixels.
    whole_sums: Option<(FinalSums, f32)>,
    // Views what `drawing` holds, so it is freed first.
    display: Option<Display>,
    drawing: Drawing,
    stored_at: Option<Tick>,
    environment_ms: f64,
    // Sampled by the passes.
    _environment: EnvironmentMap,
    // Last: all of the above is freed before it.
    device: Arc<Device>,
}

/// What the device and the environment add to the constants of a frame. `mean_luminance` is that of the environment
/// without small bright sources, of which one may outshine all the rest.
fn surroundings(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &EnvironmentMap,
    mean_luminance: f64,
) -> Result<Surroundings> {
    let (width, height) = scene.picture_size();
    let (_, point_limit_px) = guard_band(device, width, height)?;
    let scale = f64::from(environment.radiance_scale);
    let delta = (DELTA * mean_luminance / scale) as f32;
    Ok(Surroundings {
        point_limit_px,
        texel_angle: environment.texel_angle,
        radiance_scale: environment.radiance_scale,
        // In an all-black environment any δ keeps the logarithm finite.
        delta: delta.max(f32::MIN_POSITIVE),
    })
}

/// Tiles of a scene's picture, across and down; those of the whole, so that their number is not told by its size.
fn lattice_of(scene: &Scene) -> [u32; 2] {
    let (first, end) = tiles::of_view(&scene.view());
    [end[0] - first[0], end[1] - first[1]]
}

impl Renderer {
    /// Makes everything that frames of `scene` by `plan` need.
    ///
    /// # Errors
    /// [`Error::Limit`] if the image or the drops are more than the device takes; [`Error::Memory`] if it
    /// has no room for them; [`Error::DeviceLacks`] if it cannot store and filter the mask's format;
    /// [`Error::Vulkan`] if a call fails, a lost device among the reasons ([`Error::is_lost`]).
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        environment: &Environment,
        plan: &FramePlan,
    ) -> Result<Self> {
        let (width, height) = scene.picture_size();
        let frame = FrameBuffer::new(device)?;
        let before = Instant::now();
        let bright = bright_parts(environment);
        let rest = bright.as_ref().map_or(environment, |bright| &bright.rest);
        let mean = rest.mean_luminance();
        let environment =
            EnvironmentMap::new(device, environment, stored_scale(environment, mean))?;
        let environment_ms = before.elapsed().as_secs_f64() * 1e3;
        let surroundings = surroundings(device, scene, &environment, mean)?;
        let constants = Frame::new(scene, &surroundings, None);
        let drawing = match plan.primitive {
            Primitive::Point | Primitive::Quad => {
                let points = Points::new(device, scene, &constants, &frame, &environment, plan)?;
                Drawing::Points(Box::new(points))
            }
            Primitive::Tile => {
                let bright = bright.as_ref();
                let tiled =
                    Tiled::new(device, scene, &constants, &frame, &environment, bright, plan)?;
                Drawing::Tiled(Box::new(tiled))
            }
        };
        let display = match plan.tone_map {
            Some(operator) => {
                let source = match &drawing {
                    Drawing::Points(points) => Source::Image(&points.radiance),
                    Drawing::Tiled(tiled) => tiled.composite.source(),
                };
                let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
                    | vk::ImageUsageFlags::TRANSFER_SRC
                    | vk::ImageUsageFlags::SAMPLED;
                let (name, format) = ("display", DISPLAY);
                let samples = Samples::One;
                let info =
                    ImageInfo { name, width, height, levels: 1, layers: 1, format, usage, samples };
                let tone_map = ToneMap::new(device, &frame, source, operator)?;
                let log_average = plan.log_average;
                Some(Display { tone_map, image: Image::new(device, &info)?, log_average })
            }
            None => None,
        };
        Ok(Self {
            flights: [Flight::new(device)?, Flight::new(device)?],
            next: 0,
            frame,
            surroundings,
            size: (width, height),
            lattice: lattice_of(scene),
            whole_sums: None,
            drawing,
            display,
            stored_at: None,
            environment_ms,
            _environment: environment,
            device: device.clone(),
        })
    }

    /// Milliseconds that the tables took which are made once: the environment's levels, the mask or
    /// another table of a drop's light.
    pub fn setup_ms(&self) -> Vec<(&'static str, f64)> {
        let table = match &self.drawing {
            Drawing::Points(points) => points.table_ms(),
            Drawing::Tiled(tiled) => tiled.table_ms,
        };
        [("environment levels", self.environment_ms)].into_iter().chain(table).collect()
    }

    /// Records and submits a frame of `scene`, which may differ in camera, time, key and fixed exposure from the
    /// one that the renderer was made for. Waits for the frame before the last, and returns its report.
    ///
    /// # Errors
    /// [`Error::Scene`] if the frame's exposure is to be derived from the picture and the renderer was made for
    /// a fixed one; [`Error::Vulkan`] if waiting, recording or submitting fails, a lost device among the
    /// reasons ([`Error::is_lost`]).
    pub fn submit(&mut self, scene: &Scene) -> Result<Option<FrameReport>> {
        let derives_exposure = scene.tone_map.derives_exposure();
        if derives_exposure && self.display.as_ref().is_some_and(|display| !display.log_average) {
            let problem = "tone_map: the renderer was made for a fixed exposure".into();
            return Err(Error::Scene { place: "the frame".into(), problem });
        }
        if scene.picture_size() != self.size || lattice_of(scene) != self.lattice {
            let (width, height) = self.size;
            let problem = format!(
                "the renderer was made for {width} x {height} pixels, or for others of a larger picture"
            );
            return Err(Error::Scene { place: "the frame".into(), problem });
        }
        let seen = match &self.drawing {
            Drawing::Tiled(tiled) => tiled.tiles.seen(scene)?,
            Drawing::Points(_) => None,
        };
        let mut frame = Frame::new(scene, &self.surroundings, self.stored_at);
        if let Some((_, pixels)) = &self.whole_sums {
            frame.tone[3] = *pixels;
        }
        self.stored_at = Some(tick_of_seconds(scene.time));
        let device = &*self.device;
        let flight = &mut self.flights[self.next];
        self.next = (self.next + 1) % FLIGHTS;
        let commands = flight.commands.begin()?;
        let finished = flight.report(&self.drawing)?;
        let time = &mut flight.timestamps;
        time.reset();

        // The frame before may still be at work on what this one begins to write.
        memory_barrier(
            device,
            commands,
            &[
                Use::Uniform,
                Use::VertexInput,
                Use::Indirect,
                Use::ComputeWrite,
                Use::ShaderRead,
                Use::TransferRead,
            ],
            &[Use::TransferWrite, Use::ComputeWrite],
        );
        self.frame.record(device, commands, &frame);
        match &mut self.drawing {
            Drawing::Points(points) => {
                points.record_reset(device, commands, scene);
                points.record(device, commands, time);
            }
            Drawing::Tiled(tiled) => {
                tiled.record_reset(device, commands, scene, seen.as_ref());
                tiled.record(device, commands, time, &frame, seen.as_ref());
            }
        }

        if let Some(display) = &self.display {
            let tone_map = &display.tone_map;
            match &self.drawing {
                Drawing::Points(points) => points.record_display(device, commands),
                Drawing::Tiled(tiled) => tiled.record_display(device, commands),
            }
            if let (true, Some((sums, _))) = (derives_exposure, &self.whole_sums) {
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferWrite]);
                tone_map.record_sums(device, commands, sums);
                memory_barrier(device, commands, &[Use::TransferWrite], &[Use::GraphicsRead]);
            } else if derives_exposure {
                time.time(commands, "log luminance", || {
                    tone_map.record_log_luminance(device, commands);
                });
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::GraphicsRead]);
            }
            let before = [Use::TransferRead, Use::ColorAttachment];
            image_discard(device, commands, &display.image, &before, Use::ColorAttachment);
            time.time(commands, "tone map", || tone_map.record(device, commands, &display.image));
        }

        let of_drops = self.drawing.counters().map(|from| (from, 0, 0, Simulate::COUNTER_WORDS));
        let after = 4 * Simulate::COUNTER_WORDS as u64;
        let of_tiles =
            self.drawing.totals().map(|from| (from, tiles::COUNTS.0, after, tiles::COUNTS.1));
        if of_drops.is_some() {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
            for (from, src_offset, dst_offset, words) in of_drops.into_iter().chain(of_tiles) {
                let region = [vk::BufferCopy { src_offset, dst_offset, size: 4 * words as u64 }];
                let to = flight.counters.raw();
                // SAFETY: both buffers hold that many words there, and the barrier above covers the read.
                unsafe { device.raw().cmd_copy_buffer(commands, from.raw(), to, &region) };
            }
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        }
        flight.commands.submit()?;
        Ok(finished)
    }

    /// Width and height in pixels of what is drawn.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The last frame's sums of log(delta + luminance): of the paper's frame in no order, of others tile by tile.
    fn read_log_sums(&self) -> Result<Vec<f32>> {
        let tiled = match &self.drawing {
            Drawing::Tiled(tiled) => Some(&tiled.composite.log_sums),
            Drawing::Points(_) => None,
        };
        let own = || self.display.as_ref().and_then(|display| display.tone_map.own_sums());
        let Some(sums) = tiled.or_else(own) else { return Ok(Vec::new()) };
        let mut all: Vec<f32> = self.read_buffer(sums)?;
        all.truncate(all.len() - size_of::<FinalSums>() / 4);
        Ok(all)
    }

    /// The image that holds the display colour of the last submitted frame, as a colour attachment;
    /// none if the renderer was made for a radiance output. Whoever samples it on the same queue
    /// hands it back as a colour attachment.
    pub fn display(&self) -> Option<&Image> {
        self.display.as_ref().map(|display| &display.image)
    }

    /// Waits for the last submitted frame and reports on it.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if waiting fails, as for a lost device, or its timestamps cannot be read.
    pub fn finish(&self) -> Result<FrameReport> {
        let flight = &self.flights[(self.next + FLIGHTS - 1) % FLIGHTS];
        flight.commands.wait()?;
        Ok(flight.report(&self.drawing)?.unwrap_or_default())
    }

    /// Linear radiance of the last frame, which it waits for.
    ///
    /// # Errors
    /// As [`Renderer::finish`]; [`Error::Memory`] if there is no room for the copy, [`Error::Vulkan`] if it
    /// fails.
    pub fn read_radiance(&self) -> Result<Picture> {
        let halves: Vec<[f16; 4]> = match &self.drawing {
            Drawing::Points(points) => {
                let last =
                    if self.display.is_some() { Use::ShaderRead } else { Use::ColorAttachment };
                self.read_image(&points.radiance, last)?
            }
            Drawing::Tiled(tiled) => self.read_buffer(&tiled.composite.radiance)?,
        };
        let scale = self.surroundings.radiance_scale;
        let (width, height) = self.size;
        let pixels = halves[..width as usize * height as usize]
            .iter()
            .map(|p| glam::Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32()) * scale)
            .collect();
        Ok(Picture { width, height, pixels })
    }

    /// Display colour of the last frame: sRGB, three bytes a pixel, row by row from the top.
    ///
    /// # Errors
    /// [`Error::Scene`] if the renderer was made for a radiance output; else those of
    /// [`Renderer::read_radiance`].
    pub fn read_display(&self) -> Result<Vec<u8>> {
        let Some(display) = &self.display else {
            return Err(Error::Scene {
                place: "the frame plan".into(),
                problem: "it has no display output to read".into(),
            });
        };
        let pixels: Vec<[u8; 4]> = self.read_image(&display.image, Use::ColorAttachment)?;
        Ok(pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// Drop records of the last frame drawn as points: centre in view space and radius, by index;
    /// radius 0 for those out of view or drawn as quads. Empty without such a frame.
    ///
    /// # Errors
    /// As [`Renderer::read_radiance`], where there are records to read.
    pub fn read_drops(&self) -> Result<Vec<[f32; 4]>> {
        match &self.drawing {
            Drawing::Points(points) => points
                .simulate()
                .map_or(Ok(Vec::new()), |simulate| self.read_buffer(&simulate.drops)),
            Drawing::Tiled(_) => Ok(Vec::new()),
        }
    }

    /// Copies a buffer that compute wrote.
    fn read_buffer<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        self.finish()?;
        let device = &*self.device;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let staging = Buffer::new(&self.device, "read back", buffer.size, usage, Memory::Readback)?;
        Commands::once(&self.device, "read back", |commands| {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: buffer.size }];
            // SAFETY: both buffers are that large, and the barrier above covers the read.
            unsafe {
                device.raw().cmd_copy_buffer(commands, buffer.raw(), staging.raw(), &region);
            }
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(staging.read(buffer.size as usize / size_of::<T>()))
    }

    /// Copies an image that was last used as `last`, and leaves it so.
    fn read_image<T: bytemuck::Pod>(&self, image: &Image, last: Use) -> Result<Vec<T>> {
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
