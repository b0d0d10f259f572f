//! One frame: clusters in view, drops in view, tiles, sky, tone map.

use std::time::Instant;

use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::picture::tone_map::DELTA;
use raindrops::rain::clusters::{CLUSTER, ClusterBox, Clusters, NO_DROP};
use raindrops::rain::cull::Sight;
use raindrops::rain::{start, tick_of_seconds};
use raindrops::scene::Scene;
use rayon::prelude::*;

use crate::kernel::kernel;
use crate::light::{Pictures, Sky};
use crate::tile::{Outline, Scratch, composite, luminance};

/// Edge of a tile in pixels.
pub const TILE: usize = 32;
/// Drops that are culled at a time.
pub const LANES: usize = 8;
/// Where a frame's time went, and how many drops were in view.
pub struct Stages {
    pub visible: u64,
    pub bin_ms: f64,
    pub composite_ms: f64,
    pub tone_map_ms: f64,
}

/// A drop in view: its centre in view space, its index.
#[derive(Clone, Copy, Default)]
pub struct Seen {
    pub x: f32,
    pub y: f32,
    pub z: f32,
    pub index: u32,
}

/// The drops cluster by cluster: starting places, indices.
struct Drops {
    start: [Vec<u32>; 3],
    clusters: Clusters,
}

/// What the frame's loops read.
#[derive(Clone, Copy)]
pub struct Constants {
    pub sight: Sight,
    /// What a starting place becomes relative to the camera by.
    shift: [u32; 3],
    units: Vec3,
    pub radius: f32,
    pub focal: f32,
    pub width: usize,
    pub height: usize,
}

/// A part of the clusters in view, its drops, and those by tile.
#[derive(Default)]
pub struct Part {
    seen: Vec<Seen>,
    tiles: Vec<[u16; 4]>,
    pub first: Vec<u32>,
    pub by_tile: Vec<Seen>,
}

/// The renderer.
pub struct Frame {
    drops: Drops,
    sky: Sky,
    pictures: Pictures,
    delta: f32,
    width: usize,
    height: usize,
    parts: Vec<Part>,
    /// A tile after the other, each red, green, blue.
    radiance: Vec<f32>,
    display: Vec<u32>,
    srgb: Vec<u8>,
}

impl Frame {
    /// A frame of a scene that has rain alone and whose image is whole tiles.
    pub fn new(scene: &Scene, environment: &Environment) -> Self {
        let clusters = Clusters::new(&scene.populations(), &[]);
        let start = |axis: usize| {
            clusters.order.par_iter().map(|index| start(scene.seed, *index)[axis]).collect()
        };
        let sky = Sky::new(environment);
        let (width, height) = (scene.image.width as usize, scene.image.height as usize);
        assert!(width % TILE == 0 && height % TILE == 0, "the image is not whole tiles");
        Self {
            drops: Drops { start: [start(0), start(1), start(2)], clusters },
            pictures: Pictures::new(&sky),
            sky,
            delta: (DELTA * environment.mean_luminance()) as f32,
            width,
            height,
            parts: (0..4 * rayon::current_num_threads()).map(|_| Part::default()).collect(),
            radiance: vec![0.0; 3 * width * height],
            display: vec![0; width * height],
            srgb: srgb_table(),
        }
    }

