//! A pane of glass before the camera, and the drops on it (`glsl/pane_*.comp`): between the rain's picture and the display.
//!
//! 1. `pane_looks`, by models `picture` and `color`: what each drop that is out of focus shows at 64 places, seen from the middle of
//!    the lens, and a table of its picture, spread over lens and pixel.
//! 2. `pane_dry`: each pixel of the rain's picture, dimmed by T of its own ray; and a list of the pixels that drops may touch, found by
//!    the cells of a grid on the pane (`drops.rs`). Where no drop is, a pane costs no more than this.
//! 3. `pane_rays`: these pixels. Drops in focus by rays from places of the lens through places of the pixel, followed from surface to
//!    surface. Drops out of focus by the part of the pixel's rays that meet them, times the mean of what these see of
//!    them (`glsl/include/pane_blur.glsl`). Drops do not overlap, and a ray meets one of them at most: the parts of a pixel add up. The rest
//!    sees the rain's picture.
//! 4. `pane_logs`: where an exposure is derived, the sums of log luminance that the composite left are those of the picture without
//!    the pane; so they are summed again, tile by tile.
//!
//! Layers are over nothing, with 1-T as the opacity of the dry pane and 1 as that of drops. Which drop is nearest in a pixel, and what
//! part of it drops cover, is noted beside (`seen.rs`).
//!
//! The rain's picture is kept apart, for tiles without drops are drawn once for many frames.
//!
//! Error: what is behind the pane is one colour a pixel, seen without the pane's shift; what a drop shows is the environment or the
//! plate, at the level of the rays' spacing. Rain between the camera and the glass is left out by its distance from the camera alone
//! ([`Scene::drawn_near`]). A drop out of focus is seen from the middle of the lens.

mod aging;
mod drops;
pub(crate) mod host;
mod seen;

use std::sync::Arc;

use ash::vk;
use glam::{DVec3, Vec3};

pub(crate) use self::aging::AgingDrops;
use self::drops::Bounds;
pub(crate) use self::drops::PaneDrops;
pub use self::seen::SeenOnPane;
use super::background::Behind;
use super::environment::EnvironmentMap;
use super::frame::FrameBuffer;
use super::tile_grid;
use super::tone_map::{Source, further_sums};
use super::{rows_of, side_by_side};
use crate::Result;
use crate::abi::{PANE_BLOCK, PANE_TABLE, Pane as Constants, PaneLook};
use crate::gpu::sets::{constant, group, pane as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Memory, Recorder, Resource, Sampler, Slot, Texel,
    Texels, Use, memory_barrier, shaders, update_buffer,
};
use crate::plan::FramePlan;
use crate::scene::Scene;
use crate::scene::model::PaneModel;

/// Fewest rays of a pixel that a drop touches, through a pinhole and through a lens: 16 in focus are off by 3 to 5 grey levels
/// of 255.
const LEAST_RAYS: [u32; 2] = [16, 64];
/// Fewest by models `picture` and `color`, which leave to rays only what is in focus or nearly: FLIP over drops is up to 0.015
/// above that of `exact` with 64.
const LEAST_SHARP_RAYS: [u32; 2] = [6, 32];
/// Reflections within a drop that are followed.
const REFLECTIONS: u32 = 8;
/// Places at which it is known what a drop shows that is out of focus.
const PLACES: u32 = 64;
/// `PANE_MODEL` of `glsl/include/pane.glsl`.
const BY_RAYS: u32 = 0;
const BY_PICTURE: u32 = 1;
const BY_COLOR: u32 = 2;
/// Words before the lists of touched blocks and pixels: the groups of a dispatch, and their number, of each.
const TOUCHED: [u32; 8] = [0, 0, 1, 0, 0, 0, 1, 0];

/// The passes, and the picture with the pane.
pub struct Pane {
    buffers: Buffers,
    drops: Arc<PaneDrops>,
    /// Where these drops are; a host's frame brings its own.
    pub(crate) bounds: Bounds,
    radiance_scale: f32,
    has_plate: bool,
    has_looks: bool,
    tiles: u32,
    blocks: u32,
    samples: u32,
    least_rays: [u32; 2],
    groups: [u32; 3],
    bindings: Bindings,
    passes: Passes,
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

/// What they write.
struct Buffers {
    radiance: Buffer,
    log_sums: Buffer,
    constants: Buffer,
    touched: Buffer,
    looks: Looks,
    /// One pixel's where nobody asks.
    nearest: Buffer,
}

/// What drops look like, on the mean and at [`PLACES`] places.
struct Looks {
    buffers: [Buffer; 2],
    texels: [Texels; 2],
}

impl Looks {
    fn new(device: &Arc<Device>, drops: u32) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER | Usage::TRANSFER_SRC;
        let make = |name, bytes| Buffer::new(device, name, bytes, usage, Memory::Device);
        let drops = u64::from(drops.max(1));
        let all = make("looks of a pane's drops", size_of::<PaneLook>() as u64 * drops)?;
        let places = make(
            "places of a pane's drops",
            8 * u64::from(PLACES + PANE_TABLE * PANE_TABLE) * drops,
        )?;
        let texels = [
            Texels::new(device, "texels of looks", &all, Texel::FourWords)?,
            Texels::new(device, "texels of places", &places, Texel::TwoWords)?,
        ];
        Ok(Self { buffers: [all, places], texels })
    }
}

