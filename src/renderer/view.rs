//! What has the size of one picture: its targets, the lists of its tiles, and the passes that fill them.

use std::sync::Arc;

use super::display::Display;
use super::drawing::Drawing;
use super::lighting::Lighting;
use super::points::Points;
use super::slot::Slot;
use super::tiled::Tiled;
use super::{FrameInput, FrameReport, ViewInfo};
use crate::gpu::{Device, Recorder, Use, memory_barrier};
use crate::passes::background::Behind;
use crate::passes::drops::guard_band;
use crate::passes::frame::{Frame, FrameBuffer, Surroundings};
use crate::passes::heights::Heights;
use crate::passes::motion_depth::MotionDepth;
use crate::passes::output::Output;
use crate::passes::pane::host::PaneCells;
use crate::passes::particles::Particles;
use crate::passes::rain_field::RainField;
use crate::passes::tile_grid;
use crate::passes::tone_map::{FinalSums, ToneMap};
use crate::picture::tone_map::DELTA;
use crate::plan::FramePlan;
use crate::rain::field::Seen;
use crate::rain::{Tick, tick_of_seconds};
use crate::scene::model::{Primitive, ShapeModel};
use crate::scene::{Scene, projection};
use crate::{Error, Result};

/// What has the size of one picture: passes, targets, lists of tiles. A host records it into its own frames, each with a
/// camera and images of the host's; views of any number share light and rain.
///
/// ```no_run
/// use std::sync::Arc;
///
/// use raindrops::ash::vk;
/// use raindrops::device::{Device, HostImage};
/// use raindrops::environment::Environment;
/// use raindrops::plan::{Output, plan};
/// use raindrops::renderer::{FrameInput, Lighting, RainField, View, ViewInfo};
/// use raindrops::scene::Scene;
///
/// /// Once.
/// fn set_up(device: &Arc<Device>, scene: &Scene) -> raindrops::Result<View> {
///     let environment = Environment::bundled()?;
///     let plan = plan(scene, &environment, Output::Radiance)?;
///     let lighting = Arc::new(Lighting::new(device, &environment)?);
///     let rain = Arc::new(RainField::new(device, scene));
///     View::new(&lighting, &rain, scene, &plan, &ViewInfo::default())
/// }
///
/// /// In each frame.
/// fn draw(
///     view: &mut View,
///     scene: &mut Scene,
///     seconds: f64,
///     (commands, slot): (vk::CommandBuffer, usize),
///     output: HostImage,
/// ) -> raindrops::Result<()> {
///     scene.time = seconds;
///     // SAFETY: the host keeps what `View::record` and `View::retired` ask for: the slot's fence was signalled, the
///     // commands are being recorded, and the image is as it is described.
///     unsafe {
///         view.retired(slot)?;
///         view.record(commands, slot, &FrameInput::new(scene, output))
///     }
/// }
/// ```
pub struct View {
    pub(super) frame_buffer: FrameBuffer,
    pub(super) surroundings: Surroundings,
    pub(super) size: (u32, u32),
    /// Tiles across and down.
    pub(super) lattice: [u32; 2],
    pub(super) slots: Vec<Slot>,
    /// Recordings so far, modulo 2^32 without 0.
    pub(super) recordings: u32,
    /// Time of the stored positions, if there are any.
    stored_at: Option<Tick>,
    pub(super) made_for: Scene,
    pub(super) plan: FramePlan,
    pub(super) lighting: Arc<Lighting>,
    pub(super) rain: Arc<RainField>,
    // Views what `drawing` holds, so it is freed first.
    pub(super) display: Option<Display>,
    pub(super) drawing: Drawing,
    /// The pass into a host's image; none of a renderer's.
    pub(super) output: Option<Output>,
    /// The pass that draws motion and depth of each pixel's nearest drop, where a host asks.
    pub(super) motion_depth: Option<MotionDepth>,
    /// The pass that takes a host's particles, where the scene says that there may be some.
    pub(super) particles: Option<Particles>,
    /// The passes that take a host's drops on the pane, where the scene says that there may be some.
    pub(super) pane_cells: Option<PaneCells>,
    /// The passes that take a host's heights, where the scene says that its shelter is a host's.
    pub(super) heights: Option<Heights>,
    pub(super) info: Option<ViewInfo>,
    pub(super) device: Arc<Device>,
}

