//! Which drops fall on which tile of the image, without touching a drop that is out of view for
//! long. Compute passes:
//!
//! 1. `clusters`: whole clusters of the rain out of view are passed over (four of five), the others
//!    sorted into bins, by band of depth and region of the image (`bin_starts`, `sort_clusters`);
//! 2. `gather`, band after band, the farthest first: each of their drops finds its place and its outline.
//!    Nineteen of twenty in view are splats: so small that two colours will do. They become nodes of 32 bytes, pushed
//!    to the front of the lists of their one to four tiles of 4 x 2 pixels; the numbers of the
//!    others are noted;
//! 3. `large`: those get a block for each tile that they touch (`big`: where there are more than 12,
//!    by a workgroup each), and each block finds its coverage and colours and is pushed to the list
//!    of its tile (`blocks`). Those as small as splats, but on three rows of tiles, are two of them.
//!
//! Linked lists, because they need one atomic exchange an entry, where lists in a row take one to
//! count, one to fill, and a pass between. Thanks to the bands they are nearly in order, nearest first:
//! what is left is for `composite.rs`.
//!
//! No pass uses shared memory or barriers within a workgroup, poison on CPU drivers.

mod constants;
mod source;

use std::sync::Arc;

use ash::vk;

use self::constants::constants_of;
use self::source::Source;
use super::appearance::FarDrop;
use super::cells::Cells;
use super::counters;
use super::frame::{Frame, FrameBuffer};
use super::layers::DropRecords;
use super::pieces::{LongLists, RayPieces, rays_of_a_pixel};
use super::placed::PlacedDrops;
use super::rain_field::RainField;
use super::room::Room;
use super::shapes::Shapes;
use super::shelter::ShelterMap;
use super::streak_layer::StreakLayer;
use super::tile_grid::{Regions, TILE, TILE_PIXELS, of_view};
use super::tile_lists::{Lists, TileTexels};
use super::totals::{
    BIG_GROUPS, BLOCK_GROUPS, COUNTS_WORDS, GATHER_GROUPS, GROUPS_WORDS, LARGE_GROUPS, MAX_BINS,
    SORT_GROUPS,
};
use super::{rows_of, side_by_side};
use crate::Result;
use crate::abi::{CLUSTER, END, MAX_BANDS, STRETCHES};
use crate::gpu::sets::{constant, group, tile_frame, tiles as slot};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, Machine, Memory, Recorder, Resource, Slot, Texel,
    Texels, Use, fill_buffer, memory_barrier, shaders, update_buffer,
};
use crate::plan::FramePlan;
use crate::rain::cells::Lattice;
use crate::rain::field::Seen;
use crate::scene::Scene;
use crate::scene::model::{Lens, Motion};
use crate::scene::projection::View;

/// Tiles that a drop at the paper's sizes touches.
const TILES_A_DROP: f64 = 2.0;
/// Part of all drops that is in view at the paper's 90°, at most.
const SHARE_IN_VIEW: f64 = 0.18;
/// Drops of one band that fall on a tile on the mean. A list is in order except within a band, and `tile_window.glsl`
/// reorders six entries at a time; with more drops a band, more tiles would need the second dispatch.
const DROPS_A_BAND: f64 = 1.5;
/// Clusters of a workgroup of `clusters`.
const CLUSTERS_GROUP: u32 = group::CLUSTERS_COMP[0];

/// The passes and what they hand on.
pub struct Tiles {
    /// Tiles in the image.
    pub count: u32,
    /// Their pixels, across and down.
    pub(super) in_pixels: (u32, u32),
    /// Invocations that draw them: all tiles of whole regions.
    pub(super) in_regions: u32,
    /// Whether they read ahead what their neighbours need: see `prefetch_nodes` in `composite.comp`.
    pub(super) prefetch: bool,
    /// What was counted (see [`counters`]).
    pub counters: Buffer,
    /// What passes read a texel at a time.
    pub(super) texels: TileTexels,
    /// Specialization constants of all passes over the tiles.
    pub(super) constants: Vec<[u32; 2]>,
    /// The drops' records, where each pixel's nearest drop is wanted.
    pub(crate) records: Option<DropRecords>,
    source: Source,
    pub(crate) lists: Lists,
    /// Which dispatches draw blocks by rays.
    pub(crate) ray_pieces: RayPieces,
    pub(super) long_lists: LongLists,
    /// What frames say of the tiles, of the room in their lists, and of clusters.
    in_frame: [[u32; 4]; 3],
    /// Set 0 of all stages of the frame.
    pub(super) shared: Arc<Bindings>,
    bindings: Bindings,
    passes: Passes,
    pub(super) placed: PlacedDrops,
    pub(super) shapes: Shapes,
    /// What keeps rain off; none in a scene without a shelter.
    shelter: Option<ShelterMap>,
    pub(super) streak_layer: StreakLayer,
}

