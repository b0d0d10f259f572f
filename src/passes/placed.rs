//! The drops placed by hand, as the passes that draw them read them (`Placed` in `glsl/include/rain.glsl`).
//!
//! A drop in motion has another place in each frame. It is found here, in float64, so that it is exact however far
//! the scene's time is, and written into the command buffer: frames in flight need no copies.

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Result;
use crate::abi::CLUSTER;
use crate::gpu::{Buffer, Device, Memory, Recorder, update_buffer};
use crate::rain::cull::split;
use crate::scene::{PlacedDrop, Scene};

/// How far a spheroid of the largest axis ratio, 20, reaches beyond the sphere of its volume, in radii.
const MOST_OF_SHAPE: f64 = 7.4;

/// Centre in float32 and radius; what float32 lost of the centre, and the number. Words, as a number may be no float.
type Record = [u32; 8];

/// The buffers, and whether they change from frame to frame.
pub(super) struct PlacedDrops {
    /// The drops, then a record for each cluster.
    pub buffer: Buffer,
    /// Places of the drops that the scene knows in their list, cluster by cluster.
    clusters: Arc<[u32]>,
    /// Where the record of the first cluster of a host's particles stands, which are written on the device (`particles.rs`);
    /// none if they are taken one by one.
    pub boxes_of_host: Option<u32>,
    /// How far each moves while the shutter is open; of no use where none does.
    pub motions: Buffer,
    /// How far they are from the camera as it first stands, at most along any axis: by this they are parted into bands of
    /// depth.
    pub farthest: f32,
    moves: bool,
    is_exposed: bool,
}

impl PlacedDrops {
    /// The drops of `scene` at its time, in `clusters` (none: what draws them takes them one by one).
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        is_exposed: bool,
        clusters: Arc<[u32]>,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        // While the shutter is open the camera may move, too.
        let moves = is_exposed
            || scene.host_particles > 0
            || scene.placed().any(|drop| drop.velocity != DVec3::ZERO);
        let usage = Usage::STORAGE_BUFFER;
        let boxes = clusters.len() as u32 / CLUSTER;
        let known = scene.known_count().div_ceil(CLUSTER).min(boxes);
        let boxes_of_host = (boxes > known).then(|| scene.placed_count() + known);
        let clusters: Arc<[u32]> = match boxes_of_host {
            Some(_) => clusters[..(known * CLUSTER) as usize].into(),
            None => clusters,
        };
        let buffer = if moves {
            let records = (scene.placed_count() + boxes) as usize;
            let bytes = (size_of::<Record>() * records) as u64;
            let usage = usage | Usage::TRANSFER_DST;
            Buffer::new(device, "placed drops", bytes, usage, Memory::Device)?
        } else {
            Buffer::upload(device, "placed drops", &records(scene, &clusters), usage)?
        };
        let count = if is_exposed { scene.placed_count().max(1) as usize } else { 1 };
        let bytes = (size_of::<[f32; 4]>() * count) as u64;
        let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_DST;
        let motions = Buffer::new(device, "motions of placed drops", bytes, usage, Memory::Device)?;
        let apart = |drop: &PlacedDrop| (drop.center - scene.camera.position).abs().max_element();
        let farthest = scene.placed().map(apart).fold(0.0, f64::max) as f32;
        Ok(Self { buffer, clusters, boxes_of_host, motions, farthest, moves, is_exposed })
    }

    /// Records the places in this frame, where they change; a barrier to compute must follow.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if self.moves {
            let records = records(scene, &self.clusters);
            // A host's particles are between the drops and the boxes.
            let (drops, boxes) = match scene.host_particles {
                0 => (&records[..], &[][..]),
                _ => records.split_at(scene.known_count() as usize),
            };
            let first_box = size_of::<Record>() as u64 * u64::from(scene.placed_count());
            for (at, part) in [(0, drops), (first_box, boxes)] {
                update_buffer(device, commands, &self.buffer, at, bytemuck::cast_slice(part));
            }
        }
        if self.is_exposed && scene.placed_count() > 0 {
            let motion = |drop: &PlacedDrop| {
                scene.drawn_motion_of(drop.velocity).as_vec3().extend(0.0).to_array()
            };
            let motions: Vec<[f32; 4]> = scene.placed().map(motion).collect();
            update_buffer(device, commands, &self.motions, 0, bytemuck::cast_slice(&motions));
        }
    }
}

/// Two points, a length and a number.
fn record([at, more]: [Vec3; 2], length: f64, number: u32) -> Record {
    let ([x, y, z], [a, b, c]) =
        (at.to_array().map(f32::to_bits), more.to_array().map(f32::to_bits));
    [x, y, z, (length as f32).to_bits(), a, b, c, number]
}

/// The drops; and the box around each cluster of them while the shutter is open: its middle, how far a drop reaches beyond its
/// centre, and half the edges.
fn records(scene: &Scene, clusters: &[u32]) -> Vec<Record> {
    let drops: Vec<&PlacedDrop> = scene.placed().collect();
    let around = |cluster: &[u32]| {
        let (mut low, mut high, mut reach) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0_f64);
        for drop in cluster.iter().filter_map(|place| drops.get(*place as usize)) {
            let center = scene.drawn_center(drop);
            let half_way = 0.5 * scene.drawn_motion_of(drop.velocity).abs();
            (low, high) = (low.min(center - half_way), high.max(center + half_way));
            reach = reach.max(drop.radius * if drop.is_sphere() { 1.0 } else { MOST_OF_SHAPE });
        }
        let middle = 0.5 * (low + high);
        // As much larger as the middle is rounded.
        let half = 0.5 * (high - low) + f64::from(f32::EPSILON) * middle.abs();
        record([middle.as_vec3(), half.as_vec3()], reach, 0)
    };
    let boxes = clusters.par_chunks(CLUSTER as usize).map(around);
    let drop = |(place, drop): (usize, &&PlacedDrop)| {
        let number = scene.number_of(drop, place as u32);
        record(split(scene.drawn_center(drop)), drop.radius, number)
    };
    drops.par_iter().enumerate().map(drop).chain(boxes).collect()
}