/// A frame to be recorded: its scene, its constants, what it shows of real rain, and sums of log luminance in place of
/// its own.
pub(super) struct ViewFrame<'a> {
    scene: &'a Scene,
    /// What is seen where motion ends, and how many seconds later.
    until: (projection::View, f64),
    constants: Frame,
    seen: Option<Seen>,
    sums: Option<&'a FinalSums>,
}

impl<'a> ViewFrame<'a> {
    /// With motion to another view of the scene and time.
    pub fn until(self, view: projection::View, time: f64) -> Self {
        Self { until: (view, time - self.scene.time), ..self }
    }

    /// With drops that are so far from the camera along an axis.
    pub fn reaching(mut self, farthest: f32) -> Self {
        for extent in &mut self.constants.extent[..3] {
            *extent = extent.max(farthest);
        }
        self
    }
}

/// What the device and the environment add to the constants of a frame.
pub(super) fn surroundings(
    lighting: &Lighting,
    scene: &Scene,
    plan: &FramePlan,
) -> Result<Surroundings> {
    let (width, height) = scene.picture_size();
    // Only who draws points asks what the device does with them.
    let point_limit_px = match plan.primitive {
        Primitive::Tile => 0.0,
        _ => guard_band(lighting.device(), width, height)?.1,
    };
    let environment = &lighting.environment;
    let scale = f64::from(environment.radiance_scale);
    let delta = (DELTA * lighting.mean_luminance / scale) as f32;
    Ok(Surroundings {
        point_limit_px,
        texel_angle: environment.texel_angle,
        radiance_scale: environment.radiance_scale,
        least_rest: lighting.least_rest,
        // Where the environment is black, any δ keeps the logarithm finite whose square is no 0: `composite` takes it of
        // two pixels' product.
        delta: delta.max(1e-18),
    })
}

/// Tiles of a scene's picture, across and down; those of the whole, so that their number is not told by its size.
pub(super) fn lattice_of(scene: &Scene) -> [u32; 2] {
    let (first, end) = tile_grid::of_view(&scene.view());
    [end[0] - first[0], end[1] - first[1]]
}

/// What a frame is refused for.
pub(super) fn refuse<T>(problem: &str) -> Result<T> {
    Err(Error::scene("the frame", problem))
}

/// Refuses a frame for the first of these that is so.
pub(super) fn refuse_first(reasons: &[(bool, &str)]) -> Result<()> {
    reasons.iter().find(|(is_so, _)| *is_so).map_or(Ok(()), |(_, problem)| refuse(problem))
}

impl View {
    /// With so many slots, each for a frame that may be under way beside the others.
    pub(super) fn of(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        scene: &Scene,
        plan: &FramePlan,
        slots: usize,
        behind: Option<Behind>,
    ) -> Result<Self> {
        let device = lighting.device();
        if !Arc::ptr_eq(device, rain.device()) || !rain.is_of(scene) {
            return refuse("the rain is of another scene or on another device");
        }
        device.require(&plan.requirements())?;
        let (width, height) = scene.picture_size();
        let frame = FrameBuffer::new(device)?;
        let surroundings = surroundings(lighting, scene, plan)?;
        let drawing = match plan.primitive {
            Primitive::Point | Primitive::Quad => {
                Drawing::Points(Box::new(Points::new(lighting, &frame, scene, plan)?))
            }
            Primitive::Tile => {
                let tiled = Tiled::new(lighting, rain, &frame, scene, plan, behind.as_ref())?;
                Drawing::Tiled(Box::new(tiled))
            }
        };
        let display = match plan.tone_map {
            Some(operator) => {
                let tone_map = ToneMap::new(device, &frame, drawing.source(), operator)?;
                Some(Display::new(device, tone_map, [width, height], plan.log_average)?)
            }
            None => None,
        };
        let (size, lattice) = ((width, height), lattice_of(scene));
        let slots = (0..slots).map(|_| Slot::new(device)).collect::<Result<_>>()?;
        Ok(Self {
            frame_buffer: frame,
            surroundings,
            size,
            lattice,
            slots,
            recordings: 0,
            stored_at: None,
            made_for: scene.clone(),
            plan: plan.clone(),
            lighting: lighting.clone(),
            rain: rain.clone(),
            display,
            drawing,
            output: None,
            motion_depth: None,
            particles: None,
            pane_cells: None,
            heights: None,
            info: None,
            device: device.clone(),
        })
    }