/// The pipelines.
struct Passes {
    clusters: ComputePipeline,
    bin_starts: ComputePipeline,
    sort_clusters: ComputePipeline,
    gather: ComputePipeline,
    large: ComputePipeline,
    big: ComputePipeline,
    blocks: ComputePipeline,
}

impl Passes {
    /// `has_cells`: drops are those of cells. `has_shelter`: a [`ShelterMap`] is bound.
    fn new(
        device: &Arc<Device>,
        bindings: &Bindings,
        constants: &[[u32; 2]],
        [has_cells, has_shelter]: [bool; 2],
    ) -> Result<Self> {
        let by = |of_cells, of_clusters| if has_cells { of_cells } else { of_clusters };
        let find = by(shaders::CELLS_COMP, shaders::CLUSTERS_COMP);
        let starts = by(shaders::BIN_STARTS_COMP_CELLS, shaders::BIN_STARTS_COMP);
        let sort = by(shaders::SORT_CLUSTERS_COMP_CELLS, shaders::SORT_CLUSTERS_COMP);
        let gather = match has_shelter {
            true => by(shaders::GATHER_COMP_CELLS_SHELTER, shaders::GATHER_COMP_SHELTER),
            false => by(shaders::GATHER_COMP_CELLS, shaders::GATHER_COMP),
        };
        let large = by(shaders::LARGE_COMP_CELLS, shaders::LARGE_COMP);
        let (big, blocks) = (shaders::BIG_COMP, shaders::BLOCKS_COMP);
        let [blocks, large, gather, clusters, bin_starts, sort_clusters, big] = side_by_side(
            [(blocks, 0), (large, 0), (gather, 8), (find, 0), (starts, 0), (sort, 0), (big, 0)],
            |(shader, bytes)| ComputePipeline::new(device, shader, bindings, bytes, constants),
        )?;
        Ok(Self { clusters, bin_starts, sort_clusters, gather, large, big, blocks })
    }
}

/// What a picture has too many of for a device, of [`crate::Error::Limit`].
pub(crate) const PIXELS: &str = "the picture's number of pixels";

/// Refuses more drops, or more tiles, than the passes can number on a device.
fn check_limits(device: &Device, drops: u64, tiles: u32) -> Result<()> {
    let limits = &device.report.limits;
    let range = u64::from(limits.max_storage_buffer_range);
    let groups = u64::from(limits.max_compute_work_group_count[0]);
    // Their order, a word each, is one binding, and one dispatch goes over their clusters, of which
    // random and placed drops each fill up a last one.
    let most_clusters = groups / u64::from(STRETCHES) * u64::from(STRETCHES * CLUSTERS_GROUP);
    let most_drops = (range / 4).min(most_clusters * u64::from(CLUSTER)) - 2 * u64::from(CLUSTER);
    device.report.check_limit("the number of drops in tiles", drops, most_drops)?;
    // A row of workgroups takes an invocation for each disordered tile, of which there may be as many as
    // tiles; pixels, 8 bytes each, are one binding.
    let most_pixels = (TILE_PIXELS * 64 * groups).min(range / 8);
    device.report.check_limit(PIXELS, TILE_PIXELS * u64::from(tiles), most_pixels)
}

