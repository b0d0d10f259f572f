//! The picture from the tiles' lists (`glsl/composite.comp`): every tile's drops over one another,
//! front to back, exactly in order; the sky behind.
//!
//! One invocation a tile of 4 x 2 pixels, not a pixel: neighbouring lanes then read different drops,
//! each of which meets most of the tile's pixels, and the pixels stay in registers from the nearest
//! drop to the sky. With a lane a pixel, lanes would read the same drops over and over, most of them
//! to find that they do not touch; on CPU drivers reading is what costs.
//!
//! The order is by distance (of blocks: their drops' tangents' length), then index, a total one, so that
//! the picture is the same on every run. The lists come nearly in order (`tiles.rs`); each tile takes the
//! nearest of the next six entries (`glsl/include/tile_window.glsl`) and knows afterwards whether that
//! was right. The few tiles where it was not are done again by a second dispatch, their lists sorted
//! (`tile_order.glsl`; on a GPU before it, by `order_lists.comp`).
//!
//! Streaks are in lists of their own, which a tile walks once before each of its larger drops. What an invocation may walk is
//! bounded, on a GPU by `MOST_STREAKS`, on llvmpipe by the driver. So a tile with many of both is left to a third dispatch, a
//! workgroup a tile, which walks them once (`crowded_tile.glsl`): whether or not it is, the tile has the same bytes.
//!
//! No dispatch goes through more than `MOST_ENTRIES` of a list, so that each ends before a watchdog would reset the device. Longer
//! lists, of very many drops on few pixels, are gone on with by further dispatches (`unfinished_tile.glsl`), and are not sorted: that
//! they may be out of order is told.
//!
//! Where lists are short, `glsl/tiles_to_draw.comp` first sorts the tiles by how much there is to do in them: several
//! entries, one splat, one block, none. Each of these has a pipeline of its own, so that no lane runs or waits for what
//! only others need. A tile without entries is drawn only if the sky is new, or if it had some when it was drawn last:
//! the picture is kept from frame to frame.
//!
//! A drop's outline is the true ellipse; the part of a pixel that it covers keeps the sum over all
//! pixels equal to the outline's area. Up to some pixels of radius its colour comes from the
//! prefiltered pictures (`appearance.rs`). Above, `glsl/rays.comp` has computed its pixels before:
//! the closed form along rays through several places of the pixel, one invocation a pixel; in several dispatches where they
//! are many (`pieces.rs`).

mod buffers;

use std::sync::Arc;

use super::background::{Background, Behind, HostBackground};
use super::frame::Frame;
use super::shelter::ShelterMap;
use super::tiles::Tiles;
use super::tone_map::Source;
use super::totals::{
    CROWDED_GROUPS, DISORDERED_GROUPS, LARGE_GROUPS, LINE_GROUPS, LISTED_GROUPS, ORDER_GROUPS,
    RAY_GROUPS, SHARED_GROUPS, UNFINISHED_GROUPS,
};
use super::{rows_of, side_by_side};
use crate::Result;
use crate::abi::{LISTED_TILES, LISTS};
use crate::gpu::sets::{constant, group};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Recorder, Use, fill_buffer, memory_barrier, shaders,
};
use crate::plan::FramePlan;
use crate::rain::field::Seen;
use crate::rain::medium::MediumRecord;
use buffers::Buffers;
pub use buffers::Prepared;

/// Pixels of a workgroup of the sky's pass: whole tiles.
const SKY_GROUP: [u32; 3] = group::SKY_COMP;