    /// What a frame of `scene` needs to be recorded. `whole`: sums of the picture that it is a part of, and that one's
    /// pixels.
    ///
    /// # Errors
    /// [`Error::Scene`] if the view was made for something else.
    pub(super) fn frame<'a>(
        &self,
        scene: &'a Scene,
        whole: Option<(&'a FinalSums, f32)>,
    ) -> Result<ViewFrame<'a>> {
        self.check(scene)?;
        let mut constants = Frame::new(scene, &self.surroundings, self.stored_at);
        let seen = match &self.drawing {
            Drawing::Tiled(tiled) => {
                tiled.complete(&mut constants);
                tiled.tiles.seen(scene)
            }
            Drawing::Points(_) => {
                let display = self.display.as_ref();
                constants.tiles[0] = display.map_or(0, |display| display.tone_map.count);
                None
            }
        };
        if let Some((_, pixels)) = whole {
            constants.tone[3] = pixels;
        }
        let until = (scene.view(), 0.0);
        Ok(ViewFrame { scene, until, constants, seen, sums: whole.map(|(sums, _)| sums) })
    }

    /// Fails if `scene` is not what the view was made for, but for what may differ from frame to frame.
    pub(super) fn check(&self, scene: &Scene) -> Result<()> {
        let made = &self.made_for;
        if scene.picture_size() != self.size || lattice_of(scene) != self.lattice {
            let ((width, height), (other, high)) = (self.size, scene.picture_size());
            return refuse(&format!(
                "the view was made for {width} x {height} pixels, or for others of a larger picture; the scene has \
                 {other} x {high}"
            ));
        }
        let sums_up = self.display.as_ref().is_none_or(|display| display.log_average);
        refuse_first(&[
            (!self.rain.is_of(scene), "the view was made for other drops, or another seed"),
            (scene.environment != made.environment, "the view was made for another environment"),
            (scene.background != made.background, "the view was made for another background"),
            (scene.shelter != made.shelter, "the view was made for another shelter"),
            (
                scene.host_pane_drops != made.host_pane_drops,
                "the view was made for another number of a host's drops on its pane",
            ),
            (scene.model != made.model, "the view was made for other models"),
            (
                scene.metres != made.metres && self.plan.shape.model != ShapeModel::Sphere,
                "metres: the view was made for drops of other sizes, which have other shapes",
            ),
            (
                scene.is_exposed() && made.shutter() == 0.0,
                "camera: shutter: the view was made for an instant; set a shutter before `plan` and `View::new`, too",
            ),
            (!scene.is_behind_glass(), "pane: the camera is not on its dry side"),
            (
                scene.drawn_lens() != 0.0 && made.camera.aperture == 0.0,
                "camera: aperture: the view was made for a pinhole; set an aperture before `plan` and `View::new`, too",
            ),
            (
                scene.tone_map.derives_exposure() && !sums_up,
                "tone_map: the view was made for a fixed exposure",
            ),
        ])
    }

    /// Shows the drops that are on `scene`'s pane from the next frame on that is recorded.
    ///
    /// # Errors
    /// See [`RainField::on_pane`] and [`Pane::take`](crate::passes::pane::Pane::take).
    pub(super) fn take_on_pane(&mut self, scene: &Scene) -> Result<()> {
        if let Drawing::Tiled(tiled) = &mut self.drawing
            && let Some(pane) = &mut tiled.pane
            && scene.host_pane_drops == 0
        {
            let drops = self.rain.on_pane(scene)?;
            if !pane.shows(&drops) {
                pane.take(&self.device, &drops)?;
            }
        }
        Ok(())
    }

    /// The commands that were recorded last into a slot are on the queue, or have been executed.
    pub(super) fn submitted(&mut self, slot: usize, scene: &Scene) {
        self.executed(slot);
        self.stored_at = Some(tick_of_seconds(scene.time));
    }

    /// What is kept from frame to frame is as the slot's last recording left it, or a later one.
    pub(super) fn executed(&mut self, slot: usize) {
        if let Drawing::Tiled(tiled) = &mut self.drawing {
            tiled.composite.executed(self.slots[slot].recording);
        }
    }

    /// What the slot's last frame counted and took; none if its commands were never executed. They must not be under way.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if its timestamps cannot be read, as for a lost device.
    pub(super) fn report(&self, slot: usize) -> Result<Option<FrameReport>> {
        self.slots[slot].report(&self.drawing, self.plan.room)
    }

    /// Records a frame into a slot whose last commands are done, or will never be submitted.
    pub(super) fn record_frame(
        &mut self,
        commands: Recorder<'_>,
        slot: usize,
        frame: &mut ViewFrame<'_>,
        host: Option<&FrameInput<'_>>,
    ) {
        self.recordings = self.recordings.checked_add(1).unwrap_or(1);
        let (number, slot) = (slot, &mut self.slots[slot]);
        slot.recording = self.recordings;
        slot.cutoff_px = frame.seen.as_ref().map(|seen| seen.cutoff_px);
        frame.constants.seed[3] = slot.recording;
        slot.timestamps.reset();
        let device = &*self.device;
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
        if let Some(input) = host {
            input.background.take(device, commands);
        }
        let time = &mut slot.timestamps;
        if let Some(environment) = host.and_then(|input| input.environment.as_ref()) {
            time.time(commands, "environment", || {
                self.lighting.record(commands, number, environment);
                self.lighting.record_renewed(commands);
            });
        }
        let ViewFrame { scene, until, constants, seen, sums } = frame;
        self.frame_buffer.record(device, commands, constants);
        self.frame_buffer.record_others(device, commands, scene);
        match &mut self.drawing {
            Drawing::Points(points) => {
                points.record_reset(device, commands, scene);
                points.record(device, commands, time);
            }
            Drawing::Tiled(tiled) => {
                let (view, seconds) = &*until;
                tiled.record_reset(device, commands, scene, (view, *seconds), seen.as_ref());
                let particles = host.and_then(|input| input.particles.as_ref());
                if let (Some(pass), Some(particles)) = (&self.particles, particles) {
                    let after = [Use::Uniform, Use::ComputeWrite];
                    memory_barrier(device, commands, &[Use::TransferWrite], &after);
                    let until = (view, *seconds);
                    time.time(commands, "particles", || {
                        pass.record(device, commands, number, scene, until, particles);
                    });
                    let read = [Use::ComputeWrite, Use::ComputeRead];
                    memory_barrier(device, commands, &[Use::ComputeWrite], &read);
                }
                let drops = host.and_then(|input| input.drops_on_pane.as_ref());
                if let (Some(pass), Some(drops)) = (&self.pane_cells, drops) {
                    pass.record_reset(device, commands, drops);
                    let after = [Use::Uniform, Use::ComputeWrite];
                    memory_barrier(device, commands, &[Use::TransferWrite], &after);
                    time.time(commands, "pane drops", || {
                        // Who reads it comes after the barrier of `gather`.
                        pass.record(device, commands, number, scene, drops);
                    });
                }
                let shelter = host.and_then(|input| input.shelter.as_ref());
                if let (Some(pass), Some(map), Some(shelter)) =
                    (&self.heights, tiled.tiles.shelter(), shelter)
                {
                    let (lattices, corners) = (tiled.tiles.lattices(), shelter.sorted());
                    map.record_at(device, commands, scene, lattices, corners);
                    time.time(commands, "shelter", || {
                        pass.record(device, commands, number, map, shelter);
                    });
                }
                tiled.record(device, commands, time, slot.recording, constants, seen.as_ref());
            }
        }
        if let Some(display) = &self.display {
            // A factor of 0: to be derived from the picture.
            let derives_exposure = constants.tone[2] == 0.0;
            self.drawing.record_display(device, commands);
            display.record(device, commands, time, self.drawing.source(), derives_exposure, *sums);
        }
        if let (Some(pass), Some(input)) = (&self.output, host) {
            input.background.give_back(device, commands);
            let image = &input.output;
            self.drawing.record_display(device, commands);
            time.time(commands, "output", || pass.record(device, commands, image));
            if let Some(pass) = &self.motion_depth {
                let images = [&input.nearest_depth, &input.nearest_number].map(Option::as_ref);
                let motion = input.motion.as_ref();
                time.time(commands, "motion and depth", || {
                    pass.record(device, commands, motion, images);
                });
            }
        }
        slot.record_counts(device, commands, &self.drawing, &self.frame_buffer);
    }
}