impl Tiles {
    /// Buffers and pipelines for pictures of the size of `scene`'s. `has_depth`: what is behind the drops hides those that
    /// are farther.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the drops or the image's pixels are more than the device's bindings or
    /// dispatches take; [`crate::Error::Memory`] if it has no room for them; [`crate::Error::Vulkan`] if the
    /// driver refuses.
    pub(crate) fn new(
        device: &Arc<Device>,
        frame: &FrameBuffer,
        FarDrop { appearance, glints, flat, .. }: &FarDrop,
        rain: &RainField,
        scene: &Scene,
        plan: &FramePlan,
        has_depth: bool,
    ) -> Result<Self> {
        let cells = Cells::new(device, scene, plan)?;
        let drops = match &cells {
            Some(cells) => u64::from(cells.room[0]) * u64::from(CLUSTER),
            None => scene.drop_count().into(),
        };
        let (first, end) = of_view(&scene.view());
        let (across, down) = (end[0] - first[0], end[1] - first[1]);
        let count = across * down;
        let regions = Regions::of(across, down);
        check_limits(device, drops, count)?;
        let in_view = cells.as_ref().map_or(drops as f64 * SHARE_IN_VIEW, |cells| cells.drops);
        let a_tile = in_view * TILES_A_DROP / f64::from(count);
        let bands = ((a_tile / DROPS_A_BAND).ceil() as u32).clamp(1, MAX_BANDS);
        let has_cells = cells.is_some();
        let (source, [clusters, others]) = Source::new(device, scene, rain, cells)?;

        let room = Room::of(&device.report, plan, count, (drops, clusters), has_cells);
        let most_groups = device.report.limits.max_compute_work_group_count[0];
        let ray_pieces = RayPieces::of(room.blocks, rays_of_a_pixel(plan), most_groups);
        let long_lists = LongLists::of(room.nodes, a_tile, scene.drops.len(), plan.room);
        let in_frame = [
            [count, regions.shift, regions.across, regions.count],
            [room.nodes as u32, room.blocks as u32, room.larges as u32, bands],
            [clusters, others, ray_pieces.blocks, long_lists.tiles],
        ];

        let lists = Lists::new(device, &room, count)?;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let make = |name, bytes| Buffer::new(device, name, bytes, storage, Memory::Device);
        // With real rain these are the cells in view that hold drops.
        let found = 16 * u64::from(if has_cells { others } else { clusters });
        let by_texels = storage | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER;
        let found = Buffer::new(device, "clusters in view", found, by_texels, Memory::Device)?;
        // Without a depth no shader reads or writes it.
        let pixels_behind = if has_depth { TILE_PIXELS * u64::from(count) } else { 1 };
        let behind = make("distances behind", 4 * pixels_behind)?;
        let moves = plan.motion != Motion::Instant;
        let lens = plan.lens != Lens::Pinhole;
        let in_clusters = match &source {
            Source::Clusters(sorted) => sorted.placed.clone(),
            Source::Cells(_) => Arc::default(),
        };
        let shelter = ShelterMap::new(device, scene)?;
        let in_pixels = (across * TILE.0, down * TILE.1);
        let streak_layer = StreakLayer::new(device, scene, plan, in_pixels, in_view)?;
        let mut constants = constants_of(scene, plan, [has_cells, has_depth]);
        let placed = PlacedDrops::new(device, (frame, &constants), scene, moves, in_clusters)?;
        let shapes = Shapes::new(device, scene, plan, room.larges)?;
        // Without cells no shader reads them.
        let tables = source.cells().map_or(&found, |cells| &cells.tables);
        // Cells have none.
        let boxes = source.boxes().unwrap_or(&found);
        let read = [
            &appearance.table,
            source.order(),
            boxes,
            &found,
            &placed.buffer,
            &shapes.given,
            &glints.sources,
            tables,
        ];
        let texels = TileTexels::of(device, &lists, read)?;
        // The sky has a texel for two pixels.
        let most = device.report.limits.max_texel_buffer_elements;
        let reads_texels = texels.are_whole()
            && u64::from(count) * TILE_PIXELS / 2 <= most.into()
            && Texels::fit(device, &streak_layer.buffer, Texel::TwoWords);
        let for_gpu = device.report.machine.is_gpu();
        constants.extend([
            [constant::BY_TEXELS, reads_texels.into()],
            [constant::FOR_GPU, for_gpu.into()],
        ]);
        let large_moves =
            make("motions of large drops", 32 * if moves || lens { room.larges } else { 1 })?;
        let records = match plan.nearest {
            true => Some(DropRecords::new(device, room.nodes + room.larges, scene)?),
            false => None,
        };
        let counters = counters::buffer(device)?;
        let shared = [
            (tile_frame::CONSTANTS, &frame.buffer),
            // Without cells no shader reads it.
            (tile_frame::RAIN_FIELD, source.cells().map_or(&frame.buffer, |cells| &cells.field)),
            (tile_frame::RAIN_TABLES, tables),
            (tile_frame::BEHIND, &behind),
            (tile_frame::TOTALS, &lists.totals),
            (tile_frame::NODES, &lists.nodes),
            (tile_frame::HEADS, &lists.heads),
            (tile_frame::LARGES, &lists.larges),
            (tile_frame::MOVES, &large_moves),
            (tile_frame::LARGE_SHAPES, &shapes.large),
            (tile_frame::BLOCKS, &lists.blocks),
            (tile_frame::PICTURES, &appearance.table),
            (tile_frame::SOURCES, &glints.sources),
            (tile_frame::BOW, &glints.bow),
            (tile_frame::STREAK_LAYER, &streak_layer.buffer),
            (tile_frame::COUNTERS, &counters),
        ]
        .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)));
        let [words, four] = &texels.tables;
        let of_texels = [
            (tile_frame::TOTAL_WORDS, &texels.totals),
            (tile_frame::TABLE_WORDS, words),
            (tile_frame::TABLE_TEXELS, four),
            (tile_frame::LARGE_TEXELS, &texels.larges),
            (tile_frame::BLOCK_WORDS, &texels.blocks),
            (tile_frame::SOURCE_TEXELS, &texels.sources),
        ]
        .map(|(slot, view)| (slot, Resource::Texels(view)));
        let shared: Vec<_> = shared.into_iter().chain(of_texels).collect();
        let shared = Arc::new(Bindings::of(device, "tile frame", &shared)?);
        // Without records no shader reads or writes them.
        let record_slots = DropRecords::slots(records.as_ref(), (&found, &frame.buffer));
        let buffers = [
            (slot::DROP_ORDER, source.order()),
            (slot::CLUSTER_BOXES, boxes),
            (slot::IN_VIEW, &found),
            (slot::PLACED_DROPS, &placed.buffer),
            (slot::PLACED_MOTIONS, &placed.motions),
            (slot::SHAPES, &shapes.given),
            (slot::BIGS, &lists.bigs),
            // Without flattened drops no shader reads it.
            (slot::FLAT_LIGHT, flat.as_ref().map_or(&appearance.table, |flat| &flat.table)),
        ];
        let buffers = buffers.into_iter().chain(record_slots);
        let views = [
            (slot::PICTURE_TEXELS, &texels.pictures),
            (slot::ORDER_WORDS, &texels.order),
            (slot::BOX_TEXELS, &texels.boxes),
            (slot::IN_VIEW_WORDS, &texels.in_view),
            (slot::SHAPE_TEXELS, &texels.shapes),
            (slot::PLACED_TEXELS, &texels.placed),
        ];
        let slots: Vec<_> = buffers
            .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)))
            .chain(views.map(|(slot, view)| (slot, Resource::Texels(view))))
            .chain(shelter.iter().flat_map(|all| all.slots([slot::HEIGHT_MAP, slot::SHELTER])))
            .collect();
        let bindings = Bindings::of(device, "tiles", &slots)?.beside(&shared);
        let passes = Passes::new(device, &bindings, &constants, [has_cells, shelter.is_some()])?;
        Ok(Self {
            count,
            in_pixels,
            in_regions: regions.tiles,
            // Where each word read is dear, it costs more than it saves.
            prefetch: device.report.machine == Machine::Cpu && reads_texels && plan.splat_px > 0.0,
            counters,
            records,
            source,
            in_frame,
            passes,
            lists,
            ray_pieces,
            long_lists,
            constants,
            texels,
            shared,
            bindings,
            placed,
            shapes,
            shelter,
            streak_layer,
        })
    }

    /// Whether drops come from the cells of real rain.
    pub(super) fn has_cells(&self) -> bool {
        self.source.cells().is_some()
    }

    /// The lattices of real rain.
    pub fn lattices(&self) -> &[Lattice] {
        self.source.cells().map_or(&[], Cells::lattices)
    }

    /// The map of the surfaces that keep rain off, if there are any.
    pub(crate) fn shelter(&self) -> Option<&ShelterMap> {
        self.shelter.as_ref()
    }

    /// What is bound for passes that ask for these surfaces.
    pub(super) fn shelter_slots(
        &self,
        slots: [Slot; 2],
    ) -> impl Iterator<Item = (Slot, Resource<'_>)> {
        self.shelter.iter().flat_map(move |shelter| shelter.slots(slots))
    }

    /// Numbers of workgroups that the passes leave for indirect dispatches.
    pub(crate) fn totals(&self) -> &Buffer {
        &self.lists.totals
    }

    /// Whether there may be streaks of one colour.
    pub(super) fn has_streak_layer(&self) -> bool {
        self.streak_layer.reset > 0
    }

    /// Large drops that there is room for.
    pub(super) fn room_for_larges(&self) -> u64 {
        self.in_frame[1][2].into()
    }

    /// Ranges of depth.
    pub(super) fn bands(&self) -> u32 {
        self.in_frame[1][3]
    }

    /// Completes a frame's constants.
    pub fn complete(&self, frame: &mut Frame) {
        [frame.tiles, frame.room, frame.clusters] = self.in_frame;
        frame.streaks = self.streak_layer.in_frame;
        for extent in &mut frame.extent[..3] {
            *extent = extent.max(self.placed.farthest);
        }
    }

    /// Records the reset of what is counted and linked, the placed drops' places, what is `seen` of real rain ([`Tiles::seen`]),
    /// and how far drops move until what a view shows so many seconds later. A barrier to compute must follow.
    pub fn record_reset(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        until: (&View, f64),
        seen: Option<&Seen>,
    ) {
        self.placed.record(device, commands, scene);
        let lattices = self.lattices();
        if let Some(shelter) = &self.shelter {
            shelter.record(device, commands, scene, lattices);
        }
        if let Some(records) = &self.records {
            records.record_motion(device, commands, scene, lattices, until);
        }
        if let (Some(cells), Some(seen)) = (self.source.cells(), seen) {
            cells.record(device, commands, seen);
        }
        for (buffer, value) in [(&self.counters, 0), (&self.lists.heads, END)] {
            fill_buffer(device, commands, buffer, 0..buffer.size, value);
        }
        if self.streak_layer.reset > 0 {
            fill_buffer(
                device,
                commands,
                &self.streak_layer.buffer,
                0..self.streak_layer.reset,
                END,
            );
        }
        // 0 x 1 x 1 workgroups each; all counts 0.
        let mut totals = [0u32; COUNTS_WORDS];
        for groups in totals[..GROUPS_WORDS].chunks_exact_mut(4) {
            groups.copy_from_slice(&[0, 1, 1, 0]);
        }
        update_buffer(device, commands, self.totals(), 0, bytemuck::bytes_of(&totals));
        let bins = 4 * COUNTS_WORDS as u64;
        fill_buffer(device, commands, self.totals(), bins..bins + 4 * MAX_BINS as u64, 0);
    }

    /// Whether a view of the same with the other's room has more.
    pub fn has_more_room_than(&self, other: &Self) -> bool {
        let room = |t: &Self| (t.in_frame, t.streak_layer.in_frame, t.long_lists);
        room(self) != room(other)
    }

    /// What of real rain a frame of `scene` shows; none without.
    pub fn seen(&self, scene: &Scene) -> Option<Seen> {
        self.source.cells().map(|cells| cells.seen(scene))
    }

    /// Records which clusters are in view, and their order. `seen`: what [`Tiles::seen`] said of the frame.
    pub fn record_clusters(&self, device: &Device, commands: Recorder<'_>, seen: Option<&Seen>) {
        let groups = match (&self.source, seen) {
            (Source::Cells(cells), Some(seen)) => rows_of(cells.0.groups(seen)),
            (Source::Clusters(sorted), _) => {
                let groups = sorted.counts[0].div_ceil(CLUSTERS_GROUP);
                [groups.next_multiple_of(STRETCHES), 1, 1]
            }
            (Source::Cells(..), None) => [0; 3],
        };
        let (bindings, totals) = (&self.bindings, self.totals());
        self.passes.clusters.dispatch(commands, bindings, 0, &[], groups);
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
        self.passes.bin_starts.dispatch(commands, bindings, 0, &[], [1, 1, 1]);
        let after = [Use::ComputeWrite, Use::ComputeRead, Use::Indirect];
        memory_barrier(device, commands, &[Use::ComputeWrite], &after);
        self.passes.sort_clusters.dispatch_indirect(commands, bindings, &[], totals, SORT_GROUPS);
    }

    /// Records the drops' places and the small ones' entry into the lists, after
    /// [`Tiles::record_clusters`] and a barrier.
    pub fn record_gather(&self, device: &Device, commands: Recorder<'_>) {
        for band in 0..self.bands() {
            if band > 0 {
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
            }
            let bins = [band, band + 1].map(|band| band * self.in_frame[0][3]);
            let (push, at) = (bytemuck::bytes_of(&bins), GATHER_GROUPS + 16 * u64::from(band));
            let (gather, totals) = (&self.passes.gather, self.totals());
            gather.dispatch_indirect(commands, &self.bindings, push, totals, at);
        }
    }

    /// Records the larger drops' entry into the lists, after [`Tiles::record_gather`] and a barrier.
    pub fn record_large(&self, device: &Device, commands: Recorder<'_>) {
        // `blocks` reads the large drops as texels.
        let written = [Use::ComputeWrite, Use::ComputeRead, Use::Indirect];
        let Passes { large, big, blocks, .. } = &self.passes;
        let passes = [(large, LARGE_GROUPS), (big, BIG_GROUPS), (blocks, BLOCK_GROUPS)];
        for (number, (pipeline, groups)) in passes.into_iter().enumerate() {
            if number > 0 {
                memory_barrier(device, commands, &[Use::ComputeWrite], &written);
            }
            pipeline.dispatch_indirect(commands, &self.bindings, &[], self.totals(), groups);
        }
    }
}
