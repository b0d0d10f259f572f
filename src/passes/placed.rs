//! The drops placed by hand and particles of files, as the passes that draw them read them (`Placed` in
//! `glsl/include/placed_boxes.glsl`).
//!
//! A drop in motion has another place in each frame. It is carried there on the device, by pairs of float32
//! (`src/rain/pairs.rs`), so that it is exact however far the scene's time is, and a million of them cost the CPU nothing. Only
//! clusters that may be in view have their drops carried: the others' are not read.

use std::sync::Arc;

use ash::vk;
use bytemuck::Zeroable as _;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::frame::FrameBuffer;
use super::rows_of;
use crate::Result;
use crate::abi::{CLUSTER, Known, KnownCluster, NO_DROP, PlacedPush};
use crate::gpu::sets::{constant, group, placed as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Texel, Texels, Use,
    memory_barrier, shaders,
};
use crate::rain::cull::split;
use crate::rain::pairs::moment;
use crate::scene::{PlacedDrop, Scene};

/// How far a spheroid of the largest axis ratio, 20, reaches beyond the sphere of its volume, in radii.
const MOST_OF_SHAPE: f64 = 7.4;
/// In the place of a record's number: there is none.
const NOTHING: u32 = u32::MAX;
/// Clusters of a workgroup.
const GROUP: u32 = group::PLACED_COMP[0];

/// Centre in float32 and radius; what float32 lost of the centre, and the number. Words, as a number may be no float.
type Record = [u32; 8];

/// The buffers, and what fills them anew in each frame.
pub(super) struct PlacedDrops {
    /// The drops, then a record for each cluster.
    pub buffer: Buffer,
    /// Where the record of the first cluster of a host's particles stands, which are written on the device (`particles.rs`);
    /// none if they are taken one by one.
    pub boxes_of_host: Option<u32>,
    /// How far each moves while the shutter is open; of no use where none does.
    pub motions: Buffer,
    /// How far they are from the camera as it first stands, at most along any axis: by this they are parted into bands of
    /// depth.
    pub farthest: f32,
    carried: Option<Carried>,
    is_exposed: bool,
}

/// Drops that the scene knows, at time 0, and the pass that carries them to their places in a frame.
struct Carried {
    /// A set for each chunk: what one binding holds of the drops.
    bindings: Bindings,
    pass: ComputePipeline,
    /// Clusters, and those of a chunk.
    clusters: u32,
    chunk: u32,
    /// Where the record of the first one's box stands; none where drops are taken one by one.
    boxes: Option<u32>,
    /// The time at which their boxes were found.
    boxed_at: f64,
}

impl PlacedDrops {
    /// The drops of `scene` at its time, in `clusters` (none: what draws them takes them one by one), and the frame's constants
    /// and those of its shaders.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(
        device: &Arc<Device>,
        constants: (&FrameBuffer, &[[u32; 2]]),
        scene: &Scene,
        is_exposed: bool,
        clusters: Arc<[u32]>,
    ) -> Result<Self> {
        // While the shutter is open the camera may move, too.
        let moves = is_exposed
            || scene.host_particles > 0
            || scene.placed().any(|drop| drop.velocity != DVec3::ZERO);
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let boxes = clusters.len() as u32 / CLUSTER;
        let known = scene.known_count().div_ceil(CLUSTER).min(boxes);
        let boxes_of_host = (boxes > known).then(|| scene.placed_count() + known);
        let clusters: Arc<[u32]> = match boxes_of_host {
            Some(_) => clusters[..(known * CLUSTER) as usize].into(),
            None => clusters,
        };
        let buffer = if moves {
            let records = u64::from(scene.placed_count() + boxes);
            let bytes = size_of::<Record>() as u64 * records;
            Buffer::new(device, "placed drops", bytes, usage, Memory::Device)?
        } else {
            Buffer::upload(device, "placed drops", &records(scene, &clusters), usage)?
        };
        let count = if is_exposed { scene.placed_count().max(1) as usize } else { 1 };
        let bytes = (size_of::<[f32; 4]>() * count) as u64;
        let motions = Buffer::new(device, "motions of placed drops", bytes, usage, Memory::Device)?;
        let carried = (moves && scene.known_count() > 0)
            .then(|| Carried::new(device, constants, scene, &clusters, [&buffer, &motions]))
            .transpose()?;
        let apart = |drop: &PlacedDrop| (drop.center - scene.camera.position).abs().max_element();
        let farthest = scene.placed().map(apart).fold(0.0, f64::max) as f32;
        Ok(Self { buffer, boxes_of_host, motions, farthest, carried, is_exposed })
    }

    /// Records the places in this frame, where they change; a barrier to compute must follow.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if let Some(carried) = &self.carried {
            let written = [Use::Uniform, Use::ComputeWrite];
            memory_barrier(device, commands, &[Use::TransferWrite], &written);
            carried.record(commands, scene, self.is_exposed);
            let read = [Use::ComputeWrite, Use::ComputeRead];
            memory_barrier(device, commands, &[Use::ComputeWrite], &read);
        }
    }
}

