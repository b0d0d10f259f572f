//! Real rain on the device: which cells are looked into, told anew for each frame (`src/rain/field.rs`).
//!
//! `cells` finds those in view and counts their drops; `sort_clusters` puts the drops' numbers in order of their
//! bins, in clusters of sixteen. From there on a drop is found by its number (`glsl/include/cells.glsl`), as drops in
//! a box are by theirs. No drop is stored but for one frame, and nothing is made that grows with the rain.

use std::mem::offset_of;
use std::sync::Arc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::Result;
use crate::abi::{self, CELLS_GROUP, CLUSTER, MAX_BANDS, RainField, RainTables};
use crate::gpu::{Buffer, Device, Memory, Recorder, update_buffer};
use crate::plan::FramePlan;
use crate::rain::cells::Lattice;
use crate::rain::field::{ClassRecord, Field, MOST_GROUPS, Seen};
use crate::rain::flat_sizes::Shares;
use crate::rain::flat_suns;
use crate::rain::grain::GrainRecord;
use crate::scene::Scene;

/// Room for more drops than the first frame's cells hold: the next frames' hold others.
const SPARE: f64 = 1.5;
const LEAST_ROOM: u32 = 1 << 16;

/// `RainField` of `glsl/include/rain_field.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Record {
    shown: [f32; 4],
    groups: [u32; 4],
    band_depths: [f32; MAX_BANDS as usize],
    medium: [f32; 4],
    grain: GrainRecord,
    classes: [ClassRecord; abi::MOST_CLASSES as usize],
}

const _: () = {
    assert!(offset_of!(Record, band_depths) == offset_of!(RainField, band_depths));
    assert!(offset_of!(Record, medium) == offset_of!(RainField, medium));
    assert!(offset_of!(Record, grain) == offset_of!(RainField, grain_base));
    assert!(offset_of!(Record, classes) == offset_of!(RainField, classes));
    assert!(size_of::<Record>() == size_of::<RainField>());
};
const FLAT_SUNS: usize = offset_of!(RainTables, flat_suns);
const FLAT_SHARES: usize = offset_of!(RainTables, flat_shares);
const LAWS: usize = offset_of!(RainTables, laws);
const SLABS: usize = offset_of!(RainTables, slabs);
const MEDIUM: usize = offset_of!(RainTables, medium);
const GROUP_SLABS: usize = size_of::<RainTables>();

// Where the shaders count words to.
const _: () = {
    let angles = abi::FLAT_SUN_ANGLES as usize;
    assert!(LAWS == 0 && SLABS == 4 * (abi::MOST_CLASSES * abi::LAW_WORDS) as usize);
    assert!(MEDIUM == SLABS + 32 * abi::MOST_SLABS as usize);
    assert!(FLAT_SUNS == MEDIUM + 16 * abi::MEDIUM_DEPTHS as usize);
    assert!(GROUP_SLABS == FLAT_SUNS + 16 * (angles.pow(3) + 2 * abi::FLAT_ELEVATIONS as usize));
};

/// The cells of a scene's rain.
pub struct Cells {
    /// Clusters that there is room for, and cells in view that hold drops.
    pub room: [u32; 2],
    /// Drops that the first frame shows by themselves, on average.
    pub drops: f64,
    /// `RainField` of `glsl/include/rain_field.glsl`, written anew for each frame.
    pub field: Buffer,
    /// `RainTables`, of which slabs and medium are written anew for each frame, too.
    pub tables: Buffer,
    rain: Field,
    cutoff_px: f64,
    placed: u32,
}

