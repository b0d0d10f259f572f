//! A view in a host's frame: recorded into the host's commands, drawn into the host's image.

use std::sync::Arc;

use ash::vk;

use super::drawing::Drawing;
use super::host_checks::{check_apart, check_background, check_nearest, check_own, check_shelter};
use super::tiled::Tiled;
use super::view::{View, refuse, refuse_first};
use super::{
    DepthConvention, FrameReport, HostBackground, HostEnvironment, HostPaneDrops, HostParticles,
    HostShelter, Lighting, RainField,
};
use crate::Result;
use crate::gpu::{HostImage, Recorder};
use crate::passes::background::Behind;
use crate::passes::heights::Heights;
pub use crate::passes::motion_depth::HostMotion;
use crate::passes::motion_depth::MotionDepth;
pub use crate::passes::output::Blend;
use crate::passes::output::Output;
use crate::passes::pane::host::PaneCells;
use crate::passes::particles::Particles;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::{Preset, Primitive, Simulation};

/// What a view is made for, beside what it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewInfo {
    /// Frames that the host may have under way at once: the slots of [`View::record`] are 0 up to this, without it.
    pub frames_in_flight: usize,
    /// Format of the images that it is drawn into; by default four float16.
    pub format: vk::Format,
    /// What becomes of what they hold; by default it is overwritten.
    pub blend: Blend,
    /// Whether a picture of the host's is behind the drops, instead of the environment.
    pub has_color: bool,
    /// Whether a depth of the host's hides drops.
    pub has_depth: bool,
    /// Format of the images that the motion of each pixel's nearest drop is drawn into, where that is asked for:
    /// two or four floats.
    pub motion: Option<vk::Format>,
    /// Format of the images that the depth of the nearest drop is drawn into, where that is asked for: a float.
    pub nearest_depth: Option<vk::Format>,
    /// Format of the images that its number in layers is drawn into: one unsigned integer, or two for real rain, whose numbers
    /// have 64 bits.
    pub nearest_number: Option<vk::Format>,
}

impl Default for ViewInfo {
    /// Two frames, in float16, which overwrite; the environment is behind.
    fn default() -> Self {
        let (format, blend) = (vk::Format::R16G16B16A16_SFLOAT, Blend::Replace);
        Self {
            frames_in_flight: 2,
            format,
            blend,
            has_color: false,
            has_depth: false,
            motion: None,
            nearest_depth: None,
            nearest_number: None,
        }
    }
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FrameInput<'a> {
    /// The view's scene, with the camera and the time of this frame. The shutter and the aperture may be over 0 only where they
    /// were in the scene that the view was made for.
    pub scene: &'a Scene,
    /// Where it is drawn.
    pub output: HostImage,
    /// What is behind the drops, as far as [`ViewInfo`] says that there is.
    pub background: HostBackground,
    /// What is around the rain from this frame on, for light that is renewed ([`Lighting::live`]).
    pub environment: Option<HostEnvironment>,
    /// Where the motion of each pixel's nearest drop is drawn, if [`ViewInfo`] says so.
    pub motion: Option<HostMotion>,
    /// Where its depth is drawn: that of its centre along the view axis, in scene units. A pixel without a drop keeps
    /// what it holds.
    pub nearest_depth: Option<HostImage>,
    /// Where its number is drawn.
    pub nearest_number: Option<HostImage>,
    /// Drops of the host's own, if the scene says that there may be some ([`Scene::host_particles`]).
    pub particles: Option<HostParticles>,
    /// Drops of the host's own on the pane, if the scene says that there may be some ([`Scene::host_pane_drops`]).
    pub drops_on_pane: Option<HostPaneDrops>,
    /// What keeps rain off in this frame, if the scene says that it is a host's ([`crate::scene::shelter::Shelter::of_host`]).
    pub shelter: Option<HostShelter>,
}

impl<'a> FrameInput<'a> {
    /// A frame of a scene, into an image.
    pub fn new(scene: &'a Scene, output: HostImage) -> Self {
        Self {
            scene,
            output,
            background: HostBackground::default(),
            environment: None,
            motion: None,
            nearest_depth: None,
            nearest_number: None,
            particles: None,
            drops_on_pane: None,
            shelter: None,
        }
    }

    /// With a picture behind the drops, and the radiance of a 1 in it. It must be another image than the output.
    #[must_use]
    pub fn before(mut self, color: HostImage, radiance: f32) -> Self {
        self.background.color = Some((color, radiance));
        self
    }