/// What is bound of drops and their looks.
fn slots_of<'a>(drops: &'a PaneDrops, looks: &'a Looks) -> [(Slot, Resource<'a>); 8] {
    let ([caps, cells], [all, places]) = (&drops.texels, &looks.texels);
    [
        (slot::PANE_CAPS, Resource::Buffer(&drops.caps)),
        (slot::PANE_CELLS, Resource::Buffer(&drops.cells)),
        (slot::PANE_LOOKS, Resource::Buffer(&looks.buffers[0])),
        (slot::PANE_PLACES, Resource::Buffer(&looks.buffers[1])),
        (slot::CAP_TEXELS, Resource::Texels(caps)),
        (slot::CELL_WORDS, Resource::Texels(cells)),
        (slot::LOOK_TEXELS, Resource::Texels(all)),
        (slot::PLACE_TEXELS, Resource::Texels(places)),
    ]
}

/// Their pipelines.
struct Passes {
    /// What drops out of focus look like; none where all are drawn by rays.
    looks: Option<[ComputePipeline; 3]>,
    dry: ComputePipeline,
    /// Touched blocks, touched pixels.
    find: [ComputePipeline; 2],
    rays: ComputePipeline,
    /// None where no exposure is derived.
    logs: Option<ComputePipeline>,
}

/// Whether rays are for drops in focus alone.
fn is_by_looks(plan: &FramePlan) -> bool {
    matches!(plan.pane, Some(PaneModel::Picture | PaneModel::Color))
}

impl Buffers {
    fn new(
        device: &Arc<Device>,
        (pixels, blocks, of_nearest): (u64, u32, u64),
        tiles: u32,
        looks: u32,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let (read, written) = (Usage::TRANSFER_SRC, Usage::TRANSFER_DST);
        let sums = tiles + further_sums(device.report.machine);
        let of_sums = read | written | Usage::UNIFORM_TEXEL_BUFFER;
        let listed = size_of_val(&TOUCHED) as u64 + 4 * (pixels + u64::from(blocks));
        Ok(Self {
            radiance: make("picture with a pane", 8 * pixels, read | Usage::UNIFORM_TEXEL_BUFFER)?,
            log_sums: make("log luminance with a pane", 4 * u64::from(sums), of_sums)?,
            constants: Buffer::new(
                device,
                "pane",
                size_of::<Constants>() as u64,
                Usage::UNIFORM_BUFFER | written,
                Memory::Device,
            )?,
            touched: make("touched pixels", listed, written | Usage::INDIRECT_BUFFER)?,
            looks: Looks::new(device, looks)?,
            nearest: make("nearest drops on a pane", 8 * of_nearest, read)?,
        })
    }
}