    /// Draws the scene at its time, into `display`.
    pub fn draw(&mut self, scene: &Scene) -> Stages {
        let begin = Instant::now();
        let Some(rain) = scene.rain() else { unreachable!("the yardstick is for rain") };
        let view = scene.view();
        let (shift, camera) =
            (rain.shift(tick_of_seconds(scene.time)), rain.camera_place(scene.camera.position));
        let constants = Constants {
            sight: Sight::new(&view, scene.camera.near),
            shift: [0, 1, 2].map(|axis: usize| shift[axis].wrapping_sub(camera[axis])),
            units: rain.units(),
            radius: rain.radius as f32,
            focal: view.focal_px as f32,
            width: self.width,
            height: self.height,
        };
        let drops = &self.drops;
        let clusters = clusters_in_view(drops, &constants);
        let share = clusters.len().div_ceil(self.parts.len()).max(1);
        let ranges: Vec<&[usize]> = clusters.chunks(share).collect();
        self.parts.par_iter_mut().enumerate().for_each(|(number, part)| {
            part.seen.clear();
            for cluster in ranges.get(number).copied().unwrap_or_default() {
                cull(drops, cluster * CLUSTER as usize, &constants, &mut part.seen);
            }
            bin(part, &constants);
        });
        let binned = Instant::now();

        let (parts, sky, pictures, delta) = (&self.parts, &self.sky, &self.pictures, self.delta);
        let tiles = self.radiance.par_chunks_exact_mut(3 * TILE * TILE).enumerate();
        let logs: f64 = tiles
            .map_init(Scratch::default, |scratch, (tile, out)| {
                f64::from(composite(tile, parts, &constants, sky, pictures, delta, scratch, out))
            })
            .sum();
        let composited = Instant::now();

        let average = (logs / (self.width * self.height) as f64).exp();
        let exposure = (scene.tone_map.key / average) as f32;
        let (width, srgb) = (self.width, &self.srgb);
        let bands = self.display.par_chunks_exact_mut(TILE * width);
        bands.zip(self.radiance.par_chunks_exact(3 * TILE * width)).for_each(|(out, radiance)| {
            tone_map(radiance, exposure, srgb, width, out);
        });
        let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        Stages {
            visible: self.parts.iter().map(|part| part.seen.len() as u64).sum(),
            bin_ms: ms(begin, binned),
            composite_ms: ms(binned, composited),
            tone_map_ms: ms(composited, Instant::now()),
        }
    }

    /// The last picture, three bytes a pixel.
    pub fn srgb(&self) -> Vec<u8> {
        self.display.iter().flat_map(|pixel| pixel.to_le_bytes()[..3].to_vec()).collect()
    }
}

/// Clusters that may hold a drop in view.
fn clusters_in_view(drops: &Drops, constants: &Constants) -> Vec<usize> {
    let boxes = drops.clusters.boxes.par_iter().enumerate();
    boxes.filter(|(_, around)| in_view(**around, constants)).map(|(number, _)| number).collect()
}

/// Whether a box reaches into the view; of one over the rain box's far side all along that axis.
fn in_view([x, y, z, edges]: ClusterBox, constants: &Constants) -> bool {
    let Constants { sight, shift, units, radius, .. } = constants;
    let (mut middle, mut half) = (Vec3::ZERO, Vec3::splat(2_147_483_648.0));
    for (axis, low) in [x, y, z].into_iter().enumerate() {
        let low = low.wrapping_add(shift[axis]) as i32;
        let edge = ((edges >> (10 * axis) & 1023) + 1) as f32 * 4_194_304.0;
        if low as f32 + edge <= 2_147_483_648.0 {
            (middle[axis], half[axis]) = (low as f32 + 0.5 * edge, 0.5 * edge);
        }
    }
    let reach = (half * *units).length() + radius;
    let v = sight.view_space(middle * *units);
    let depth = -v.z;
    depth >= -reach
        && v.x.abs() * sight.frustum_x[0] - depth * sight.frustum_x[1] <= reach
        && v.y.abs() * sight.frustum_y[0] - depth * sight.frustum_y[1] <= reach
}

kernel! {
/// The drops in view of the cluster that begins at `from`, as `Sight::visibility` finds them.
fn cull(drops: &Drops, from: usize, constants: &Constants, seen: &mut Vec<Seen>) -> () {
    let Constants { sight, shift, units, radius, .. } = *constants;
    let [right, up, back] = sight.axes;
    let to = from + CLUSTER as usize;
    let [xs, ys, zs] = [0, 1, 2].map(|axis: usize| &drops.start[axis][from..to]);
    let order = &drops.clusters.order[from..to];
    for block in (0..order.len()).step_by(LANES) {
        let mut some = [Seen::default(); LANES];
        let mut visible = [false; LANES];
        let count = LANES.min(order.len() - block);
        let mut places = [[0u32; LANES]; 3];
        for (to, from) in places.iter_mut().zip([xs, ys, zs]) {
            to[..count].copy_from_slice(&from[block..block + count]);
        }
        for lane in 0..LANES {
            let along = |axis: usize, unit: f32| {
                places[axis][lane].wrapping_add(shift[axis]) as i32 as f32 * unit
            };
            let (px, py, pz) = (along(0, units.x), along(1, units.y), along(2, units.z));
            let x = (right.x * px + right.y * py) + right.z * pz;
            let y = (up.x * px + up.y * py) + up.z * pz;
            let z = (back.x * px + back.y * py) + back.z * pz;
            let depth = -z;
            let distance2 = (x * x + y * y) + z * z;
            let beyond_x = x.abs() * sight.frustum_x[0] - depth * sight.frustum_x[1];
            let beyond_y = y.abs() * sight.frustum_y[0] - depth * sight.frustum_y[1];
            visible[lane] = (beyond_x <= radius) & (beyond_y <= radius) & (depth > radius)
                & (distance2 > radius * radius) & (distance2 >= sight.near * sight.near);
            some[lane] = Seen { x, y, z, index: 0 };
        }
        let mut kept = 0;
        for lane in 0..count {
            let mut drop = some[lane];
            drop.index = order[block + lane];
            some[kept] = drop;
            kept += usize::from(visible[lane] && drop.index != NO_DROP);
        }
        seen.extend_from_slice(&some[..kept]);
    }
}
}

