//! One frame, top to bottom. Every barrier between passes is here: in `points.rs` for the paper's
//! frame, in `tiled.rs` for the fast one, and for what both share in `view.rs` and [`Renderer::submit`].
//!
//! Four things, none remade when only one after it changes: the [`Device`] with its pipelines; the light
//! ([`Lighting`]); the drops ([`RainField`]); and the view, which has the size of a picture.

mod display;
mod drawing;
mod embed;
mod host_checks;
mod lighting;
pub mod parts;
mod points;
mod slot;
pub mod stages;
#[doc(hidden)]
pub mod tile_stages;
mod tiled;
mod view;

use std::sync::Arc;

use half::f16;

use self::drawing::Drawing;
pub use self::embed::{Blend, FrameInput, HostMotion, ViewInfo};
pub use self::lighting::Lighting;
pub use self::view::View;
use self::view::{lattice_of, refuse};
use crate::environment::Environment;
use crate::gpu::{
    Buffer, Commands, Device, Image, Use, copy_buffer, copy_to_buffer, image_barrier,
    memory_barrier,
};
use crate::passes::background::{BackgroundImages, Behind};
pub use crate::passes::background::{DepthConvention, HostBackground};
use crate::passes::counters::Counts;
pub use crate::passes::environment::lost_light;
pub use crate::passes::heights::HostShelter;
pub use crate::passes::host_records::ParticleCount;
use crate::passes::pane::SeenOnPane;
pub use crate::passes::pane::host::{HostPaneDrops, PaneDropLayout};
pub use crate::passes::particles::{HostParticles, ParticleLayout};
pub use crate::passes::rain_field::RainField;
pub use crate::passes::renewal::{HostEnvironment, LiveInfo};
use crate::passes::tone_map::{FinalSums, further_sums};
use crate::passes::totals::TileCounts;
use crate::picture::Picture;
use crate::picture::layers::Layers;
use crate::picture::plate::Plate;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::{Error, Result};

/// What a renderer that was made for another output has none of.
const NO_LAYERS: &str = "the renderer was not made for layers";

/// Frames that may be under way at once: one is recorded while the other is drawn.
const FLIGHTS: usize = 2;

/// The background of a scene, read and on the device; none if it has none.
///
/// # Errors
/// See [`Plate::open`] and [`BackgroundImages::of_plate`].
pub(crate) fn background_of(
    device: &Arc<Device>,
    scene: &Scene,
) -> Result<Option<Arc<BackgroundImages>>> {
    if scene.background.is_none() {
        return Ok(None);
    }
    let size = (scene.image.width, scene.image.height);
    Ok(Some(Arc::new(BackgroundImages::of_plate(device, &Plate::of(scene)?, size)?)))
}

/// What a finished frame says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameReport {
    /// What was counted of the drops.
    pub counts: Counts,
    /// What the tiles came to; none for a frame without them.
    pub tiles: Option<TileCounts>,
    /// Least radius in pixels of a drop of real rain that was drawn by itself; none without real rain. Over the
    /// plan's where the frame's cells would have been more than can be numbered.
    pub cutoff_px: Option<f32>,
    /// Factor on the room for drops in view and their tile fragments with which it was drawn: 1, or what
    /// [`Renderer::draw`] and [`Renderer::submit`] have made of it.
    pub room: u32,
    /// GPU milliseconds of each pass, in order; empty where the device has no timestamps.
    pub passes_ms: Vec<(&'static str, f64)>,
}

impl FrameReport {
    /// Whether something was lost for which more room can be made.
    pub(crate) fn lacks_room(&self) -> bool {
        self.tiles.is_some_and(|tiles| tiles.lacks_room)
    }
}

/// Renders a scene by a frame plan: one view of some drops in some light, of which other renderers may show the same.
///
/// Device, image size, drops, seed, environment and models are fixed when it is made; camera, time and tone
/// mapping key are taken from the scene of each frame.
pub struct Renderer {
    /// One for each of the view's slots.
    flights: [Commands; FLIGHTS],
    next: usize,
    view: View,
    background: Option<Arc<BackgroundImages>>,
    /// There is no more room to be had.
    is_full: bool,
    /// What layers tell of the last frame's drops on a pane.
    on_pane: Vec<SeenOnPane>,
    /// In place of the frame's own: the sums of the whole picture that it is a part of, and that one's pixels.
    whole_sums: Option<(FinalSums, f32)>,
    // Last: all of the above is freed before it.
    device: Arc<Device>,
}