/// The passes.
pub struct Composite {
    /// The picture: four halves a pixel, row by row from the top, in stored units.
    pub radiance: Buffer,
    /// Two words a pixel, where they are wanted: the number of its nearest drop's record (`Tiles::records`), without one `END`;
    /// and how many drops cover a part of it.
    pub nearest: Option<Buffer>,
    /// A sum of log(delta + luminance) for each tile, then those of `tone_map.rs`.
    pub log_sums: Buffer,
    /// Sums of the lines that bright sources draw along streaks, which composite reads; none where there are none.
    line_sums: Option<Buffer>,
    /// Pixels of the tiles, across and down.
    in_tiles: (u32, u32),
    tiles: u32,
    /// Whether the sky is the same as in the frame before.
    keeps_sky: bool,
    /// What the sky is drawn for by all that was recorded since a number, and whether one of these was executed.
    sky_of: Option<SkyKey>,
    sky_since: u32,
    sky_is_there: bool,
    /// Whether surfaces keep a part of the medium off.
    is_sheltered: bool,
    /// Whether what is behind the drops, or what they show, is another with every frame.
    changes: bool,
    groups: [u32; 3],
    /// Whether many tiles have few drops, so that they are listed.
    is_listed: bool,
    bindings: Bindings,
    passes: Passes,
}

/// Their pipelines.
struct Passes {
    sky: SkyPass,
    /// What streaks of one colour show; none where there are none.
    streak_layer_light: Option<ComputePipeline>,
    rays: ComputePipeline,
    /// Adds the images of bright sources to large drops, then to those that take long; none where there are no sources.
    glints: Option<[ComputePipeline; 2]>,
    /// Sums up the lines that they draw along streaks; none where there are none.
    lines: Option<ComputePipeline>,
    composite: ComputePipeline,
    /// None where there may be streaks, which are in lists of their own.
    listed: Option<Listed>,
    /// None where each of the invocations of `disordered` sorts its own list.
    order: Option<ComputePipeline>,
    disordered: ComputePipeline,
    /// None where there are no streaks.
    crowded: Option<ComputePipeline>,
    /// None where no list is expected to be so long.
    long: Option<ComputePipeline>,
}

/// The passes by which tiles are drawn by how much there is to do in them: those without drops not at all while the sky behind
/// them stays. Views of all sizes and numbers of drops have them, as they have all pipelines.
struct Listed {
    to_draw: ComputePipeline,
    groups: u32,
    /// The pipelines for tiles with one splat, with one block, and with nothing.
    few: [ComputePipeline; LISTS as usize - 1],
}

/// What fills in what is behind the drops.
enum SkyPass {
    Environment(ComputePipeline),
    Background(Box<Background>),
}

/// What the sky depends on: of the frame's constants axes, image, principal point, lens and window, and the camera's place; the
/// medium of far rain.
type SkyKey = ([[f32; 4]; 5], [f32; 4], [u32; 4], [[f32; 4]; 2], Option<MediumRecord>);

/// `is_sheltered`: what surfaces keep off of the medium depends on where the camera is.
fn sky_key(frame: &Frame, seen: Option<&Seen>, is_sheltered: bool) -> SkyKey {
    let Frame { right, up, back, image, principal, lens, window, .. } = *frame;
    let place = if is_sheltered { [frame.camera_high, frame.camera_low] } else { [[0.0; 4]; 2] };
    let of_camera = [right, up, back, image, principal];
    (of_camera, lens, window, place, seen.and_then(|seen| seen.medium))
}

