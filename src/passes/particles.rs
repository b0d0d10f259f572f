//! A host's particles, in a buffer of its own that it renews with each frame (`glsl/particles.comp`). They become placed drops
//! on the device, before any other pass of the frame, and nothing of them is read back.
//!
//! Drops that follow one another in the buffer share a cluster, sixteen of them, whose box is found here. So the less space
//! those take, the less a frame costs; the picture is the same in whatever order they are.
//!
//! Nothing is read outside of the buffer: the CPU knows how many particles it holds, and the device takes no more, whatever
//! their count says. A particle that cannot be drawn is put behind the camera, counted, and reported with the frame.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;

use super::frame::FrameBuffer;
use super::host_records::{ParticleCount, Records, Words, word};
use super::rows_of;
use super::tiles::Tiles;
use crate::abi::{CLUSTER, ParticlesPush};
use crate::gpu::sets::{constant, group, particles as slot};
use crate::gpu::{Bindings, ComputePipeline, Device, Recorder, Resource, shaders};
use crate::plan::FramePlan;
use crate::scene::model::Motion;
use crate::scene::{Scene, projection};
use crate::{Error, Result};

/// Clusters of a workgroup.
const GROUP: u32 = group::PARTICLES_COMP[0];

/// Particles of a host's, in a buffer on its device, as they are at the time of the frame's scene.
///
/// The buffer has usage `STORAGE_BUFFER`, as that of the count does. What wrote them must have been made available and visible
/// to accesses `SHADER_STORAGE_READ` of stage `COMPUTE_SHADER` before the frame's commands; what writes them next waits for
/// that stage of those commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostParticles {
    /// The buffer that they are in.
    pub buffer: vk::Buffer,
    /// Where in it the first one begins, in bytes.
    pub offset: u64,
    /// Bytes of the buffer from there on that may be read. Particles that do not fit are left out and counted.
    pub bytes: u64,
    /// Where in a particle each of its values is.
    pub layout: ParticleLayout,
    /// How many there are.
    pub count: ParticleCount,
    /// The smallest and the largest coordinates of a particle, in scene units. One that is out of this box is left out and
    /// counted.
    pub within: [DVec3; 2],
    /// The largest radius. A particle with a larger one is left out and counted.
    pub largest_radius: f32,
}

/// Where in a particle its values are, in bytes from its start; multiples of 4. They are those of the machine, float32 but for
/// the number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParticleLayout {
    /// From one particle to the next.
    pub stride: u32,
    /// Centre: x, y and z, in scene units.
    pub position: u32,
    /// Radius, in scene units.
    pub radius: u32,
    /// Velocity: x, y and z, in scene units a second; none: they are at rest.
    pub velocity: Option<u32>,
    /// Number in layers, 32 bits; none: by the place in the buffer, after the scene's own drops.
    pub id: Option<u32>,
}

impl HostParticles {
    /// Particles of a layout, from the start of a buffer of so many bytes on.
    pub fn new(
        (buffer, bytes): (vk::Buffer, u64),
        layout: ParticleLayout,
        count: ParticleCount,
        within: [DVec3; 2],
        largest_radius: f32,
    ) -> Self {
        Self { buffer, offset: 0, bytes, layout, count, within, largest_radius }
    }

    /// They as what all drops of a host's are, of which `most` are taken.
    fn records(&self, most: u32) -> Records {
        let Self { buffer, offset, bytes, layout, count, .. } = *self;
        let values = [
            Some(("position", layout.position, 12)),
            Some(("radius", layout.radius, 4)),
            layout.velocity.map(|at| ("velocity", at, 12)),
            layout.id.map(|at| ("id", at, 4)),
        ];
        let (what, stride) = ("the particles", layout.stride);
        Records { what, buffer, offset, bytes, stride, values, count, most }
    }

    /// Refuses what cannot be read.
    pub(crate) fn check(&self, device: &Device, most: u32) -> Result<()> {
        self.records(most).check(device)?;
        let Self { within: [low, high], largest_radius: radius, .. } = self;
        let is_box = low.is_finite() && high.is_finite() && low.cmple(*high).all();
        if is_box && radius.is_finite() && *radius > 0.0 {
            return Ok(());
        }
        let problem = format!(
            "within {low} to {high}, radius {radius}: limits are finite, from the smaller to the larger, and over 0 for the \
             radius"
        );
        Err(Error::scene("the particles", problem))
    }

