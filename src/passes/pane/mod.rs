//! A pane of glass before the camera, and the drops on it (`glsl/pane_*.comp`): between the rain's picture and the display.
//!
//! 1. `pane_dry`: each pixel of the rain's picture, dimmed by T of its own ray; and a list of the pixels that drops may touch, found by
//!    the cells of a grid on the pane (`drops.rs`). Where no drop is, a pane costs no more than this.
//! 2. `pane_rays`: these pixels by rays from places of the lens through places of the pixel. A ray that meets a drop is followed from
//!    surface to surface; one that passes beside all drops sees the rain's picture. Drops do not overlap, and a ray meets one of them at
//!    most: the parts that they cover of a pixel add up.
//! 3. `pane_logs`: where an exposure is derived, the sums of log luminance that the composite left are those of the picture without
//!    the pane; so they are summed again, tile by tile.
//!
//! The rain's picture is kept apart, for tiles without drops are drawn once for many frames.
//!
//! Error: what is behind the pane is one colour a pixel, seen without the pane's shift; what a drop shows is the environment or the
//! plate, at the level of the rays' spacing. Rain between the camera and the glass is left out by its distance from the camera alone
//! ([`Scene::drawn_near`]).

mod drops;

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};

pub(crate) use self::drops::PaneDrops;
use super::background::Behind;
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::tile_grid;
use super::tone_map::{Source, further_sums};
use super::{rows_of, side_by_side};
use crate::Result;
use crate::abi::Pane as Constants;
use crate::gpu::sets::{constant, group, pane as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Use, memory_barrier,
    shaders, update_buffer,
};
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::PaneModel;

/// Fewest rays of a pixel that a drop touches: 16 are off by 3 to 5 grey levels of 255.
const LEAST_RAYS: u32 = 16;
/// Fewest through a lens.
const LEAST_LENS_RAYS: u32 = 64;
/// Reflections within a drop that are followed.
const REFLECTIONS: u32 = 8;
/// Words before the list of touched pixels: the groups of a dispatch, and their number.
const TOUCHED: [u32; 4] = [0, 0, 1, 0];

/// The passes, and the picture with the pane.
pub struct Pane {
    /// Four halves a pixel, row by row from the top, in stored units.
    pub radiance: Buffer,
    /// A sum of log(delta + luminance) for each tile, then those of `tone_map.rs`.
    pub log_sums: Buffer,
    tiles: u32,
    drops: Arc<PaneDrops>,
    constants: Buffer,
    touched: Buffer,
    radiance_scale: f32,
    has_plate: bool,
    groups: [u32; 3],
    bindings: Bindings,
    dry: ComputePipeline,
    rays: ComputePipeline,
    /// None where no exposure is derived.
    logs: Option<ComputePipeline>,
}

/// What the passes read.
#[derive(Clone, Copy)]
pub(crate) struct Before<'a> {
    pub frame: &'a FrameBuffer,
    /// The rain's picture.
    pub picture: &'a Buffer,
    pub environment: &'a EnvironmentMap,
    pub behind: Option<&'a Behind>,
    pub drops: &'a Arc<PaneDrops>,
}