    /// With another environment from this frame on, of which drops show what is near in this very frame. Of several views of
    /// the same light always the same one names it, and is recorded first.
    #[must_use]
    pub fn around(mut self, environment: HostEnvironment) -> Self {
        self.environment = Some(environment);
        self
    }

    /// With the motion of each pixel's nearest drop since the frame before, for a temporal upscaler.
    #[must_use]
    pub fn moved(mut self, motion: HostMotion) -> Self {
        self.motion = Some(motion);
        self
    }

    /// With the depth of each pixel's nearest drop.
    #[must_use]
    pub fn nearest(mut self, depth: HostImage) -> Self {
        self.nearest_depth = Some(depth);
        self
    }

    /// With the number of each pixel's nearest drop.
    #[must_use]
    pub fn numbered(mut self, number: HostImage) -> Self {
        self.nearest_number = Some(number);
        self
    }

    /// With drops of the host's own.
    #[must_use]
    pub fn with_particles(mut self, particles: HostParticles) -> Self {
        self.particles = Some(particles);
        self
    }

    /// With drops of the host's own on the pane.
    #[must_use]
    pub fn with_drops_on_pane(mut self, drops: HostPaneDrops) -> Self {
        self.drops_on_pane = Some(drops);
        self
    }

    /// With surfaces that keep rain off.
    #[must_use]
    pub fn under(mut self, shelter: HostShelter) -> Self {
        self.shelter = Some(shelter);
        self
    }

    /// With a depth that hides drops, and what it holds.
    #[must_use]
    pub fn hidden_by(mut self, depth: HostImage, convention: DepthConvention) -> Self {
        self.background.depth = Some((depth, convention));
        self
    }
}

impl View {
    /// Makes everything that frames of `scene` by `plan` need: all memory, pipelines and descriptor sets. What must be
    /// computed or uploaded once is done on the device's queue, under its lock, and waited for.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] if a value of the scene is out of its range, if the rain is not the scene's, for a plan with a display
    /// pass or with positions that go on from frame to frame, for one that does not go with `info`, or for a format that cannot
    /// hold the picture;
    /// [`crate::Error::DeviceLacks`] if the device was made without a feature that the plan needs; else those of
    /// [`super::Renderer::of`].
    pub fn new(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        scene: &Scene,
        plan: &FramePlan,
        info: &ViewInfo,
    ) -> Result<Self> {
        scene.validate("the view")?;
        let ViewInfo { has_color: color, has_depth: depth, frames_in_flight, .. } = *info;
        let nearest = [info.motion, info.nearest_depth, info.nearest_number];
        let has_nearest = nearest.iter().any(Option::is_some);
        let is_tiled = plan.primitive == Primitive::Tile;
        let of_light = lighting.renewal.as_ref().map(|renewal| renewal.info.frames_in_flight);
        refuse_first(&[
            (plan.tone_map.is_some(), "a host maps tones itself; plan for Output::Radiance"),
            (
                plan.simulation == Simulation::Stored,
                "stored positions go on with every frame that is recorded, submitted or not; take simulation integer",
            ),
            (
                (scene.host_particles > 0 || scene.host_pane_drops > 0)
                    && (!is_tiled || scene.model.preset == Preset::Auto),
                "a host's drops are drawn by tiles, and their sizes are not known to auto; take preset fast or exact",
            ),
            (
                plan.draws_pane() && has_nearest,
                "motion, depth and number of the nearest drop leave out those on a pane yet; take out one of the two, or \
                 model.pane = \"none\"",
            ),
            (frames_in_flight == 0, "a host has one frame in flight at least"),
            (
                (color || depth) && !is_tiled,
                "a background is behind tiles; take preset fast, exact or auto",
            ),
            (
                color && plan.layers,
                "layers are over nothing; for a background's colour plan for Output::Radiance",
            ),
            (
                info.blend == Blend::Over && !plan.layers,
                "a picture hides what the output holds; to lay rain over it plan for Output::Layers",
            ),
            (
                of_light.is_some_and(|frames| frames < frames_in_flight),
                "the light was made for fewer frames in flight",
            ),
            (
                has_nearest && !is_tiled,
                "motion, depth and number of the nearest drop are those of tiles; take preset fast, exact or auto",
            ),
        ])?;
        let plan = &FramePlan { nearest: has_nearest, ..plan.clone() };
        let frames = frames_in_flight as u32;
        let behind = (color || depth).then_some(Behind::Host { color, depth, frames });
        let mut view = Self::of(lighting, rain, scene, plan, frames_in_flight, behind)?;
        view.info = Some(*info);
        let source = view.drawing.source();
        let (device, frame) = (&view.device, &view.frame_buffer);
        view.output = Some(Output::new(device, frame, source, info.format, info.blend)?);
        if let Some(Tiled { tiles, composite, pane, .. }) = view.drawing.tiled() {
            let frames = frames_in_flight;
            view.motion_depth = MotionDepth::new(device, frame, tiles, composite, nearest)?;
            view.particles = Particles::new(device, frame, tiles, scene, plan, frames)?;
            if let (Some(pane), 1..) = (pane, scene.host_pane_drops) {
                let counters = &tiles.counters;
                view.pane_cells =
                    Some(PaneCells::new(device, frame, pane, counters, scene, frames)?);
            }
            let renewed = tiles.shelter().filter(|map| map.is_of_host);
            view.heights = renewed.map(|map| Heights::new(device, map, frames)).transpose()?;
        }
        Ok(view)
    }