impl Passes {
    fn new(
        device: &Arc<Device>,
        prepared: Prepared<'_>,
        (buffers, bindings): (&Buffers, &Bindings),
        plan: &FramePlan,
        behind: Option<&Behind>,
    ) -> Result<Self> {
        let Prepared { glints, tiles, .. } = prepared;
        let sorts_before = device.report.machine.sorts_by_workgroups();
        let own = [
            [constant::LOG_SUMS, plan.log_average.into()],
            [constant::PREFETCH, tiles.prefetch.into()],
            [constant::GLINTS, glints.count],
            [constant::GLINT_LANES, device.report.machine.glint_lanes()],
            [constant::SORTED_BEFORE, sorts_before.into()],
            [constant::LAYERS, plan.layers.into()],
        ];
        let constants: Vec<_> = tiles.constants.iter().copied().chain(own).collect();
        // It writes the nodes that it reads.
        let in_words: Vec<_> = constants
            .iter()
            .map(|[id, value]| [*id, if *id == constant::BY_TEXELS { 0 } else { *value }])
            .collect();
        let pushed = |shader, bytes, constants: &[_]| {
            ComputePipeline::new(device, shader, bindings, bytes, constants)
        };
        let pipeline = |shader| pushed(shader, 0, &constants);
        let maybe = |is_wanted: bool, shader| is_wanted.then(|| pipeline(shader)).transpose();
        let sky = || -> Result<SkyPass> {
            let Some(behind) = behind else {
                let shader = match (tiles.has_cells(), tiles.shelter().is_some()) {
                    (true, true) => shaders::SKY_COMP_MEDIUM_SHELTER,
                    (true, false) => shaders::SKY_COMP_MEDIUM,
                    (false, _) => shaders::SKY_COMP,
                };
                return Ok(SkyPass::Environment(pipeline(shader)?));
            };
            let pass = Background::new(device, prepared, &buffers.sky, behind, plan.layers)?;
            Ok(SkyPass::Background(Box::new(pass)))
        };
        let listed = || -> Result<Option<Listed>> {
            if tiles.has_streak_layer() {
                return Ok(None);
            }
            let listing = LISTED_TILES * group::TILES_TO_DRAW_COMP[0];
            Ok(Some(Listed {
                to_draw: pushed(shaders::TILES_TO_DRAW_COMP, 4, &constants)?,
                groups: tiles.count.div_ceil(listing),
                few: side_by_side(std::array::from_fn(|list| list as u32 + 1), |list| {
                    pushed(
                        shaders::COMPOSITE_COMP_FEW,
                        0,
                        &[&constants[..], &[[constant::LIST, list]]].concat(),
                    )
                })?,
            }))
        };
        let (of_all, (of_glints, others)) = rayon::join(
            || -> Result<_> {
                let all = side_by_side(
                    [
                        (shaders::COMPOSITE_COMP_DISORDERED, 0, &in_words),
                        (shaders::COMPOSITE_COMP, 4, &constants),
                        (shaders::RAYS_COMP, 4, &constants),
                    ],
                    |(shader, bytes, constants)| pushed(shader, bytes, constants),
                )?;
                Ok((all, listed()?))
            },
            || {
                rayon::join(
                    || -> Result<_> {
                        let shaders = [shaders::GLINTS_COMP, shaders::GLINTS_COMP_SHARED];
                        let both = || side_by_side(shaders, pipeline);
                        let of_large = (glints.count > 0).then(both).transpose()?;
                        Ok((of_large, maybe(buffers.line_sums.is_some(), shaders::LINES_COMP)?))
                    },
                    || -> Result<_> {
                        let of_streak_layer =
                            [shaders::STREAK_LAYER_LIGHT_COMP, shaders::COMPOSITE_COMP_CROWDED];
                        let both = || side_by_side(of_streak_layer, pipeline);
                        Ok((sky()?, tiles.has_streak_layer().then(both).transpose()?))
                    },
                )
            },
        );
        let order = maybe(sorts_before, shaders::ORDER_LISTS_COMP)?;
        let long = (tiles.long_lists.walks > 0)
            .then(|| pushed(shaders::COMPOSITE_COMP_LONG, 8, &constants))
            .transpose()?;
        let ([disordered, composite, rays], listed) = of_all?;
        let (glints, lines) = of_glints?;
        let (sky, of_streak_layer) = others?;
        let (streak_layer_light, crowded) =
            of_streak_layer.map(|[light, crowded]| (light, crowded)).unzip();
        Ok(Self {
            sky,
            streak_layer_light,
            rays,
            glints,
            lines,
            composite,
            listed,
            order,
            disordered,
            crowded,
            long,
        })
    }
}

