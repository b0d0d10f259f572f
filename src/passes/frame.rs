//! What every pass of a frame needs to know: the constants of `glsl/include/frame.glsl`.
//!
//! Written into the command buffer by an update, so that frames in flight need no copies of it.

use std::mem::offset_of;
use std::sync::Arc;

use ash::vk;
use glam::{DVec2, DVec3, Vec3};

use crate::Result;
pub use crate::abi::Frame;
use crate::abi::{Constants, IS_PLACED, MOST_POPULATIONS, Population};
use crate::gpu::{Buffer, Device, Memory, Recorder, update_buffer};
use crate::rain::cull::Sight;
use crate::rain::{Rain, Tick, tick_of_seconds};
use crate::scene::Scene;
use crate::scene::projection::View;

/// What the device and the environment add to a scene.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Largest diameter of a point, in pixels.
    pub point_limit_px: f32,
    /// Angle of an environment texel, in radians.
    pub texel_angle: f32,
    /// Radiance of a stored 1.
    pub radiance_scale: f32,
    /// Share of a ray's light under which it is followed no further.
    pub least_rest: f32,
    /// Delta of the log average, in stored units.
    pub delta: f32,
}

impl Frame {
    /// Where the number of the recording stands, in bytes.
    pub(crate) const RECORDING: u64 = std::mem::offset_of!(Frame, seed) as u64 + 12;

    /// The constants of `scene`. `last_tick` is the time of the stored positions, if there are any.
    pub fn new(scene: &Scene, around: &Surroundings, last_tick: Option<Tick>) -> Self {
        let view = scene.view();
        let sight = Sight::of(scene);
        let with = |v: Vec3, w: f32| [v.x, v.y, v.z, w];
        let tick = drawn_tick(scene);
        let is_exposed = if scene.is_exposed() { 1.0 } else { 0.0 };
        let populations = scene.populations();
        let least_radius =
            populations.iter().map(|rain| rain.radius).fold(scene.least_placed_radius(), f64::min);
        let mut frame = Self {
            right: with(sight.axes[0], 0.0),
            up: with(sight.axes[1], 0.0),
            back: with(sight.axes[2], 0.0),
            shift: [0, 0, 0, scene.drop_count()],
            seed: [scene.seed as u32, (scene.seed >> 32) as u32, last_tick.is_none().into(), 0],
            camera_high: with(sight.position[0], sight.near),
            camera_low: with(sight.position[1], scene.camera.near_fade as f32),
            extent: [0.0, 0.0, 0.0, least_radius as f32],
            image: [
                view.whole[0] as f32,
                view.whole[1] as f32,
                view.focal_px as f32,
                around.point_limit_px,
            ],
            window: [view.origin[0], view.origin[1], view.width, view.height],
            principal: principal(&view),
            frustum_x: sight.frustum_x,
            frustum_y: sight.frustum_y,
            environment: [around.texel_angle, around.radiance_scale, around.least_rest, 0.0],
            tone: [
                scene.tone_map.key as f32,
                around.delta,
                stored_exposure(scene, around),
                view.width as f32 * view.height as f32,
            ],
            moved: [0.0, 0.0, 0.0, is_exposed],
            lens: lens(&sight, view.focal_px),
            ..Self::default()
        };
        if scene.real_rain().is_some() {
            frame.camera_place[3] = IS_PLACED;
        }
        if let Some(rain) = populations.first() {
            let first = population_of(rain, scene, scene.random_count());
            let Population {
                units, camera_place, shift: [x, y, z, _], moved: [a, b, c, _], ..
            } = first;
            (frame.units, frame.camera_place) = (units, camera_place);
            frame.shift = [x, y, z, scene.drop_count()];
            frame.moved = [a, b, c, is_exposed];
            frame.seed[..2].copy_from_slice(&first.seed[..2]);
            let extent =
                populations.iter().fold(DVec3::ZERO, |most, rain| most.max(rain.half_extent));
            frame.extent = with(extent.as_vec3(), least_radius as f32);
            let seconds =
                last_tick.map_or(0.0, |last| (tick - last) as f64 / crate::rain::TICKS_PER_SECOND);
            // A jump is a long step; whole boxes of it are taken out here, in float64.
            let boxes = rain.velocity * seconds / (2.0 * rain.half_extent);
            let step: DVec3 = (boxes - boxes.round()) * 2.0 * rain.half_extent;
            frame.motion = with(step.as_vec3(), 0.0);
        }
        frame
    }
}