    /// Records a frame into a host's command buffer, and does nothing else: no submission, no wait, no allocation, no
    /// other queue. `slot` is a free one of the view's; it is taken until [`View::retired`] frees it.
    ///
    /// The commands wait for those of the view that were recorded before them, and for nothing else of the host's than
    /// what the states of its images say. They leave pipelines, descriptor sets, push constants and dynamic state of the
    /// command buffer changed.
    ///
    /// # Errors
    /// [`crate::Error::Scene`], before anything is recorded: if the slot does not exist or is taken, if a value of the scene is
    /// out of its range, if the scene is not the view's but for camera, time and tone mapping key, if an image does not fit, or
    /// if one image is given for two things.
    ///
    /// # Safety
    /// - `commands` is a primary command buffer of the device's queue family, being recorded outside of any rendering or
    ///   render pass.
    /// - It is submitted to the device's queue at most once, or never; those that are submitted are submitted in the order
    ///   in which the view recorded them.
    /// - The images are the host's device's, and as `input` describes them when the commands are executed: of this size,
    ///   format and number of samples, in this layout, used before by no other stages and accesses than stated. They and
    ///   their views live until the slot has retired. Those that are drawn into (output, motion, nearest depth and number) have usage
    ///   `COLOR_ATTACHMENT`, the others `SAMPLED`.
    /// - The buffers of particles and of drops on the pane are the host's device's, as [`HostParticles`] describes them, and live
    ///   until the slot has retired.
    /// - Of the views of a light that is renewed always the same one names an environment; another may once all slots of
    ///   that one have retired.
    /// - The view is dropped when the queue is done with all that it has recorded.
    pub unsafe fn record(
        &mut self,
        commands: vk::CommandBuffer,
        slot: usize,
        input: &FrameInput<'_>,
    ) -> Result<()> {
        let state = self.slot(slot)?;
        if state.ticket.is_some() {
            return refuse(&format!(
                "slot {slot} is taken by a frame that has not retired; call retired({slot}) when its commands are \
                 executed or thrown away"
            ));
        }
        let (Some(output), Some(info)) = (&self.output, self.info) else {
            return refuse("the view was made for no host");
        };
        input.scene.validate("the frame")?;
        let mut frame = self.frame(input.scene, None)?;
        if self.drawing.pane().is_some() && input.scene.pane != self.made_for.pane {
            return refuse(
                "pane: the view shows other drops, or those of another age; call View::renew_pane first",
            );
        }
        output.check(&input.output, self.size)?;
        check_background(&input.background, &info, input.scene)?;
        check_nearest(input, &info, self.size)?;
        check_apart(input)?;
        check_own(self, input)?;
        check_shelter(input, &self.made_for)?;
        if let Some(environment) = &input.environment {
            let Some(renewal) = &self.lighting.renewal else {
                return refuse("the light is not one that is renewed; make it by Lighting::live");
            };
            environment.check(&self.device, &renewal.info)?;
            // SAFETY: the slot is free, so its set is not in use; the host keeps the image until it is free again.
            unsafe { renewal.set_image(slot, environment)? };
        }
        if let Some(HostMotion { camera, time, .. }) = &input.motion {
            let image = input.scene.image;
            frame = frame.until(camera.view(image.width, image.height), *time);
        }
        if let (Some(pass), Some(particles)) = (&self.particles, &input.particles) {
            frame = frame.reaching(particles.farthest(input.scene.camera.position));
            // SAFETY: the slot is free, so its set is not in use; the host keeps the buffers until it is free again.
            unsafe { pass.set_buffers(&self.device, slot, particles)? };
        }
        // SAFETY: by contract.
        let recorder = unsafe { Recorder::of_host(commands) };
        if let Drawing::Tiled(tiled) = &mut self.drawing {
            if let (Some(pass), Some(pane), Some(drops)) =
                (&self.pane_cells, &mut tiled.pane, &input.drops_on_pane)
            {
                pane.bounds = drops.bounds(self.made_for.host_pane_drops);
                // SAFETY: the slot is free, so its set is not in use; the host keeps the buffers until it is free again.
                unsafe { pass.set_buffers(&self.device, slot, drops)? };
            }
            if let (Some(pass), Some(map), Some(shelter)) =
                (&self.heights, tiled.tiles.shelter(), &input.shelter)
            {
                // SAFETY: the slot is free, so its set is not in use; the host keeps the image until it is free again.
                unsafe { pass.set_image(slot, map, shelter)? };
            }
            // SAFETY: the slot is free, so its set is not in use; the host keeps the images until it is free again.
            unsafe { tiled.composite.set_images(slot, &input.background)? };
        }
        self.slots[slot].ticket = Some(self.device.open_ticket());
        self.record_frame(recorder, slot, &mut frame, Some(input));
        Ok(())
    }