impl Pane {
    /// The passes before a picture of this size, by a plan that draws a pane.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the picture does not fit in one binding; [`crate::Error::Memory`] if the device has no room;
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub(crate) fn new(
        device: &Arc<Device>,
        scene: &Scene,
        plan: &FramePlan,
        before: Before<'_>,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let Before { frame, picture, environment, behind, drops } = before;
        let (width, height) = scene.picture_size();
        let pixels = u64::from(width) * u64::from(height);
        let (first, end) = tile_grid::of_view(&scene.view());
        let tiles = (end[0] - first[0]) * (end[1] - first[1]);
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let moved = Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let sums = 4 * u64::from(tiles + further_sums(device.report.machine));
        let radiance = make(
            "picture with the pane",
            8 * pixels,
            Usage::TRANSFER_SRC | Usage::UNIFORM_TEXEL_BUFFER,
        )?;
        let log_sums = make("log luminance sums with the pane", sums, moved)?;
        let constants = make("pane", size_of::<Constants>() as u64, Usage::TRANSFER_DST)?;
        let touched = make(
            "pixels that drops of a pane touch",
            (size_of_val(&TOUCHED) as u64) + 4 * pixels,
            Usage::TRANSFER_DST | Usage::INDIRECT_BUFFER,
        )?;
        let around = Resource::Sampled(&environment.image, &environment.sampler);
        let nearest = crate::gpu::Sampler::nearest(device, "plate behind a pane")?;
        let plate = match behind {
            Some(Behind::Plate(images)) => images.color.as_ref(),
            _ => None,
        };
        let slots = [
            (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
            (slot::BEHIND, Resource::Buffer(picture)),
            (slot::RADIANCE, Resource::Buffer(&radiance)),
            (slot::PANE_CONSTANTS, Resource::Buffer(&constants)),
            (slot::PANE_CAPS, Resource::Buffer(&drops.caps)),
            (slot::PANE_CELLS, Resource::Buffer(&drops.cells)),
            (slot::ENVIRONMENT_MAP, around),
            // Without a plate no shader reads it.
            (slot::PLATE_IMAGE, Resource::Sampled(plate.unwrap_or(&environment.image), &nearest)),
            (slot::TOUCHED, Resource::Buffer(&touched)),
            (slot::LOG_SUMS, Resource::Buffer(&log_sums)),
        ];
        let bindings = Bindings::of(device, "pane", &slots)?;
        let least = if scene.drawn_lens() > 0.0 { LEAST_LENS_RAYS } else { LEAST_RAYS };
        let reflections = if plan.pane == Some(PaneModel::FirstExit) { 0 } else { REFLECTIONS };
        let of_rays = [
            [constant::PANE_RAYS, plan.samples.max(least)],
            [constant::PANE_REFLECTIONS, reflections],
        ];
        let pipeline = |(shader, constants): (_, &[[u32; 2]])| {
            ComputePipeline::new(device, shader, &bindings, 0, constants)
        };
        let [rays, dry] = side_by_side(
            [(shaders::PANE_RAYS_COMP, &of_rays[..]), (shaders::PANE_DRY_COMP, &[][..])],
            pipeline,
        )?;
        let logs =
            plan.log_average.then(|| pipeline((shaders::PANE_LOGS_COMP, &[]))).transpose()?;
        let [across, down, _] = group::PANE_DRY_COMP;
        Ok(Self {
            radiance,
            log_sums,
            tiles,
            drops: drops.clone(),
            constants,
            touched,
            radiance_scale: environment.radiance_scale,
            has_plate: plate.is_some(),
            groups: [width.div_ceil(across), height.div_ceil(down), 1],
            bindings,
            dry,
            rays,
            logs,
        })
    }

    /// What the display passes read.
    pub fn source(&self) -> Source<'_> {
        Source::Tiles { radiance: &self.radiance, log_sums: &self.log_sums, count: self.tiles }
    }

    /// The constants of a frame; none of a scene without a pane.
    fn constants_of(&self, scene: &Scene) -> Option<Constants> {
        let (pane, face) = (scene.pane.as_ref()?, scene.pane_face()?);
        let view = scene.view();
        let in_view = |axis: DVec3| {
            DVec3::new(axis.dot(view.right), axis.dot(view.up), axis.dot(view.back))
                .as_vec3()
                .to_array()
        };
        let local = |vector: DVec3| face.to_local(vector).as_vec3().to_array();
        let eye = self.drops.from_corner(face.to_local(view.position - face.point));
        let water = scene.indices().map(|index| index as f32);
        let (first, end) = tile_grid::of_view(&view);
        Some(Constants {
            u: in_view(face.u),
            thickness: pane.thickness as f32,
            v: in_view(face.v),
            glass: pane.index as f32,
            normal: in_view(face.normal),
            cell: self.drops.cell as f32,
            eye: eye.as_vec3().to_array(),
            tallest: self.drops.tallest as f32,
            motion: local(scene.pane_motion()),
            overhang: self.drops.overhang as f32,
            inside: (pane.inside.as_vec3() / Vec3::splat(self.radiance_scale)).to_array(),
            plate: if self.has_plate { 1.0 / self.radiance_scale } else { 0.0 },
            water,
            indices: if water[0] == water[1] && water[1] == water[2] { 1 } else { 3 },
            cells: self.drops.size.to_array(),
            first_tile: first,
            tiles_across: end[0] - first[0],
            tiles: self.tiles,
        })
    }

    /// Records what changes with the frame; a barrier to compute and to indirect arguments must follow.
    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        if let Some(constants) = self.constants_of(scene) {
            update_buffer(device, commands, &self.constants, 0, bytemuck::bytes_of(&constants));
        }
        update_buffer(device, commands, &self.touched, 0, bytemuck::bytes_of(&TOUCHED));
    }

    /// Records the picture with the pane, after that of the rain and a barrier.
    pub fn record(&self, device: &Device, commands: Recorder<'_>) {
        let wait = |after: &[Use]| memory_barrier(device, commands, &[Use::ComputeWrite], after);
        self.dry.dispatch(commands, &self.bindings, 0, &[], self.groups);
        wait(&[Use::ComputeWrite, Use::Indirect]);
        self.rays.dispatch_indirect(commands, &self.bindings, &[], &self.touched, 0);
        if let Some(logs) = &self.logs {
            wait(&[Use::ComputeWrite]);
            let groups = rows_of(self.tiles.div_ceil(group::PANE_LOGS_COMP[0]));
            logs.dispatch(commands, &self.bindings, 0, &[], groups);
        }
    }
}