impl Passes {
    fn new(
        device: &Arc<Device>,
        bindings: &Bindings,
        plan: &FramePlan,
        has_looks: bool,
    ) -> Result<Self> {
        let is_first = plan.pane == Some(PaneModel::FirstExit);
        let model = match plan.pane {
            Some(PaneModel::Picture) => BY_PICTURE,
            Some(PaneModel::Color) => BY_COLOR,
            _ => BY_RAYS,
        };
        // No pane has the 2^26 drops that so many texels hold, so that those of any later frame fit.
        let most = device.report.limits.max_texel_buffer_elements;
        let constants = [
            [constant::BY_TEXELS, u32::from(most >= 1 << 27)],
            [constant::PANE_REFLECTIONS, if is_first { 0 } else { REFLECTIONS }],
            [constant::PANE_PLACES, PLACES],
            [constant::PANE_NEAREST, plan.nearest.into()],
            [constant::PANE_MODEL, model],
        ];
        let pipeline = |shader| ComputePipeline::new(device, shader, bindings, 0, &constants);
        let of_looks = [
            shaders::PANE_LOOKS_COMP,
            shaders::PANE_LOOKS_COMP_MEAN,
            shaders::PANE_LOOKS_COMP_TABLE,
        ];
        let by_rays = match has_looks {
            true => shaders::PANE_RAYS_COMP_BLURRED,
            false => shaders::PANE_RAYS_COMP,
        };
        let of_find = [shaders::PANE_FIND_COMP_COARSE, shaders::PANE_FIND_COMP];
        let [rays, dry] = side_by_side([by_rays, shaders::PANE_DRY_COMP], pipeline)?;
        let find = side_by_side(of_find, pipeline)?;
        let logs = plan.log_average.then(|| pipeline(shaders::PANE_LOGS_COMP)).transpose()?;
        let looks = has_looks.then(|| side_by_side(of_looks, pipeline)).transpose()?;
        Ok(Self { looks, dry, find, rays, logs })
    }
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
        let Before { frame, picture, environment, behind, drops } = before;
        let (width, height) = scene.picture_size();
        let pixels = u64::from(width) * u64::from(height);
        let (first, end) = tile_grid::of_view(&scene.view());
        let tiles = (end[0] - first[0]) * (end[1] - first[1]);
        let has_looks = is_by_looks(plan) && scene.drawn_lens() > 0.0;
        let of_nearest = if plan.nearest { pixels } else { 1 };
        let blocks = width.div_ceil(PANE_BLOCK) * height.div_ceil(PANE_BLOCK);
        let looks = if has_looks { drops.count } else { 0 };
        let buffers = Buffers::new(device, (pixels, blocks, of_nearest), tiles, looks)?;
        let nearest = Sampler::nearest(device, "plate behind a pane")?;
        let plate = match behind {
            Some(Behind::Plate(images)) => images.color.as_ref(),
            _ => None,
        };
        // Without a plate no shader reads it.
        let plate_image = plate.unwrap_or(&environment.image);
        let slots = [
            (slot::CONSTANTS, Resource::Buffer(&frame.buffer)),
            (slot::BEHIND, Resource::Buffer(picture)),
            (slot::RADIANCE, Resource::Buffer(&buffers.radiance)),
            (slot::PANE_CONSTANTS, Resource::Buffer(&buffers.constants)),
            (slot::ENVIRONMENT_MAP, Resource::Sampled(&environment.image, &environment.sampler)),
            (slot::PLATE_IMAGE, Resource::Sampled(plate_image, &nearest)),
            (slot::TOUCHED, Resource::Buffer(&buffers.touched)),
            (slot::LOG_SUMS, Resource::Buffer(&buffers.log_sums)),
            (slot::NEAREST_CAPS, Resource::Buffer(&buffers.nearest)),
        ];
        let slots: Vec<_> = slots.into_iter().chain(slots_of(drops, &buffers.looks)).collect();
        let bindings = Bindings::of(device, "pane", &slots)?;
        let [across, down, _] = group::PANE_DRY_COMP;
        Ok(Self {
            passes: Passes::new(device, &bindings, plan, has_looks)?,
            buffers,
            drops: drops.clone(),
            bounds: drops.bounds,
            radiance_scale: environment.radiance_scale,
            has_plate: plate.is_some(),
            has_looks,
            tiles,
            blocks,
            samples: plan.samples,
            least_rays: if is_by_looks(plan) { LEAST_SHARP_RAYS } else { LEAST_RAYS },
            groups: [width.div_ceil(across), height.div_ceil(down), 1],
            bindings,
        })
    }

    /// Whether it shows these drops.
    pub(crate) fn shows(&self, drops: &Arc<PaneDrops>) -> bool {
        Arc::ptr_eq(&self.drops, drops)
    }

    /// Shows other drops from the next frame on that is recorded. Frames that were recorded before keep theirs.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] if the device has no room; [`crate::Error::Limit`] if they do not fit in one binding.
    pub(crate) fn take(&mut self, device: &Arc<Device>, drops: &Arc<PaneDrops>) -> Result<()> {
        let looks = Looks::new(device, if self.has_looks { drops.count } else { 0 })?;
        self.bindings = self.bindings.but("pane", &slots_of(drops, &looks))?;
        (self.buffers.looks, self.drops, self.bounds) = (looks, drops.clone(), drops.bounds);
        Ok(())
    }

    /// Four halves a pixel, row by row from the top, in stored units.
    pub fn radiance(&self) -> &Buffer {
        &self.buffers.radiance
    }

    /// Two words a pixel of layers: number of the nearest drop, and the part of the pixel that drops cover, as bits.
    pub fn nearest(&self) -> &Buffer {
        &self.buffers.nearest
    }

    /// The drops as layers tell of them, from what `scene` shows to what `until` does.
    pub fn seen(&self, scene: &Scene, until: &Scene) -> Vec<SeenOnPane> {
        self.drops.seen(scene, until)
    }

    /// A sum of log(delta + luminance) for each tile, then those of `tone_map.rs`.
    pub fn log_sums(&self) -> &Buffer {
        &self.buffers.log_sums
    }

    /// What the display passes read.
    pub fn source(&self) -> Source<'_> {
        let Buffers { radiance, log_sums, .. } = &self.buffers;
        Source::Tiles { radiance, log_sums, count: self.tiles }
    }

    /// The constants of a frame; none of a scene without a pane.
    fn constants_of(&self, scene: &Scene) -> Option<Constants> {
        let (pane, face) = (scene.pane.as_ref()?, scene.pane_face()?);
        let (view, Bounds { lattice, tallest, overhang }) = (scene.view(), self.bounds);
        let in_view = |axis: DVec3| {
            let place = DVec3::new(axis.dot(view.right), axis.dot(view.up), axis.dot(view.back));
            place.as_vec3().to_array()
        };
        let eye = face.to_local(view.position - face.point) - lattice.corner.extend(0.0);
        let water = scene.indices().map(|index| index as f32);
        let (first, end) = tile_grid::of_view(&view);
        let least = self.least_rays[usize::from(scene.drawn_lens() > 0.0)];
        Some(Constants {
            u: in_view(face.u),
            thickness: pane.thickness as f32,
            v: in_view(face.v),
            glass: pane.index as f32,
            normal: in_view(face.normal),
            cell: lattice.cell as f32,
            eye: eye.as_vec3().to_array(),
            tallest: tallest as f32,
            motion: face.to_local(scene.pane_motion()).as_vec3().to_array(),
            overhang: overhang as f32,
            inside: (pane.inside.as_vec3() / Vec3::splat(self.radiance_scale)).to_array(),
            plate: if self.has_plate { 1.0 / self.radiance_scale } else { 0.0 },
            water,
            indices: if water[0] == water[1] && water[1] == water[2] { 1 } else { 3 },
            cells: lattice.size.to_array(),
            first_tile: first,
            tiles_across: end[0] - first[0],
            tiles: self.tiles,
            drops: self.drops.count,
            rays: self.samples.max(least),
        })
    }

    /// Records what changes with the frame; a barrier to compute and to indirect arguments must follow.
    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>, scene: &Scene) {
        let Buffers { constants, touched, .. } = &self.buffers;
        if let Some(of_frame) = self.constants_of(scene) {
            update_buffer(device, commands, constants, 0, bytemuck::bytes_of(&of_frame));
        }
        update_buffer(device, commands, touched, 0, bytemuck::bytes_of(&TOUCHED));
    }

    /// Records the picture with the pane, after that of the rain and a barrier.
    pub fn record(&self, device: &Device, commands: Recorder<'_>) {
        let Passes { looks, dry, find: [blocks, pixels], rays, logs } = &self.passes;
        let wait = |after: &[Use]| memory_barrier(device, commands, &[Use::ComputeWrite], after);
        let dispatch = |pass: &ComputePipeline, groups: [u32; 3]| {
            pass.dispatch(commands, &self.bindings, 0, &[], groups);
        };
        let all = |invocations: u32, of: [u32; 3]| rows_of(invocations.div_ceil(of[0]));
        if let (Some([places, means, tables]), count @ 1..) = (looks, self.drops.count) {
            let each = [
                (places, 0, rows_of(count * PLACES / group::PANE_LOOKS_COMP[0])),
                (means, 1, all(count, group::PANE_LOOKS_COMP_MEAN)),
                (tables, 0, rows_of(count)),
            ];
            for (pass, number, groups) in each {
                wait(&[Use::ComputeWrite, Use::ComputeRead]);
                match &self.drops.groups {
                    Some(of) => {
                        pass.dispatch_indirect(commands, &self.bindings, &[], of, 16 * number);
                    }
                    None => dispatch(pass, groups),
                }
            }
        }
        dispatch(dry, self.groups);
        dispatch(blocks, all(self.blocks, group::PANE_FIND_COMP_COARSE));
        let indirect = |pass: &ComputePipeline, list: u64| {
            wait(&[Use::ComputeWrite, Use::ComputeRead, Use::Indirect]);
            pass.dispatch_indirect(commands, &self.bindings, &[], &self.buffers.touched, 16 * list);
        };
        indirect(pixels, 0);
        indirect(rays, 1);
        if let Some(logs) = logs {
            wait(&[Use::ComputeWrite]);
            dispatch(logs, all(self.tiles, group::PANE_LOGS_COMP));
        }
    }
}
