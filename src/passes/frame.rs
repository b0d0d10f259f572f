//! What every pass of a frame needs to know: the constants of `glsl/include/frame.glsl`.
//!
//! Written into the command buffer by an update, so that frames in flight need no copies of it.

use std::sync::Arc;

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3};

use crate::Result;
use crate::gpu::{Buffer, Device, Memory, Recorder};
use crate::rain::cull::Sight;
use crate::rain::{Tick, tick_of_seconds};
use crate::scene::Scene;
use crate::scene::projection::View;

/// `Frame`, member for member; see the comments there.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shaders read them")]
pub struct Frame {
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub back: [f32; 4],
    pub units: [f32; 4],
    pub camera_place: [u32; 4],
    pub shift: [u32; 4],
    pub seed: [u32; 4],
    pub motion: [f32; 4],
    pub camera_high: [f32; 4],
    pub camera_low: [f32; 4],
    pub extent: [f32; 4],
    pub image: [f32; 4],
    pub window: [u32; 4],
    pub principal: [f32; 4],
    pub frustum_x: [f32; 4],
    pub frustum_y: [f32; 4],
    pub environment: [f32; 4],
    pub tone: [f32; 4],
    pub tiles: [u32; 4],
    pub room: [u32; 4],
    pub clusters: [u32; 4],
    pub moved: [f32; 4],
    pub veil: [u32; 4],
    pub lens: [f32; 4],
}

const _: () = assert!(size_of::<Frame>() == 24 * 16);

/// What the device and the environment add to a scene.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Largest diameter of a point, in pixels.
    pub point_limit_px: f32,
    /// Angle of an environment texel, in radians.
    pub texel_angle: f32,
    /// Radiance of a stored 1.
    pub radiance_scale: f32,
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
        let with_int = |v: [u32; 3], w: u32| [v[0], v[1], v[2], w];
        let tick = tick_of_seconds(scene.drawn_time());
        let exposed = scene.drawn_exposure();
        let least_radius = scene
            .rain
            .map(|rain| rain.radius)
            .into_iter()
            .chain(scene.drops.iter().map(|drop| drop.radius))
            .fold(f64::INFINITY, f64::min);
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
            environment: [around.texel_angle, around.radiance_scale, 0.0, 0.0],
            tone: [
                scene.tone_map.key as f32,
                around.delta,
                stored_exposure(scene, around),
                view.width as f32 * view.height as f32,
            ],
            moved: [0.0, 0.0, 0.0, exposed as f32],
            lens: lens(&sight, view.focal_px),
            ..Self::default()
        };
        if let Some(rain) = scene.rain() {
            frame.units = with(rain.units(), rain.radius as f32);
            frame.camera_place = with_int(rain.camera_place(scene.camera.position), rain.count);
            frame.shift = with_int(rain.shift(tick), scene.drop_count());
            frame.extent = with(rain.half_extent.as_vec3(), least_radius as f32);
            let seconds =
                last_tick.map_or(0.0, |last| (tick - last) as f64 / crate::rain::TICKS_PER_SECOND);
            // A jump is a long step; whole boxes of it are taken out here, in float64.
            let boxes = rain.velocity * seconds / (2.0 * rain.half_extent);
            let step: DVec3 = (boxes - boxes.round()) * 2.0 * rain.half_extent;
            frame.motion = with(step.as_vec3(), 0.0);
            frame.moved = with((rain.velocity * exposed).as_vec3(), exposed as f32);
        }
        frame
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
    /// Those of [`Buffer::new`].
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let size = size_of::<Frame>() as u64;
        Ok(Self { buffer: Buffer::new(device, "frame", size, usage, Memory::Device)? })
    }

    /// Records the update.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, frame: &Frame) {
        let bytes = bytemuck::bytes_of(frame);
        // SAFETY: the command buffer is recorded outside of rendering; the data is copied now.
        unsafe { device.raw().cmd_update_buffer(commands.raw(), self.buffer.raw(), 0, bytes) };
    }
}