impl Cells {
    /// The cells of the real rain of `scene`; none if it has none.
    ///
    /// # Errors
    /// See [`Buffer::new`].
    pub fn new(device: &Arc<Device>, scene: &Scene, plan: &FramePlan) -> Result<Option<Self>> {
        use vk::BufferUsageFlags as Usage;
        let (Some(rain), Some(cutoff)) = (Field::of(scene), &plan.cutoff) else { return Ok(None) };
        let is_flattened = plan.shape.flattens_rain(scene);
        let rain = rain.flattened(is_flattened).grainy(cutoff.is_grainy);
        let rain = rain.thinned(scene, cutoff.thinned_px);
        let seen = rain.seen(scene, cutoff.px);
        let placed = scene.placed_count();
        let room_for = |expected: f64| {
            let usual = (SPARE * expected) as u32 + LEAST_ROOM;
            usual.saturating_mul(plan.room).saturating_add(placed)
        };
        let clusters = room_for(seen.drops_in_cells).div_ceil(CLUSTER);
        let mut bytes = vec![0u8; GROUP_SLABS + 4 * MOST_GROUPS];
        for (class, lattice) in rain.lattices().iter().enumerate() {
            let at = LAWS + 4 * abi::LAW_WORDS as usize * class;
            let words = law_words(lattice);
            bytes[at..at + 4 * words.len()].copy_from_slice(bytemuck::cast_slice(&words));
        }
        if is_flattened {
            let parted = rain.parted(scene, seen.cutoff_px.into());
            let suns = flat_suns::of_rain(&parted.shares_of_suns());
            let shares = flat_words(&parted.shares_of_light());
            for (at, values) in [(FLAT_SUNS, suns), (FLAT_SHARES, shares)] {
                let values = bytemuck::cast_slice(&values);
                bytes[at..at + values.len()].copy_from_slice(values);
            }
        }
        let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER | Usage::TRANSFER_DST;
        let tables = Buffer::upload_device(device, "rain tables", &bytes, usage)?;
        let (size, usage) =
            (size_of::<Record>() as u64, Usage::UNIFORM_BUFFER | Usage::TRANSFER_DST);
        let field = Buffer::new(device, "rain field", size, usage, Memory::Device)?;
        let room = [clusters, room_for(seen.cells_with_drops)];
        let drops = rain.drops_above(&scene.view(), f64::from(seen.cutoff_px));
        Ok(Some(Self { room, drops, field, tables, rain, cutoff_px: cutoff.px, placed }))
    }

    /// The lattices of the classes, in the order in which the shaders number them.
    pub fn lattices(&self) -> &[Lattice] {
        self.rain.lattices()
    }

    /// What `scene` shows of the rain.
    pub fn seen(&self, scene: &Scene) -> Seen {
        self.rain.seen(scene, self.cutoff_px)
    }

    /// Workgroups that look into the cells of a frame and at the placed drops.
    pub fn groups(&self, seen: &Seen) -> u32 {
        seen.groups() + self.placed.div_ceil(CELLS_GROUP)
    }

    /// Records what the frame sees; a barrier to compute must follow.
    pub fn record(&self, device: &Device, commands: Recorder<'_>, seen: &Seen) {
        let mut record = Record {
            shown: [seen.thinned_px, seen.radius_unit, seen.extent2, seen.millimetres],
            groups: [seen.groups(), self.placed, seen.own, 0],
            band_depths: seen.band_depths,
            medium: seen.medium.map_or([0.0; 4], |medium| medium.range),
            grain: seen.grain.map_or_else(GrainRecord::zeroed, |grain| grain.record),
            ..Record::zeroed()
        };
        record.classes[..seen.classes.len()].copy_from_slice(&seen.classes);
        let (group_slabs, medium) = (seen.group_slabs(), medium_words(seen));
        update_buffer(device, commands, &self.field, 0, bytemuck::bytes_of(&record));
        let parts: [(usize, &[u8]); 3] = [
            (MEDIUM, bytemuck::cast_slice(&medium)),
            (SLABS, bytemuck::cast_slice(&seen.slabs)),
            (GROUP_SLABS, bytemuck::cast_slice(&group_slabs)),
        ];
        for (first, bytes) in parts {
            update_buffer(device, commands, &self.tables, first as u64, bytes);
        }
    }
}

/// The medium's depth by depth, and its grain's variance; nothing where there is none.
fn medium_words(seen: &Seen) -> Vec<[f32; 4]> {
    let Some(medium) = &seen.medium else { return Vec::new() };
    let variances = seen.grain.map_or([0.0; abi::MEDIUM_DEPTHS as usize], |grain| grain.variances);
    let depths = medium.optical_depths.iter().zip(medium.from_below).zip(variances);
    depths.map(|((level, from_below), variance)| [*level, from_below, variance, 0.0]).collect()
}

/// By elevation: the shares of flattened drops in the medium, then in drops that are shown one by one.
fn flat_words(shares: &[Shares; 2]) -> Vec<[f32; 4]> {
    let [far, near] = shares;
    let pairs = far.iter().zip(near).flat_map(|(far, near)| [far, near]);
    pairs.map(|[_, flat @ ..]| flat.map(|share| share as f32)).collect()
}

/// A class's law: quantiles, then thresholds.
fn law_words(lattice: &Lattice) -> Vec<u32> {
    let words: Vec<u32> = lattice.quantiles.iter().chain(&lattice.thresholds).copied().collect();
    assert!(words.len() <= abi::LAW_WORDS as usize, "a cell of {} drops on average", lattice.mean);
    words
}