impl Carried {
    fn new(
        device: &Arc<Device>,
        (frame, constants): (&FrameBuffer, &[[u32; 2]]),
        scene: &Scene,
        clusters: &[u32],
        [placed, motions]: [&Buffer; 2],
    ) -> Result<Self> {
        let drops: Vec<&PlacedDrop> = scene.placed().collect();
        let known = known(scene, &drops, clusters);
        let count = known.len() as u32 / CLUSTER;
        let around = match clusters {
            [] => vec![KnownCluster::zeroed()],
            _ => clusters.par_chunks(CLUSTER as usize).map(|c| around(scene, &drops, c)).collect(),
        };
        let bytes =
            [size_of::<Known>() as u64 * u64::from(CLUSTER), size_of::<KnownCluster>() as u64];
        let chunk = (u64::from(device.report.limits.max_storage_buffer_range) / bytes[0]) as u32;
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let known = Buffer::upload_device(device, "placed drops at time 0", &known, usage)?;
        let around = Buffer::upload_device(device, "clusters of placed drops", &around, usage)?;
        let texels = |name, buffer| Texels::new(device, name, buffer, Texel::FourWords);
        let (of_known, of_around) = (
            texels("texels of known drops", &known)?,
            texels("texels of their clusters", &around)?,
        );
        let by_texels = of_known.is_whole && of_around.is_whole;
        let constants = [constants, &[[constant::BY_TEXELS, by_texels.into()]]].concat();
        let bindings = Bindings::each(device, "placed drops", count.div_ceil(chunk), |index| {
            let part = |buffer, bytes| part_of(buffer, bytes * u64::from(chunk), index);
            // Without clusters none is read.
            let around = part(&around, if clusters.is_empty() { 0 } else { bytes[1] });
            [
                (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
                (slot::KNOWN_DROPS, part(&known, bytes[0])),
                (slot::KNOWN_CLUSTERS, around),
                (slot::KNOWN_TEXELS, Resource::Texels(&of_known)),
                (slot::CLUSTER_TEXELS, Resource::Texels(&of_around)),
                (slot::PLACED_DROPS, Resource::Buffer(placed)),
                (slot::PLACED_MOTIONS, Resource::Buffer(motions)),
            ]
        })?;
        let push = size_of::<PlacedPush>() as u32;
        let pass = ComputePipeline::new(device, shaders::PLACED_COMP, &bindings, push, &constants)?;
        let boxes = (!clusters.is_empty()).then(|| scene.placed_count());
        Ok(Self { bindings, pass, clusters: count, chunk, boxes, boxed_at: scene.time })
    }

    fn record(&self, commands: Recorder<'_>, scene: &Scene, has_motions: bool) {
        let moment = moment(scene);
        let since = (scene.drawn_time() - self.boxed_at) as f32;
        for (index, first) in (0..self.clusters).step_by(self.chunk as usize).enumerate() {
            let clusters = self.chunk.min(self.clusters - first);
            let boxes = self.boxes.map_or(NOTHING, |boxes| boxes + first);
            let has_motions = has_motions.into();
            let push = PlacedPush { clusters, boxes, has_motions, since, first, ..moment };
            let groups = rows_of(clusters.div_ceil(GROUP));
            self.pass.dispatch(commands, &self.bindings, index, bytemuck::bytes_of(&push), groups);
        }
    }
}

/// The part of a buffer with this number, where each but the last has so many bytes; 0: all of it.
pub(super) fn part_of(buffer: &Buffer, bytes: u64, number: u32) -> Resource<'_> {
    let offset = bytes * u64::from(number);
    match bytes {
        0 => Resource::Buffer(buffer),
        _ => Resource::Range(buffer, offset, bytes.min(buffer.size - offset)),
    }
}

