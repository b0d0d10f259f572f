//! A view in a host's frame: recorded into the host's commands, drawn into the host's image.

use std::sync::Arc;

use ash::vk;

use super::view::{Drawing, View, refuse};
use super::{
    DepthConvention, FrameReport, HostBackground, HostEnvironment, HostParticles, Lighting,
    RainField,
};
use crate::gpu::{HostImage, Recorder};
use crate::passes::background::Behind;
pub use crate::passes::motion_depth::HostMotion;
use crate::passes::motion_depth::MotionDepth;
pub use crate::passes::output::Blend;
use crate::passes::output::{FORMATS, Output};
use crate::passes::particles::Particles;
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::{Preset, Primitive, Simulation};
use crate::{Error, Result};

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
    /// [`Error::Scene`] if the rain is not the scene's, for a plan with a display pass or with positions that go on from
    /// frame to frame, for one that does not go with `info`, or for a format that cannot hold the picture;
    /// [`Error::DeviceLacks`] if the device was made without a feature that the plan needs; else those of
    /// [`super::Renderer::of`].
    pub fn new(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        scene: &Scene,
        plan: &FramePlan,
        info: &ViewInfo,
    ) -> Result<Self> {
        if plan.tone_map.is_some() {
            return refuse("a host maps tones itself; plan for Output::Radiance");
        }
        if plan.simulation == Simulation::Stored {
            return refuse(
                "stored positions go on with every frame that is recorded, submitted or not; take simulation integer",
            );
        }
        if scene.host_particles > 0
            && (plan.primitive != Primitive::Tile || scene.model.preset == Preset::Auto)
        {
            return refuse(
                "a host's particles are drawn by tiles, and their sizes are not known to auto; take preset fast or exact",
            );
        }
        if plan.draws_pane() {
            return refuse(
                "a host's frames have no pane yet; take it out of the scene, or model.pane = \"none\"",
            );
        }
        if info.frames_in_flight == 0 {
            return refuse("a host has one frame in flight at least");
        }
        let ViewInfo { has_color: color, has_depth: depth, frames_in_flight, .. } = *info;
        if (color || depth) && plan.primitive != Primitive::Tile {
            return refuse("a background is behind tiles; take preset fast, exact or auto");
        }
        if color && plan.layers {
            return refuse(
                "layers are over nothing; for a background's colour plan for Output::Radiance",
            );
        }
        if info.blend == Blend::Over && !plan.layers {
            return refuse(
                "a picture hides what the output holds; to lay rain over it plan for Output::Layers",
            );
        }
        let of_light = lighting.renewal.as_ref().map(|renewal| renewal.info.frames_in_flight);
        if of_light.is_some_and(|frames| frames < frames_in_flight) {
            return refuse("the light was made for fewer frames in flight");
        }
        let nearest = [info.motion, info.nearest_depth, info.nearest_number];
        if nearest.iter().any(Option::is_some) && plan.primitive != Primitive::Tile {
            return refuse(
                "motion, depth and number of the nearest drop are those of tiles; take preset fast, exact or auto",
            );
        }
        let plan = &FramePlan { nearest: nearest.iter().any(Option::is_some), ..plan.clone() };
        let frames = frames_in_flight as u32;
        let behind = (color || depth).then_some(Behind::Host { color, depth, frames });
        let mut view = Self::of(lighting, rain, scene, plan, frames_in_flight, behind)?;
        view.info = Some(*info);
        let source = view.drawing.source();
        let (device, frame) = (&view.device, &view.frame_buffer);
        view.output = Some(Output::new(device, frame, source, info.format, info.blend)?);
        view.motion_depth = match &view.drawing {
            Drawing::Tiled(tiled) => {
                MotionDepth::new(device, frame, &tiled.tiles, &tiled.composite, nearest)?
            }
            Drawing::Points(_) => None,
        };
        if let Drawing::Tiled(tiled) = &view.drawing {
            let (tiles, frames) = (&tiled.tiles, frames_in_flight);
            view.particles = Particles::new(device, frame, tiles, scene, plan, frames)?;
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
    /// [`Error::Scene`], before anything is recorded: if the slot does not exist or is taken, if a value of the scene is out
    /// of its range, if the scene is not the view's but for camera, time and tone mapping key, if an image does not fit, or
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
    /// - The buffers of particles are the host's device's, as [`HostParticles`] describes them, and live until the slot has
    ///   retired.
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
        output.check(&input.output, self.size)?;
        check_background(&input.background, &info, input.scene)?;
        check_nearest(input, &info, self.size)?;
        check_apart(input)?;
        check_particles(self, input)?;
        if let Some(environment) = &input.environment {
            let Some(renewal) = &self.lighting.renewal else {
                return refuse("the light is not one that is renewed; make it by Lighting::live");
            };
            environment.check(&renewal.info)?;
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
    /// [`Error::Scene`] if the view has no such slot; [`Error::Vulkan`] if its timestamps cannot be read, as for a lost
    /// device.
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

/// Formats that a depth may be in; of those with stencil the view is of depth alone.
const DEPTH_FORMATS: [vk::Format; 8] = [
    vk::Format::D16_UNORM,
    vk::Format::X8_D24_UNORM_PACK32,
    vk::Format::D32_SFLOAT,
    vk::Format::D16_UNORM_S8_UINT,
    vk::Format::D24_UNORM_S8_UINT,
    vk::Format::D32_SFLOAT_S8_UINT,
    vk::Format::R16_SFLOAT,
    vk::Format::R32_SFLOAT,
];

/// Refuses a background that is not what the view was made for, or cannot be read.
fn check_background(background: &HostBackground, info: &ViewInfo, scene: &Scene) -> Result<()> {
    let whole = (scene.image.width, scene.image.height);
    let fits = |name: &str, is: bool, wanted: bool| match (is, wanted) {
        (true, false) => refuse(&format!("the view was made for no background {name}")),
        (false, true) => refuse(&format!("the view was made for a background {name}; name one")),
        _ => Ok(()),
    };
    fits("colour", background.color.is_some(), info.has_color)?;
    fits("depth", background.depth.is_some(), info.has_depth)?;
    let refuse_image =
        |name: &str, problem: String| Err(Error::Scene { place: name.into(), problem });
    if let Some((image, radiance)) = &background.color {
        let name = "the background colour";
        if !FORMATS.contains(&image.format) {
            return refuse_image(name, format!("its format is {:?}, no colour", image.format));
        }
        if !(radiance.is_finite() && *radiance > 0.0) {
            return refuse_image(
                name,
                format!("the radiance of a 1 is {radiance}, not finite and over 0"),
            );
        }
        image.check(name, whole, true)?;
    }
    if let Some((image, convention)) = &background.depth {
        let name = "the background depth";
        if !DEPTH_FORMATS.contains(&image.format) {
            return refuse_image(name, format!("its format is {:?}, no depth", image.format));
        }
        if convention.map.iter().any(|number| !number.is_finite()) {
            return refuse_image(
                name,
                format!("its convention is {:?}, not finite", convention.map),
            );
        }
        image.check(name, whole, true)?;
    }
    Ok(())
}

/// Refuses images of motion and depth that are not what the view was made for, or cannot be drawn into.
fn check_nearest(input: &FrameInput<'_>, info: &ViewInfo, size: (u32, u32)) -> Result<()> {
    let motion = input.motion.map(|motion| motion.image);
    for (name, image, wanted) in [
        ("motion", motion, info.motion),
        ("nearest depth", input.nearest_depth, info.nearest_depth),
        ("nearest number", input.nearest_number, info.nearest_number),
    ] {
        match (image, wanted) {
            (None, None) => {}
            (Some(image), Some(format)) if image.format == format => {
                image.check(name, size, true)?
            }
            (Some(image), Some(format)) => {
                return refuse(&format!(
                    "the format of {name} is {:?}; the view was made for {format:?}",
                    image.format
                ));
            }
            (Some(_), None) => return refuse(&format!("the view was made for no {name}")),
            (None, Some(_)) => {
                return refuse(&format!("the view was made to draw {name}; name an image for it"));
            }
        }
    }
    let Some(HostMotion { camera, time, pixel, .. }) = input.motion else { return Ok(()) };
    if !time.is_finite() || !pixel.iter().all(|part| part.is_finite()) {
        return refuse("motion is since a time or in a unit that is not finite");
    }
    let of_before = |problem| Error::Scene { place: "the frame before".into(), problem };
    camera.validate(input.scene.image).map_err(of_before)
}

/// Refuses particles that the view was not made for, or cannot be read.
fn check_particles(view: &View, input: &FrameInput<'_>) -> Result<()> {
    match (&input.particles, view.made_for.host_particles) {
        (None, 0) => Ok(()),
        (Some(particles), most) if most > 0 => particles.check(&view.device, most),
        (Some(_), _) => {
            refuse("the view was made for no particles; set host_particles of its scene")
        }
        (None, _) => {
            refuse("the view was made for a host's particles; name them, were it a count of 0")
        }
    }
}

/// Refuses one image for two things: it is taken from one layout and handed back in one.
fn check_apart(input: &FrameInput<'_>) -> Result<()> {
    let images = [
        ("the output", Some(input.output)),
        ("the background colour", input.background.color.map(|(image, _)| image)),
        ("the background depth", input.background.depth.map(|(image, _)| image)),
        ("the environment", input.environment.map(|environment| environment.image)),
        ("motion", input.motion.map(|motion| motion.image)),
        ("nearest depth", input.nearest_depth),
        ("nearest number", input.nearest_number),
    ];
    for (number, (name, image)) in images.iter().enumerate() {
        let Some(image) = image else { continue };
        let is_same = |other: &HostImage| other.image == image.image;
        if let Some((other, _)) =
            images[..number].iter().find(|(_, other)| other.as_ref().is_some_and(is_same))
        {
            return refuse(&format!("{other} and {name} are one image; each needs its own"));
        }
    }
    Ok(())
}
