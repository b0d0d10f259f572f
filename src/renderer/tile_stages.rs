//! The frame by tiles stage by stage: what its passes leave for each other, so that each can be held against a serial
//! implementation.

use half::f16;

use super::lighting::Lighting;
use super::tiled::Tiled;
use super::view::surroundings;
use crate::Result;
use crate::gpu::{Buffer, Commands, Timestamps, Use, copy_buffer, memory_barrier};
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::rain_field::RainField;
use crate::passes::tile_grid;
use crate::plan::FramePlan;
use crate::scene::Scene;

/// Every stage of a frame.
pub struct TileStages {
    /// The first tile that is drawn, and the one after the last.
    pub tiles: [[u32; 2]; 2],
    /// Bands of depth in which clusters were taken.
    pub bands: u32,
    /// The link of each tile's first entry, as they were before the composite sorted any.
    pub heads: Vec<u32>,
    /// The words of all entries (`glsl/include/tile_buffers.glsl`).
    pub nodes: Vec<u32>,
    /// What splats show, by direction first (`glsl/splat_table.comp`).
    pub splats: Vec<[u32; 4]>,
    /// The picture, in stored units.
    pub radiance: Vec<[f16; 4]>,
}

impl TileStages {
    /// Draws `scene` by a plan for tiles.
    ///
    /// # Errors
    /// See [`super::Renderer::new`] and [`super::Renderer::submit`].
    pub fn draw(lighting: &Lighting, scene: &Scene, plan: &FramePlan) -> Result<Self> {
        let device = lighting.device();
        let rain = RainField::new(device, scene);
        let frame = FrameBuffer::new(device)?;
        let mut tiled = Tiled::new(lighting, &rain, &frame, scene, plan, None)?;
        let mut constants = Frame::new(scene, &surroundings(lighting, scene, plan)?, None);
        tiled.complete(&mut constants);
        let seen = tiled.tiles.seen(scene);
        let mut time = Timestamps::new(device)?;
        time.reset();
        let read_back = |of: &Buffer| Buffer::readback(device, "stage read back", of.size);
        let lists = &tiled.tiles.lists;
        let [heads, nodes, splats, radiance] = [
            read_back(&lists.heads)?,
            read_back(&lists.nodes)?,
            read_back(&tiled.splats.table)?,
            read_back(&tiled.composite.radiance)?,
        ];
        Commands::once(device, "stages of tiles", |commands| {
            let copy = |from, to| copy_buffer(device, commands, from, to);
            frame.record(device, commands, &constants);
            frame.record_others(device, commands, scene);
            tiled.record_reset(device, commands, scene, (&scene.view(), 0.0), seen.as_ref());
            tiled.record_lists(device, commands, &mut time, 1, &constants, seen.as_ref());
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
            let lists = &tiled.tiles.lists;
            copy(&lists.heads, &heads);
            copy(&lists.nodes, &nodes);
            copy(&tiled.splats.table, &splats);
            memory_barrier(device, commands, &[Use::TransferRead], &[Use::ComputeWrite]);
            tiled.record_composite(device, commands, &mut time);
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferRead]);
            copy(&tiled.composite.radiance, &radiance);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        })?;
        let (first, end) = tile_grid::of_view(&scene.view());
        let (width, height) = scene.picture_size();
        Ok(Self {
            tiles: [first, end],
            bands: constants.room[3],
            heads: heads.read(((end[0] - first[0]) * (end[1] - first[1])) as usize),
            nodes: nodes.read(nodes.size as usize / 4),
            splats: splats.read(splats.size as usize / 16),
            radiance: radiance.read(width as usize * height as usize),
        })
    }
}