/// The time of the drops' places.
fn drawn_tick(scene: &Scene) -> Tick {
    tick_of_seconds(scene.drawn_time())
}

/// What the shaders know of a population of random drops. `number`: of its first drop; of the first population, of all.
fn population_of(rain: &Rain, scene: &Scene, number: u32) -> Population {
    let with = |[x, y, z]: [u32; 3], w: u32| [x, y, z, w];
    let [x, y, z] = rain.units().to_array();
    let moved = scene.drawn_motion_of(rain.velocity).as_vec3();
    Population {
        units: [x, y, z, rain.radius as f32],
        camera_place: with(rain.camera_place(scene.drawn_position()), number),
        shift: with(rain.shift(drawn_tick(scene)), 0),
        seed: [rain.seed as u32, (rain.seed >> 32) as u32, 0, 0],
        moved: moved.extend(0.0).to_array(),
    }
}

/// The lens's radius; the focus's inverse distance; radius in pixels of the disc that a point at depth 1 becomes, focused
/// at infinity; and of that which a point at infinity becomes.
fn lens(sight: &Sight, focal_px: f64) -> [f32; 4] {
    let [radius, inverse_focus] = sight.lens;
    let at_one = focal_px * f64::from(radius);
    [radius, inverse_focus, at_one as f32, (at_one * f64::from(inverse_focus)) as f32]
}

/// Where the view axis meets the picture, in pixels of the whole and in device coordinates of what is drawn.
fn principal(view: &View) -> [f32; 4] {
    let size = DVec2::new(view.width.into(), view.height.into());
    let [column, row] = view.origin.map(f64::from);
    let (whole, device) =
        (view.principal + DVec2::new(column, row), 2.0 * view.principal / size - 1.0);
    [whole.x as f32, whole.y as f32, device.x as f32, device.y as f32]
}

/// Factor on stored units before the curve; 0 where it is derived from the picture. The bounds change no
/// picture: beyond them every stored value but 0 is white, or every one is black.
fn stored_exposure(scene: &Scene, around: &Surroundings) -> f32 {
    if scene.tone_map.derives_exposure() {
        return 0.0;
    }
    let factor = scene.tone_map.exposure.unwrap_or(1.0) * f64::from(around.radiance_scale);
    factor.clamp(f64::from(f32::MIN_POSITIVE), 1e32) as f32
}

/// The uniform buffer that holds the [`Frame`].
pub struct FrameBuffer {
    /// Binding 0 of every pass.
    pub buffer: Buffer,
}

impl FrameBuffer {
    /// A buffer for one frame.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let size = size_of::<Constants>() as u64;
        Ok(Self { buffer: Buffer::new(device, "frame", size, usage, Memory::Device)? })
    }

    /// Records the populations of a scene after the first, where there are such, beside [`FrameBuffer::record`].
    pub fn record_others(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        let populations = scene.populations();
        let Some((first, others)) =
            populations.split_first().filter(|(_, others)| !others.is_empty())
        else {
            return;
        };
        // No drop has an index so high.
        let nobody = Population { camera_place: [u32::MAX; 4], ..Population::default() };
        let mut records = [nobody; MOST_POPULATIONS as usize - 1];
        let mut index = first.count;
        for (record, rain) in records.iter_mut().zip(others) {
            *record = population_of(rain, scene, index);
            index += rain.count;
        }
        let at = offset_of!(Constants, others) as u64;
        update_buffer(device, commands, &self.buffer, at, bytemuck::bytes_of(&records));
    }

    /// Records the update.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, frame: &Frame) {
        update_buffer(device, commands, &self.buffer, 0, bytemuck::bytes_of(frame));
    }
}