    /// How far a particle may be from a place along any axis.
    pub(crate) fn farthest(&self, from: DVec3) -> f32 {
        self.within
            .map(|corner| (corner - from).abs().max_element() as f32)
            .into_iter()
            .fold(0.0, f32::max)
    }
}

/// The pass.
pub(crate) struct Particles {
    bindings: Bindings,
    pass: ComputePipeline,
    /// Particles that there is room for, the first one's place among the placed drops, and that of their first box.
    most: u32,
    first: u32,
    boxes: Option<u32>,
}

impl Particles {
    /// The pass for the particles of a host's frames of `scene`, of which so many may be under way; none if it has none.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        tiles: &Tiles,
        scene: &Scene,
        plan: &FramePlan,
        frames: usize,
    ) -> Result<Option<Self>> {
        if scene.host_particles == 0 {
            return Ok(None);
        }
        let placed = &tiles.placed;
        // Without records no shader reads or writes them.
        let moved = tiles.records.as_ref().map_or(&placed.motions, |records| &records.placed_moved);
        let slots = [
            (slot::CONSTANTS, &frame.buffer),
            // A frame fills these two with the host's.
            (slot::PARTICLES, &placed.motions),
            (slot::PARTICLE_COUNT, &placed.motions),
            (slot::PLACED_DROPS, &placed.buffer),
            (slot::PLACED_MOTIONS, &placed.motions),
            (slot::PLACED_MOVED, moved),
            (slot::COUNTERS, &tiles.counters),
        ]
        .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)));
        let bindings = Bindings::all(device, "particles", &slots, frames as u32)?;
        let constants = [
            [constant::MOTION, (plan.motion != Motion::Instant).into()],
            [constant::NEAREST, plan.nearest.into()],
        ];
        let push = size_of::<ParticlesPush>() as u32;
        let pass =
            ComputePipeline::new(device, shaders::PARTICLES_COMP, &bindings, push, &constants)?;
        let (most, first, boxes) =
            (scene.host_particles, scene.known_count(), placed.boxes_of_host);
        Ok(Some(Self { bindings, pass, most, first, boxes }))
    }

    /// Fills a set with a frame's buffers.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the buffers live until it is no more.
    pub unsafe fn set_buffers(
        &self,
        device: &Device,
        set: usize,
        particles: &HostParticles,
    ) -> Result<()> {
        let (records, slots) =
            (particles.records(self.most), [slot::PARTICLES, slot::PARTICLE_COUNT]);
        // SAFETY: by contract.
        unsafe { records.set_buffers(device, &self.bindings, set, slots) }
    }

    /// Records the drops of a frame of `scene`, whose constants are ready, and how far they move until what a view shows so
    /// many seconds later. A barrier must follow.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        set: usize,
        scene: &Scene,
        (until, seconds): (&projection::View, f64),
        particles: &HostParticles,
    ) {
        let HostParticles { layout, within, largest_radius, .. } = particles;
        let [low, high] = within.map(|corner| corner.as_vec3().to_array());
        let Words { start, stride, count, count_at, capacity } =
            particles.records(self.most).words(device);
        let push = ParticlesPush {
            low,
            largest_radius: *largest_radius,
            high,
            exposed: scene.drawn_exposure() as f32,
            camera_exposed: scene.drawn_motion_of(DVec3::ZERO).as_vec3().to_array().map(|way| -way),
            until: seconds as f32,
            camera_until: (until.position - scene.camera.position).as_vec3().to_array(),
            start,
            stride,
            position: layout.position / 4,
            radius: layout.radius / 4,
            velocity: word(layout.velocity),
            id: word(layout.id),
            count,
            count_at,
            capacity,
            most: self.most,
            first: self.first,
            boxes: self.boxes.unwrap_or(u32::MAX),
            number: scene.random_count() + self.first + 1,
        };
        let groups = rows_of(self.most.div_ceil(CLUSTER).div_ceil(GROUP));
        self.pass.dispatch(commands, &self.bindings, set, bytemuck::bytes_of(&push), groups);
    }
}
