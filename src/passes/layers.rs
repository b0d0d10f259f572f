//! What a compositor needs beside the light of the rain: for each pixel the nearest drop that covers a part of it, with its
//! depth, its motion and its number, and how many drops do.
//!
//! It has no pass of its own. `gather` and `large`, which know where a drop is, write a record of it, once a drop
//! (`glsl/include/drop_records.glsl`). `composite`, which blends a tile's drops front to back, keeps for each pixel the
//! number of the first one's record and how many drops there are (`glsl/include/nearest.glsl`). Whoever reads a pixel
//! looks up the record.
//!
//! Cost, by `cargo bench --bench layers`: a sixth of a frame of equal drops, a quarter of one of real rain. A pass that
//! walked the lists again, found each drop's place again and wrote five words a pixel took six to eight tenths.
//!
//! Motion is that of a drop's centre, from the frame's time to another that the caller gives, each seen by its own camera:
//! so it holds for drops that fall and for a camera that moves. It is told by velocity and not by a second look
//! at the cells, so a drop that leaves its box, or is shown no longer by then, has one too.
//! Error: float16, 2⁻¹¹ of itself.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;

use crate::Result;
use crate::abi::Motion;
use crate::gpu::sets::tiles as slot;
use crate::gpu::{Buffer, Device, Memory, Recorder, Slot, update_buffer};
use crate::rain::cells::Lattice;
use crate::scene::Scene;
use crate::scene::projection::View;

/// The drops' records, and the motion in them.
pub struct DropRecords {
    /// Four words a node, of which splats use theirs, then a large drop: planar depth as bits; motion as two halves; the
    /// number's low and high word.
    pub records: Buffer,
    motion: Buffer,
    pub(super) placed_moved: Buffer,
}

impl DropRecords {
    /// Room for so many records of drops of `scene`.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub(super) fn new(device: &Arc<Device>, count: u64, scene: &Scene) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let make = |name, bytes, usage| Buffer::new(device, name, bytes, usage, Memory::Device);
        let (storage, written) = (Usage::STORAGE_BUFFER, Usage::TRANSFER_DST);
        let moved = 16 * u64::from(scene.placed_count().max(1));
        Ok(Self {
            records: make("drop records", 16 * count, storage | Usage::TRANSFER_SRC)?,
            motion: make("motion", size_of::<Motion>() as u64, Usage::UNIFORM_BUFFER | written)?,
            placed_moved: make("how far placed drops move", moved, storage | written)?,
        })
    }

    /// What is bound for it; without it, a storage and a uniform buffer in its place.
    pub(super) fn slots<'a>(
        records: Option<&'a Self>,
        (storage, uniform): (&'a Buffer, &'a Buffer),
    ) -> [(Slot, &'a Buffer); 3] {
        [
            (slot::DROP_RECORDS, records.map_or(storage, |own| &own.records)),
            (slot::MOTION, records.map_or(uniform, |own| &own.motion)),
            (slot::PLACED_MOVED, records.map_or(storage, |own| &own.placed_moved)),
        ]
    }

    /// Records the motion from `scene`, whose real rain has these lattices, to what `then` shows so many `seconds` later; a
    /// barrier to compute must follow.
    pub(super) fn record_motion(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        lattices: &[Lattice],
        (then, seconds): (&View, f64),
    ) {
        let of_camera = then.position - scene.camera.position;
        let seen = |way: DVec3| (way - of_camera).as_vec3().extend(0.0).to_array();
        let with = |v: DVec3, w: f64| v.as_vec3().extend(w as f32).to_array();
        let mut motion = Motion {
            right: with(then.right, 0.0),
            up: with(then.up, 0.0),
            back: with(then.back, 0.0),
            ..Motion::default()
        };
        let [column, row] = then.origin.map(f64::from);
        let principal = then.principal.extend(0.0) + DVec3::new(column, row, 0.0);
        motion.principal = with(principal, then.focal_px);
        // Real rain stands alone: there are populations, or lattices.
        let populations = scene.populations();
        let boxes = populations.iter().map(|rain| rain.velocity * seconds);
        let classes = lattices.iter().map(|class| class.velocity * (seconds / scene.metres));
        for (moved, way) in motion.random.iter_mut().zip(boxes.chain(classes)) {
            *moved = seen(way);
        }
        let placed: Vec<_> = scene.placed().map(|drop| seen(drop.velocity * seconds)).collect();
        update_buffer(device, commands, &self.motion, 0, bytemuck::bytes_of(&motion));
        update_buffer(device, commands, &self.placed_moved, 0, bytemuck::cast_slice(&placed));
    }
}