/// What holds a cluster's drops at the scene's time, and how fast they are.
fn around(scene: &Scene, drops: &[&PlacedDrop], cluster: &[u32]) -> KnownCluster {
    let of = || cluster.iter().filter_map(|place| drops.get(*place as usize));
    let bounds = |part: &dyn Fn(&PlacedDrop) -> DVec3, length: f64| {
        let from = of().map(|drop| part(drop)).fold(DVec3::INFINITY, DVec3::min);
        let to = of().map(|drop| part(drop)).fold(DVec3::NEG_INFINITY, DVec3::max);
        // They are wider by as much as they are rounded.
        let rounded = f64::from(f32::EPSILON) * from.abs().max(to.abs());
        [from - rounded, to + rounded].map(|v| v.as_vec3().extend(length as f32).to_array())
    };
    let reach = of().map(|drop| reach(drop)).fold(0.0, f64::max);
    let [low, high] = bounds(&|drop| drop.center_at(scene.time), reach);
    let [slowest, fastest] = bounds(&|drop| drop.velocity, 0.0);
    KnownCluster { low, high, slowest, fastest }
}

/// The drops that the scene knows at time 0, cluster by cluster, or in their order; the last ones of a cluster may be none.
fn known(scene: &Scene, drops: &[&PlacedDrop], clusters: &[u32]) -> Vec<Known> {
    let in_order: Vec<u32> = (0..(drops.len() as u32).next_multiple_of(CLUSTER)).collect();
    let places = if clusters.is_empty() { &in_order } else { clusters };
    let of = |place: &u32| {
        let Some(drop) = drops.get(*place as usize) else {
            return Known { place: NO_DROP, ..Known::zeroed() };
        };
        let parts = |v: DVec3| split(v).map(|part| part.to_array());
        let ([high, low], [velocity_high, velocity_low]) =
            (parts(drop.center), parts(drop.velocity));
        let (radius, number, place) = (drop.radius as f32, scene.number_of(drop, *place), *place);
        Known { high, radius, low, number, velocity_high, place, velocity_low, unused: 0 }
    };
    places.par_iter().map(of).collect()
}

/// How far a drop reaches beyond its centre, at most.
fn reach(drop: &PlacedDrop) -> f64 {
    drop.radius * if drop.is_sphere() { 1.0 } else { MOST_OF_SHAPE }
}

/// Two points, a length and a number.
fn record([at, more]: [Vec3; 2], length: f64, number: u32) -> Record {
    let ([x, y, z], [a, b, c]) =
        (at.to_array().map(f32::to_bits), more.to_array().map(f32::to_bits));
    [x, y, z, (length as f32).to_bits(), a, b, c, number]
}

/// Drops at rest; and the box around each cluster of them: its middle, how far a drop reaches beyond its centre, and half the
/// edges.
fn records(scene: &Scene, clusters: &[u32]) -> Vec<Record> {
    let drops: Vec<&PlacedDrop> = scene.placed().collect();
    let around = |cluster: &[u32]| {
        let KnownCluster { low, high, .. } = around(scene, &drops, cluster);
        let [low, high] = [low, high].map(|bound| Vec4::from(bound).as_dvec4());
        let (middle, half) = (0.5 * (low + high).truncate(), 0.5 * (high - low).truncate());
        // It is larger by as much as the middle is rounded.
        let half = half + f64::from(f32::EPSILON) * middle.abs();
        record([middle.as_vec3(), half.as_vec3()], low.w, 0)
    };
    let boxes = clusters.par_chunks(CLUSTER as usize).map(around);
    let drop = |(place, drop): (usize, &&PlacedDrop)| {
        let number = scene.number_of(drop, place as u32);
        record(split(drop.center), drop.radius, number)
    };
    drops.par_iter().enumerate().map(drop).chain(boxes).collect()
}