    /// The host says that a slot's commands have been executed, or will never be submitted, and gets what the frame
    /// counted: none if it was never executed. If `tiles` of it lacks room, [`View::grow`] makes some. The slot is free from
    /// then on.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] if the view has no such slot; [`crate::Error::Vulkan`] if its timestamps cannot be read, as for a
    /// lost device.
    ///
    /// # Safety
    /// The slot's commands are not on the queue, and will not be.
    pub unsafe fn retired(&mut self, slot: usize) -> Result<Option<FrameReport>> {
        let Some(ticket) = self.slot(slot)?.ticket else { return Ok(None) };
        let report = self.report(slot)?;
        if report.is_some() {
            self.executed(slot);
        }
        self.slots[slot].ticket = None;
        self.device.close_ticket(ticket);
        Ok(report)
    }

    fn slot(&self, slot: usize) -> Result<&super::slot::Slot> {
        let Some(state) = self.slots.get(slot) else {
            return refuse(&format!("there is no slot {slot}: the view has {}", self.slots.len()));
        };
        Ok(state)
    }

    /// Shows the drops that are on the pane in `scene` from the next frame on that is recorded: those of another age, or, where no
    /// rain falls on the pane, those that the host has placed. Frames under way keep theirs. To be called outside of recording, while
    /// the host submits nothing: it allocates, and waits for what it uploads.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] if the scene is another than the view's by more than camera, time and these drops, or if a value is out
    /// of its range; [`crate::Error::Memory`] if the device has no room for the drops.
    pub fn renew_pane(&mut self, scene: &Scene) -> Result<()> {
        scene.validate("the frame")?;
        self.check(scene)?;
        self.take_on_pane(scene)?;
        self.made_for.pane.clone_from(&scene.pane);
        Ok(())
    }

    /// Makes room for twice as many drops in view and tile fragments, by the host's own decision: outside of recording,
    /// since it allocates and waits. Frames that are under way are not disturbed; what they use is freed when their slots
    /// retire.
    ///
    /// # Errors
    /// See [`View::new`].
    pub fn grow(&mut self) -> Result<()> {
        let Some(info) = self.info else {
            return refuse("the view was made for no host");
        };
        let plan = FramePlan { room: self.plan.room.saturating_mul(2), ..self.plan.clone() };
        let grown = Self::new(&self.lighting, &self.rain, &self.made_for, &plan, &info)?;
        let mut before = std::mem::replace(self, grown);
        // Numbers of recordings go on, so that none of before is taken for one of now.
        self.recordings = before.recordings;
        // So do the slots of frames under way.
        for (slot, before) in self.slots.iter_mut().zip(std::mem::take(&mut before.slots)) {
            if before.ticket.is_some() {
                *slot = before;
            }
        }
        Ok(())
    }
}

impl Drop for View {
    fn drop(&mut self) {
        // By contract their commands are done, or will never be submitted.
        let tickets = self.slots.iter().filter_map(|slot| slot.ticket);
        tickets.for_each(|ticket| self.device.close_ticket(ticket));
    }
}