impl Composite {
    /// The passes for an image of this size. `is_renewed`: the environment is another with every frame.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the image does not fit in one binding; [`crate::Error::Memory`] if the
    /// device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        prepared: Prepared<'_>,
        (width, height): (u32, u32),
        plan: &FramePlan,
        behind: Option<&Behind>,
        is_renewed: bool,
    ) -> Result<Self> {
        let Prepared { glints, tiles, .. } = prepared;
        let pixels = u64::from(width) * u64::from(height);
        let has_lines = tiles.has_streak_layer() && glints.count > 0;
        let is_listed = !tiles.has_streak_layer() && tiles.bands() == 1;
        let buffers = Buffers::new(device, tiles, pixels, plan.nearest, is_listed, has_lines)?;
        let texels = buffers.texels(device, prepared)?;
        let bindings = buffers.bindings(device, prepared, &texels)?;
        let of = (&buffers, &bindings);
        let passes = Passes::new(device, prepared, of, plan, behind)?;
        let Buffers { radiance, nearest, log_sums, line_sums, .. } = buffers;
        let is_by_host = matches!(behind, Some(Behind::Host { .. }))
            || tiles.shelter().is_some_and(ShelterMap::renews_medium);
        Ok(Self {
            radiance,
            nearest,
            log_sums,
            line_sums,
            in_tiles: tiles.in_pixels,
            tiles: tiles.count,
            keeps_sky: false,
            sky_of: None,
            sky_since: 0,
            sky_is_there: false,
            is_sheltered: tiles.shelter().is_some(),
            changes: is_renewed || plan.is_grainy() || is_by_host,
            // All tiles of whole regions.
            groups: rows_of(tiles.in_regions.div_ceil(64)),
            is_listed,
            bindings,
            passes,
        })
    }

    /// What the display passes read.
    pub fn source(&self) -> Source<'_> {
        Source::Tiles { radiance: &self.radiance, log_sums: &self.log_sums, count: self.tiles }
    }

    /// Whether the commands of this number, which are being recorded, must draw the sky of `frame`: it is kept as long
    /// as the view stands still, once one of the recordings that draw it was executed ([`Composite::executed`]).
    pub fn needs_sky(&mut self, frame: &Frame, seen: Option<&Seen>, recording: u32) -> bool {
        let key = Some(sky_key(frame, seen, self.is_sheltered));
        if self.sky_of != key {
            self.sky_of = key;
            (self.sky_since, self.sky_is_there) = (recording, false);
        }
        self.keeps_sky = self.sky_is_there && !self.changes;
        !self.keeps_sky
    }

    /// Takes a host's images for the frame that is to be recorded.
    ///
    /// # Errors
    /// See [`Background::set_images`].
    ///
    /// # Safety
    /// That of [`Background::set_images`].
    pub unsafe fn set_images(&mut self, set: usize, images: &HostBackground) -> Result<()> {
        match &mut self.passes.sky {
            SkyPass::Environment(_) => Ok(()),
            // SAFETY: by contract.
            SkyPass::Background(pass) => unsafe { pass.set_images(set, images) },
        }
    }

    /// Recording `recording` was executed, or will be, before any that is yet to be recorded. (What was recorded and
    /// never executed leaves no sky.)
    pub fn executed(&mut self, recording: u32) {
        // Numbers are modulo 2^32.
        self.sky_is_there |= recording.wrapping_sub(self.sky_since) < u32::MAX / 2;
    }

    /// Records the sky, when the frame's constants are ready, and what streaks show, which needs the splats' table.
    pub fn record_sky(&self, device: &Device, commands: Recorder<'_>) {
        let (across, down) = self.in_tiles;
        let groups = [across.div_ceil(SKY_GROUP[0]), down.div_ceil(SKY_GROUP[1]), 1];
        match &self.passes.sky {
            SkyPass::Environment(pass) => pass.dispatch(commands, &self.bindings, 0, &[], groups),
            SkyPass::Background(pass) => pass.record(commands, groups),
        }
        if let Some(streak_layer_light) = &self.passes.streak_layer_light {
            let groups = rows_of(self.tiles.div_ceil(64));
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeRead]);
            streak_layer_light.dispatch(commands, &self.bindings, 0, &[], groups);
        }
    }

    /// Records the pixels of the large drops, after the tiles' lists and a barrier.
    pub fn record_rays(&self, device: &Device, commands: Recorder<'_>, tiles: &Tiles) {
        for piece in 0..tiles.ray_pieces.count {
            if piece > 0 {
                // They write to other places of the same buffers, which no layer can know.
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
            }
            let (push, at) = (bytemuck::bytes_of(&piece), RAY_GROUPS + 16 * u64::from(piece));
            let (rays, totals) = (&self.passes.rays, tiles.totals());
            rays.dispatch_indirect(commands, &self.bindings, push, totals, at);
        }
    }

    /// Records the reset of what is summed up. A barrier to compute must follow.
    pub fn record_reset(&self, device: &Device, commands: Recorder<'_>) {
        if let Some(sums) = &self.line_sums {
            fill_buffer(device, commands, sums, 0..sums.size, 0);
        }
    }

    /// Records the images of bright sources in the large drops, after [`Composite::record_rays`] and a barrier, if
    /// there are sources; and then their lines along streaks.
    pub fn record_glints(&self, device: &Device, commands: Recorder<'_>, tiles: &Tiles) {
        if let Some([glints, shared]) = &self.passes.glints {
            let (bindings, totals) = (&self.bindings, tiles.totals());
            glints.dispatch_indirect(commands, bindings, &[], totals, LARGE_GROUPS);
            let after = [Use::ComputeWrite, Use::ComputeRead, Use::Indirect];
            memory_barrier(device, commands, &[Use::ComputeWrite], &after);
            shared.dispatch_indirect(commands, bindings, &[], totals, SHARED_GROUPS);
        }
        if let Some(lines) = &self.passes.lines {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeRead]);
            lines.dispatch_indirect(commands, &self.bindings, &[], tiles.totals(), LINE_GROUPS);
        }
    }

    /// Records the drops over one another and the sky behind, after [`Composite::record_glints`]
    /// and a barrier.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, tiles: &Tiles) {
        let (passes, bindings, totals) = (&self.passes, &self.bindings, tiles.totals());
        let after = [Use::ComputeWrite, Use::ComputeRead, Use::Indirect];
        let is_listed = u32::from(self.is_listed).to_ne_bytes();
        match &passes.listed {
            Some(Listed { to_draw, groups, few }) if self.is_listed => {
                let new_sky = u32::from(!self.keeps_sky).to_ne_bytes();
                to_draw.dispatch(commands, bindings, 0, &new_sky, [*groups, 1, 1]);
                let several = (&passes.composite, &is_listed[..]);
                let all = std::iter::once(several).chain(few.iter().map(|pass| (pass, &[][..])));
                for (list, (pass, push)) in (0..).zip(all) {
                    // They write to other places of the same buffers, which no layer can know.
                    memory_barrier(device, commands, &[Use::ComputeWrite], &after);
                    let groups = LISTED_GROUPS + 16 * list;
                    pass.dispatch_indirect(commands, bindings, push, totals, groups);
                }
            }
            _ => passes.composite.dispatch(commands, bindings, 0, &is_listed, self.groups),
        }
        if let Some(order) = &passes.order {
            memory_barrier(device, commands, &[Use::ComputeWrite], &after);
            order.dispatch_indirect(commands, bindings, &[], totals, ORDER_GROUPS);
        }
        memory_barrier(device, commands, &[Use::ComputeWrite], &after);
        passes.disordered.dispatch_indirect(commands, bindings, &[], totals, DISORDERED_GROUPS);
        if let Some(crowded) = &passes.crowded {
            memory_barrier(device, commands, &[Use::ComputeWrite], &after);
            crowded.dispatch_indirect(commands, bindings, &[], totals, CROWDED_GROUPS);
        }
        for (walk, long) in (0..tiles.long_lists.walks).zip(passes.long.iter().cycle()) {
            memory_barrier(device, commands, &[Use::ComputeWrite], &after);
            let push = [walk, tiles.long_lists.walks];
            let push = bytemuck::bytes_of(&push);
            long.dispatch_indirect(commands, bindings, push, totals, UNFINISHED_GROUPS);
        }
    }
}