impl Renderer {
    /// Makes everything that frames of `scene` by `plan` need.
    ///
    /// # Errors
    /// See [`Lighting::new`] and [`Renderer::of`].
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        environment: &Environment,
        plan: &FramePlan,
    ) -> Result<Self> {
        let lighting = Arc::new(Lighting::new(device, environment)?);
        Self::of(&lighting, &Arc::new(RainField::new(device, scene)), scene, plan)
    }

    /// Makes what frames of `scene` by `plan` need beside light and rain that other renderers may show too: what has
    /// the picture's size, and pipelines and tables that no picture on the device has asked for yet.
    ///
    /// # Errors
    /// See [`Plate::open`]; [`Error::Scene`] if the rain is not the scene's, or on another device than the light; [`Error::Limit`] if the
    /// image or the drops are more than the device takes; [`Error::Memory`] if it
    /// has no room for them; [`Error::DeviceLacks`] if it cannot store and filter the mask's format;
    /// [`Error::Vulkan`] if a call fails, a lost device among the reasons ([`Error::is_lost`]).
    pub fn of(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        scene: &Scene,
        plan: &FramePlan,
    ) -> Result<Self> {
        let background = background_of(lighting.device(), scene)?;
        Self::before(lighting, rain, background.as_ref(), scene, plan)
    }

    /// Like [`Renderer::of`], with what is behind the drops on the device already; none: the environment.
    ///
    /// # Errors
    /// Like [`Renderer::of`], but for the background's files.
    pub(crate) fn before(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        background: Option<&Arc<BackgroundImages>>,
        scene: &Scene,
        plan: &FramePlan,
    ) -> Result<Self> {
        if scene.host_particles > 0 || scene.host_pane_drops > 0 {
            return refuse("only frames of a host's show its particles and drops; take a View");
        }
        if scene.host_shelter().is_some() {
            return refuse("only frames of a host's have its shelter; take a View");
        }
        let device = lighting.device();
        let behind = background.map(|images| Behind::Plate(images.clone()));
        Ok(Self {
            flights: [Commands::new(device, "frame")?, Commands::new(device, "frame")?],
            next: 0,
            view: View::of(lighting, rain, scene, plan, FLIGHTS, behind)?,
            background: background.cloned(),
            is_full: false,
            on_pane: Vec::new(),
            whole_sums: None,
            device: device.clone(),
        })
    }

    /// Makes room for twice as many drops in view and tile fragments; whether there was more to be had. The last frame
    /// is gone, but for [`Renderer::display`].
    fn grow(&mut self) -> Result<bool> {
        if self.is_full {
            return Ok(false);
        }
        self.finish()?;
        let plan =
            FramePlan { room: self.view.plan.room.saturating_mul(2), ..self.view.plan.clone() };
        let behind = self.background.as_ref().map(|images| Behind::Plate(images.clone()));
        let view = &self.view;
        let grown = View::of(&view.lighting, &view.rain, &view.made_for, &plan, FLIGHTS, behind);
        let mut grown = match grown {
            Ok(grown) if grown.drawing.has_more_room_than(&view.drawing) => grown,
            // What is lost is counted in each frame's report.
            Ok(_) | Err(Error::Memory { .. } | Error::Limit { .. }) => {
                self.is_full = true;
                return Ok(false);
            }
            Err(error) => return Err(error),
        };
        // Who shows the picture goes on showing the same image.
        if let (Some(new), Some(old)) = (&mut grown.display, &mut self.view.display) {
            std::mem::swap(&mut new.image, &mut old.image);
        }
        grown.recordings = self.view.recordings;
        self.view = grown;
        Ok(true)
    }

    /// Draws a frame as [`Renderer::submit`] records it, with as much room as it takes, and waits for it.
    ///
    /// # Errors
    /// See [`Renderer::submit`] and [`Renderer::finish`].
    pub fn draw(&mut self, scene: &Scene) -> Result<FrameReport> {
        self.draw_until(scene, scene)
    }

    /// Like [`Renderer::draw`], with the motion of [`Renderer::submit_until`].
    ///
    /// # Errors
    /// See [`Renderer::draw`].
    pub fn draw_until(&mut self, scene: &Scene, until: &Scene) -> Result<FrameReport> {
        loop {
            self.submit_until(scene, until)?;
            let report = self.finish()?;
            if !report.lacks_room() || !self.grow()? {
                return Ok(report);
            }
        }
    }

    /// The light, for another renderer.
    pub fn lighting(&self) -> &Arc<Lighting> {
        &self.view.lighting
    }

    /// The drops, for another renderer.
    pub fn rain(&self) -> &Arc<RainField> {
        &self.view.rain
    }

    /// Milliseconds that the tables took which are made once: the environment's levels, the mask or
    /// another table of a drop's light.
    pub fn setup_ms(&self) -> Vec<(&'static str, f64)> {
        let table = self.view.drawing.table_ms();
        [("environment levels", self.view.lighting.environment_ms)]
            .into_iter()
            .chain(table)
            .collect()
    }

    /// Records and submits a frame of `scene`, which may differ in camera, time, key and fixed exposure from the
    /// one that the renderer was made for. Waits for the frame before the last, and returns its report; where that one
    /// lacked room, there is more from this frame on.
    ///
    /// # Errors
    /// [`Error::Scene`] if the scene's size, drops, seed, environment, background or models are not those that the renderer was
    /// made for, or if the frame's exposure is to be derived from the picture and the renderer was made for a fixed
    /// one; [`Error::Vulkan`] if waiting, recording or submitting fails, a lost device among the
    /// reasons ([`Error::is_lost`]).
    pub fn submit(&mut self, scene: &Scene) -> Result<Option<FrameReport>> {
        self.submit_until(scene, scene)
    }

    /// Like [`Renderer::submit`], of a plan for layers: motion is that from `scene` to `until`, which differs from it in
    /// camera and time alone.
    ///
    /// # Errors
    /// See [`Renderer::submit`].
    pub fn submit_until(&mut self, scene: &Scene, until: &Scene) -> Result<Option<FrameReport>> {
        self.view.check(scene)?;
        self.view.take_on_pane(scene)?;
        self.flights[self.next].wait()?;
        let finished = self.view.report(self.next)?;
        if finished.as_ref().is_some_and(FrameReport::lacks_room) {
            self.grow()?;
        }
        let whole = self.whole_sums.as_ref().map(|(sums, pixels)| (sums, *pixels));
        let mut frame = self.view.frame(scene, whole)?.until(until.view(), until.time);
        if let (true, Some(pane)) = (self.view.plan.nearest, self.view.drawing.pane()) {
            self.on_pane = pane.seen(scene, until);
        }
        let commands = &mut self.flights[self.next];
        let recorder = commands.begin()?;
        self.view.record_frame(recorder, self.next, &mut frame, None);
        commands.submit()?;
        // Only now: a frame that could not be submitted has changed nothing.
        self.view.submitted(self.next, scene);
        self.next = (self.next + 1) % FLIGHTS;
        Ok(finished)
    }

    /// Width and height in pixels of what is drawn.
    pub fn size(&self) -> (u32, u32) {
        self.view.size
    }

    /// The last frame's sums of log(delta + luminance): of the paper's frame in no order, of others tile by tile.
    fn read_log_sums(&self) -> Result<Vec<f32>> {
        let tiled = self.view.drawing.tiled().map(|tiled| tiled.log_sums());
        let own = || self.view.display.as_ref().and_then(|display| display.tone_map.own_sums());
        let Some(sums) = tiled.or_else(own) else { return Ok(Vec::new()) };
        let mut all: Vec<f32> = self.read_buffer(sums)?;
        all.truncate(all.len() - further_sums(self.view.lighting.device().report.machine) as usize);
        Ok(all)
    }

    /// The image that holds the display colour of the last submitted frame, as a colour attachment;
    /// none if the renderer was made for a radiance output. Whoever samples it on the same queue
    /// hands it back as a colour attachment.
    pub fn display(&self) -> Option<&Image> {
        self.view.display.as_ref().map(|display| &display.image)
    }

    /// Waits for the last submitted frame and reports on it.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if waiting fails, as for a lost device, or its timestamps cannot be read.
    pub fn finish(&self) -> Result<FrameReport> {
        let last = (self.next + FLIGHTS - 1) % FLIGHTS;
        self.flights[last].wait()?;
        Ok(self.view.report(last)?.unwrap_or_default())
    }

    /// Linear radiance of the last frame, which it waits for.
    ///
    /// # Errors
    /// Like [`Renderer::finish`]; [`Error::Memory`] if there is no room for the copy, [`Error::Vulkan`] if it
    /// fails.
    pub fn read_radiance(&self) -> Result<Picture> {
        let halves: Vec<[f16; 4]> = match &self.view.drawing {
            Drawing::Points(points) => {
                let last = if self.view.display.is_some() {
                    Use::ShaderRead
                } else {
                    Use::ColorAttachment
                };
                self.read_image(&points.radiance, last)?
            }
            Drawing::Tiled(tiled) => self.read_buffer(tiled.radiance())?,
        };
        let scale = self.view.surroundings.radiance_scale;
        let (width, height) = self.view.size;
        let pixels = halves[..width as usize * height as usize]
            .iter()
            .map(|p| glam::Vec3::new(p[0].to_f32(), p[1].to_f32(), p[2].to_f32()) * scale)
            .collect();
        Ok(Picture { width, height, pixels })
    }

    /// The layers of the last frame, which it waits for.
    ///
    /// # Errors
    /// [`Error::Scene`] if the renderer was made for another output; else those of [`Renderer::read_radiance`].
    pub fn read_layers(&self) -> Result<Layers> {
        let Some(tiled) = self.view.drawing.tiled() else { return refuse(NO_LAYERS) };
        let (Some(records), Some(nearest)) = (&tiled.tiles.records, &tiled.composite.nearest)
        else {
            return refuse(NO_LAYERS);
        };
        let (width, height) = self.view.size;
        let pixels = width as usize * height as usize;
        let mut color: Vec<[f16; 4]> = self.read_buffer(tiled.radiance())?;
        color.truncate(pixels);
        let scale = self.view.surroundings.radiance_scale;
        if scale != 1.0 {
            let most = f16::MAX.to_f32();
            let scaled = |light: f16| f16::from_f32((light.to_f32() * scale).min(most));
            for [r, g, b, _] in &mut color {
                [*r, *g, *b] = [*r, *g, *b].map(scaled);
            }
        }
        let records: Vec<[u32; 4]> = self.read_buffer(&records.records)?;
        let nearest: Vec<[u32; 2]> = self.read_buffer(nearest)?;
        let mut layers = Layers { color, ..Layers::empty(width, height) };
        for (at, [record, count]) in nearest.into_iter().take(pixels).enumerate() {
            // `END`, where no drop is, is beyond all.
            let Some([depth, motion, low, high]) = records.get(record as usize) else { continue };
            layers.depth[at] = f32::from_bits(*depth);
            layers.motion[at] = [*motion as u16, (*motion >> 16) as u16].map(f16::from_bits);
            layers.count[at] = count;
            layers.id[at] = u64::from(*low) | u64::from(*high) << 32;
        }
        if let Some(pane) = &tiled.pane {
            let nearest: Vec<[u32; 2]> = self.read_buffer(pane.nearest())?;
            layers.glass = vec![f16::ZERO; pixels];
            for (at, [number, part]) in nearest.into_iter().take(pixels).enumerate() {
                // Beyond all where no drop is. Rain is behind the glass, so a drop on it is the nearest.
                let Some(seen) = self.on_pane.get(number as usize) else { continue };
                layers.glass[at] = f16::from_f32(f32::from_bits(part));
                (layers.depth[at], layers.motion[at]) = (seen.depth, seen.motion);
                layers.id[at] = u64::from(number) + 1;
            }
        }
        Ok(Layers { has_wide_ids: self.view.made_for.real_rain().is_some(), ..layers })
    }

    /// Display colour of the last frame: sRGB, three bytes a pixel, row by row from the top.
    ///
    /// # Errors
    /// [`Error::Scene`] if the renderer was made for a radiance output; else those of
    /// [`Renderer::read_radiance`].
    pub fn read_display(&self) -> Result<Vec<u8>> {
        let Some(display) = &self.view.display else {
            return Err(Error::scene("the frame plan", "it has no display output to read"));
        };
        let pixels: Vec<[u8; 4]> = self.read_image(&display.image, Use::ColorAttachment)?;
        Ok(pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// Drop records of the last frame drawn as points: centre in view space and radius, by index;
    /// radius 0 for those out of view or drawn as quads. Empty without such a frame.
    ///
    /// # Errors
    /// Like [`Renderer::read_radiance`], where there are records to read.
    pub fn read_drops(&self) -> Result<Vec<[f32; 4]>> {
        match &self.view.drawing {
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
        let staging = Buffer::readback(&self.device, "read back", buffer.size)?;
        Commands::once(&self.device, "read back", |commands| {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
            copy_buffer(device, commands, buffer, &staging);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(staging.read(buffer.size as usize / size_of::<T>()))
    }

    /// Copies an image that was last used as `last`, and leaves it so.
    fn read_image<T: bytemuck::Pod>(&self, image: &Image, last: Use) -> Result<Vec<T>> {
        self.finish()?;
        let count = image.width as usize * image.height as usize;
        let bytes = (count * size_of::<T>()) as u64;
        let staging = Buffer::readback(&self.device, "read back", bytes)?;
        let device = &*self.device;
        Commands::once(&self.device, "read back", |commands| {
            image_barrier(device, commands, image, last, Use::TransferRead);
            copy_to_buffer(device, commands, (image, 0), (&staging, 0));
            image_barrier(device, commands, image, Use::TransferRead, last);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        Ok(staging.read(count))
    }
}