kernel! {
/// Sorts a part's drops by the tiles that they touch.
fn bin(part: &mut Part, c: &Constants) -> () {
    let (columns, rows) = ((c.width / TILE) as f32, (c.height / TILE) as f32);
    part.tiles.resize(part.seen.len(), [0; 4]);
    // A range that ends before it begins is off the image.
    let edge = 1.0 / TILE as f32;
    let first = |at: f32, count: f32| (at * edge).floor().clamp(0.0, count) as i32 as u16;
    let last = |at: f32, count: f32| ((at * edge).floor() + 1.0).clamp(0.0, count) as i32 as u16;
    for (range, drop) in part.tiles.iter_mut().zip(&part.seen) {
        let [left, right, top, bottom] = Outline::new(drop, c).pixels();
        *range = [first(left, columns), last(right, columns), first(top, rows), last(bottom, rows)];
    }
    let columns = columns as usize;
    part.first.clear();
    part.first.resize(columns * rows as usize + 1, 0);
    for [left, right, top, bottom] in &part.tiles {
        for row in *top..*bottom {
            for column in *left..*right {
                part.first[usize::from(row) * columns + usize::from(column) + 1] += 1;
            }
        }
    }
    for tile in 1..part.first.len() {
        part.first[tile] += part.first[tile - 1];
    }
    let total = part.first[part.first.len() - 1] as usize;
    part.by_tile.resize(total, Seen::default());
    let mut next: Vec<u32> = part.first[..part.first.len() - 1].to_vec();
    for (drop, [left, right, top, bottom]) in part.seen.iter().zip(&part.tiles) {
        for row in *top..*bottom {
            for column in *left..*right {
                let next = &mut next[usize::from(row) * columns + usize::from(column)];
                part.by_tile[*next as usize] = *drop;
                *next += 1;
            }
        }
    }
}
}

kernel! {
/// A row of tiles to display colour.
fn tone_map(radiance: &[f32], exposure: f32, srgb: &[u8], width: usize, out: &mut [u32]) -> () {
    for (column, tile) in radiance.chunks_exact(3 * TILE * TILE).enumerate() {
        let (red, rest) = tile.split_at(TILE * TILE);
        let (green, blue) = rest.split_at(TILE * TILE);
        for row in 0..TILE {
            let mut codes = [[0u32; TILE]; 3];
            for x in 0..TILE {
                let at = row * TILE + x;
                let (r, g, b) = (red[at], green[at], blue[at]);
                let scale = exposure / (1.0 + exposure * luminance(r, g, b));
                for (code, channel) in codes.iter_mut().zip([r, g, b]) {
                    code[x] = srgb_code(channel * scale);
                }
            }
            let to = &mut out[row * width + column * TILE..][..TILE];
            for (x, pixel) in to.iter_mut().enumerate() {
                let byte = |channel: usize| u32::from(srgb[codes[channel][x] as usize]);
                *pixel = byte(0) | byte(1) << 8 | byte(2) << 16 | 0xff00_0000;
            }
        }
    }
}
}

/// Least value that has a code of its own: well under half a step of sRGB's 8 bits.
const SRGB_LEAST: f32 = 1.0 / 8192.0;

/// A linear value as the number of its entry in the table: exponent and seven bits of mantissa.
#[inline(always)]
fn srgb_code(value: f32) -> u32 {
    (value.clamp(SRGB_LEAST, 0.999_999_9).to_bits() - SRGB_LEAST.to_bits()) >> 16
}

/// sRGB bytes of the codes, each at the middle of its range.
fn srgb_table() -> Vec<u8> {
    (0..=srgb_code(1.0))
        .map(|code| f32::from_bits((code << 16) + 0x8000 + SRGB_LEAST.to_bits()))
        .map(raindrops::picture::srgb_byte)
        .collect()
}
