//! One frame: cells in view, drops in view, tiles, sky, tone map.

use std::f32::consts::PI;
use std::time::Instant;

use glam::{Vec3, Vec4};
use raindrops::cells::Cells;
use raindrops::cull::Sight;
use raindrops::environment::Environment;
use raindrops::rain::{start, tick_of_seconds};
use raindrops::scene::Scene;
use raindrops::tone_map::DELTA;
use rayon::prelude::*;

use crate::light::{EDGE, Pictures, Sky, drop_light, place};

/// Edge of a tile in pixels.
const TILE: usize = 32;
/// Drops that are culled at a time.
const LANES: usize = 8;
/// Transmittance under which a pixel is full.
const FULL: f32 = 1.0 / 4096.0;
/// Area in pixels under which a drop is one pixel's.
const ONE_PIXEL: f32 = 1.0;
/// Radius in pixels up to which a drop shows its mean colour, and its prefiltered picture.
const MEAN_PX: f32 = 1.0;
const PICTURE_PX: f32 = 4.0;

/// Declares a function whose body is compiled a second time for AVX2, taken where the CPU has it.
macro_rules! kernel {
    ($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments, reason = "a kernel takes what its loop reads")]
        fn $name($($argument: $type),*) -> $result {
            #[inline(always)]
            #[allow(clippy::too_many_arguments, reason = "as above")]
            fn generic($($argument: $type),*) -> $result $body
            #[cfg(target_arch = "x86_64")]
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                #[target_feature(enable = "avx2,fma")]
                #[allow(clippy::too_many_arguments, reason = "as above")]
                fn avx2($($argument: $type),*) -> $result {
                    generic($($argument),*)
                }
                // SAFETY: the CPU has what the function is compiled for.
                return unsafe { avx2($($argument),*) };
            }
            generic($($argument),*)
        }
    };
}

/// Where a frame's time went, and how many drops were in view.
pub struct Stages {
    pub visible: u64,
    pub bin_ms: f64,
    pub composite_ms: f64,
    pub tone_map_ms: f64,
}

/// A drop in view: its centre in view space, its index.
#[derive(Clone, Copy, Default)]
struct Seen {
    x: f32,
    y: f32,
    z: f32,
    index: u32,
}

/// The drops in the order of their cells: starting places, indices.
struct Drops {
    start: [Vec<u32>; 3],
    cells: Cells,
}

/// What the frame's loops read.
#[derive(Clone, Copy)]
struct Constants {
    sight: Sight,
    /// What a starting place becomes relative to the camera by.
    shift: [u32; 3],
    units: Vec3,
    radius: f32,
    focal: f32,
    width: usize,
    height: usize,
}

/// A part of the cells in view, its drops, and those by tile.
#[derive(Default)]
struct Part {
    seen: Vec<Seen>,
    tiles: Vec<[u16; 4]>,
    first: Vec<u32>,
    by_tile: Vec<Seen>,
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
    /// Of a scene of rain alone, whose image is whole tiles.
    pub fn new(scene: &Scene, environment: &Environment) -> Self {
        let rain = scene.rain();
        let cells = Cells::new(rain.as_ref(), 0);
        let start = |axis: usize| {
            cells.order.par_iter().map(|index| start(scene.seed, *index)[axis]).collect()
        };
        let sky = Sky::new(environment);
        let (width, height) = (scene.image.width as usize, scene.image.height as usize);
        assert!(width % TILE == 0 && height % TILE == 0, "the image is not whole tiles");
        Self {
            drops: Drops { start: [start(0), start(1), start(2)], cells },
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
        let cells = cells_in_view(drops, &constants);
        let share = cells.len().div_ceil(self.parts.len()).max(1);
        let ranges: Vec<&[u32]> = cells.chunks(share).collect();
        self.parts.par_iter_mut().enumerate().for_each(|(number, part)| {
            part.seen.clear();
            for cell in ranges.get(number).copied().unwrap_or_default() {
                let first = &drops.cells.first;
                let (from, to) = (first[*cell as usize], first[*cell as usize + 1]);
                cull(drops, from as usize, to as usize, &constants, &mut part.seen);
            }
            bin(part, &constants);
        });
        let binned = Instant::now();

        let (parts, sky, pictures, delta) = (&self.parts, &self.sky, &self.pictures, self.delta);
        let tiles = self.radiance.par_chunks_exact_mut(3 * TILE * TILE).enumerate();
        let logs: f64 = tiles
            .map_init(Vec::new, |order, (tile, out)| {
                f64::from(composite(tile, parts, &constants, sky, pictures, delta, order, out))
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

/// Cells that may hold a drop in view.
fn cells_in_view(drops: &Drops, constants: &Constants) -> Vec<u32> {
    let Constants { sight, units, radius, .. } = constants;
    let bits = drops.cells.bits;
    let edge = (1u32 << (32 - bits)) as f32;
    let half = 0.5 * edge * *units;
    let reach = half.length() + radius;
    let middle = |coordinate: u32, axis: usize| {
        let place = (coordinate << (32 - bits)).wrapping_add(1 << (31 - bits));
        place.wrapping_add(constants.shift[axis]) as i32
    };
    // A cell that reaches over the box's end is on both sides of it.
    let sides = |middle: i32| {
        let other = if middle < 0 {
            middle as f32 + 4_294_967_296.0
        } else {
            middle as f32 - 4_294_967_296.0
        };
        let both = (middle as f32).abs() + edge > 2_147_483_648.0;
        (middle as f32, both.then_some(other))
    };
    let side = 1u32 << bits;
    let seen = |x: f32, y: f32, z: f32| {
        let v = sight.view_space(Vec3::new(x * units.x, y * units.y, z * units.z));
        let depth = -v.z;
        depth >= -reach
            && v.x.abs() * sight.frustum[0] - depth * sight.frustum[1] <= reach
            && v.y.abs() * sight.frustum[2] - depth * sight.frustum[3] <= reach
    };
    let planes = (0..side).into_par_iter().flat_map_iter(|z| {
        let z_sides = sides(middle(z, 2));
        (0..side).flat_map(move |y| {
            let y_sides = sides(middle(y, 1));
            (0..side).filter_map(move |x| {
                let x_sides = sides(middle(x, 0));
                let any = |(near, far): (f32, Option<f32>)| std::iter::once(near).chain(far);
                let in_view =
                    any(x_sides).any(|x| any(y_sides).any(|y| any(z_sides).any(|z| seen(x, y, z))));
                in_view.then_some(x | y << bits | z << (2 * bits))
            })
        })
    });
    planes.collect()
}

kernel! {
/// The drops in view among those from `from` to `to`: the twin of `Sight::sighting`.
fn cull(drops: &Drops, from: usize, to: usize, constants: &Constants, seen: &mut Vec<Seen>) -> () {
    let Constants { sight, shift, units, radius, .. } = *constants;
    let [right, up, back] = sight.axes;
    let [xs, ys, zs] = [0, 1, 2].map(|axis: usize| &drops.start[axis][from..to]);
    let order = &drops.cells.order[from..to];
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
            let beyond_x = x.abs() * sight.frustum[0] - depth * sight.frustum[1];
            let beyond_y = y.abs() * sight.frustum[2] - depth * sight.frustum[3];
            visible[lane] = (beyond_x <= radius) & (beyond_y <= radius) & (depth > radius)
                & (distance2 > radius * radius) & (distance2 >= sight.near * sight.near);
            some[lane] = Seen { x, y, z, index: 0 };
        }
        let mut kept = 0;
        for lane in 0..count {
            let mut drop = some[lane];
            drop.index = order[block + lane];
            some[kept] = drop;
            kept += usize::from(visible[lane]);
        }
        seen.extend_from_slice(&some[..kept]);
    }
}
}

/// A drop's outline on the screen, in pixels.
struct Outline {
    x: f32,
    y: f32,
    half_x: f32,
    half_y: f32,
    area: f32,
}

impl Outline {
    #[inline(always)]
    fn new(drop: &Seen, c: &Constants) -> Self {
        let (z, r2) = (-drop.z, c.radius * c.radius);
        let (x2, y2, z2) = (drop.x * drop.x, drop.y * drop.y, z * z);
        let flat = 1.0 / (z2 - r2);
        let scale = z * flat * c.focal;
        let size = c.focal * c.radius * flat;
        Self {
            x: 0.5 * c.width as f32 + drop.x * scale,
            y: 0.5 * c.height as f32 - drop.y * scale,
            half_x: size * (x2 + z2 - r2).sqrt(),
            half_y: size * (y2 + z2 - r2).sqrt(),
            area: PI * size * size * ((x2 + y2 + z2 - r2) * (z2 - r2)).sqrt(),
        }
    }

    /// First and last pixel in each direction, before the image's edges: x, y.
    #[inline(always)]
    fn pixels(&self) -> [f32; 4] {
        let (reach_x, reach_y) =
            if self.area < ONE_PIXEL { (0.0, 0.0) } else { (self.half_x + 0.5, self.half_y + 0.5) };
        [self.x - reach_x, self.x + reach_x, self.y - reach_y, self.y + reach_y]
    }
}

kernel! {
/// Sorts a part's drops by the tiles that they touch.
fn bin(part: &mut Part, c: &Constants) -> () {
    let (columns, rows) = ((c.width / TILE) as f32, (c.height / TILE) as f32);
    part.tiles.clear();
    part.tiles.extend(part.seen.iter().map(|drop| {
        let [left, right, top, bottom] = Outline::new(drop, c).pixels();
        // A range that ends before it begins is off the image.
        let first = |at: f32, count: f32| (at * (1.0 / TILE as f32)).floor().clamp(0.0, count) as u16;
        let last = |at: f32, count: f32| ((at * (1.0 / TILE as f32)).floor() + 1.0).clamp(0.0, count) as u16;
        [first(left, columns), last(right, columns), first(top, rows), last(bottom, rows)]
    }));
    let columns = columns as usize;
    part.first.clear();
    part.first.resize(columns * rows as usize + 1, 0);
    let each = |[left, right, top, bottom]: [u16; 4], visit: &mut dyn FnMut(usize)| {
        for row in top..bottom {
            for column in left..right {
                visit(usize::from(row) * columns + usize::from(column));
            }
        }
    };
    for range in &part.tiles {
        each(*range, &mut |tile| part.first[tile + 1] += 1);
    }
    for tile in 1..part.first.len() {
        part.first[tile] += part.first[tile - 1];
    }
    let total = part.first[part.first.len() - 1] as usize;
    part.by_tile.resize(total, Seen::default());
    // Filled from the end of each tile's room, so that `first` ends where it should.
    let mut next: Vec<u32> = part.first[..part.first.len() - 1].to_vec();
    for (drop, range) in part.seen.iter().zip(&part.tiles) {
        each(*range, &mut |tile| {
            part.by_tile[next[tile] as usize] = *drop;
            next[tile] += 1;
        });
    }
}
}

/// A tile's drops in order: (distance², index) as one number, drop.
type InOrder = Vec<(u64, Seen)>;

kernel! {
/// A tile's drops front to back, the sky behind; the sum of its log luminances.
fn composite(tile: usize, parts: &[Part], c: &Constants, sky: &Sky, pictures: &Pictures,
             delta: f32, order: &mut InOrder, out: &mut [f32]) -> f32 {
    let columns = c.width / TILE;
    let corner = [tile % columns * TILE, tile / columns * TILE];
    order.clear();
    for part in parts {
        let drops = &part.by_tile[part.first[tile] as usize..part.first[tile + 1] as usize];
        order.extend(drops.iter().map(|drop| {
            // Positive floats are in the order of their bits.
            let distance2 = (drop.x * drop.x + drop.y * drop.y) + drop.z * drop.z;
            (u64::from(distance2.to_bits()) << 32 | u64::from(drop.index), *drop)
        }));
    }
    order.sort_unstable_by_key(|(key, _)| *key);

    // Light so far, and in w what the pixel lets through.
    let mut pixels = [Vec4::W; TILE * TILE];
    let origin = Vec3::new(corner[0] as f32, corner[1] as f32, 0.0);
    for (_, drop) in order.iter() {
        splat(drop, origin, c, sky, pictures, &mut pixels);
    }

    let (red, rest) = out.split_at_mut(TILE * TILE);
    let (green, blue) = rest.split_at_mut(TILE * TILE);
    let [right, up, back] = c.sight.axes;
    for row in 0..TILE {
        let (mut us, mut vs) = ([0.0f32; TILE], [0.0f32; TILE]);
        let y = 0.5 * c.height as f32 - (origin.y + row as f32 + 0.5);
        let along = y * up - c.focal * back;
        for column in 0..TILE {
            let x = origin.x + column as f32 + 0.5 - 0.5 * c.width as f32;
            [us[column], vs[column]] = place(x * right + along);
        }
        for column in 0..TILE {
            let at = row * TILE + column;
            let pixel = pixels[at] + sky.finest(us[column], vs[column]) * pixels[at].w;
            (red[at], green[at], blue[at]) = (pixel.x, pixel.y, pixel.z);
        }
    }
    let mut sums = [0.0f32; LANES];
    for block in (0..TILE * TILE).step_by(LANES) {
        for lane in 0..LANES {
            let at = block + lane;
            sums[lane] += log2(delta + luminance(red[at], green[at], blue[at]));
        }
    }
    sums.iter().sum::<f32>() * std::f32::consts::LN_2
}
}

/// Puts a drop behind what is in a tile already.
#[inline(always)]
fn splat(
    drop: &Seen,
    origin: Vec3,
    c: &Constants,
    sky: &Sky,
    pictures: &Pictures,
    pixels: &mut [Vec4; TILE * TILE],
) {
    let outline = Outline::new(drop, c);
    let range = outline.pixels();
    let clip = |at: f32| at.floor().clamp(0.0, TILE as f32 - 1.0) as usize;
    let (left, right) = (clip(range[0] - origin.x), clip(range[1] - origin.x));
    let (top, bottom) = (clip(range[2] - origin.y), clip(range[3] - origin.y));
    let [axis_x, axis_y, axis_z] = c.sight.axes;
    let center = drop.x * axis_x + drop.y * axis_y + drop.z * axis_z;
    // What covers a pixel hides by that share of what it still lets through.
    let behind = |pixel: &mut Vec4, color: Vec4, coverage: f32| {
        *pixel += (color - Vec4::W) * (coverage * pixel.w);
    };
    if outline.area < ONE_PIXEL {
        let pixel = &mut pixels[top * TILE + left];
        if pixel.w > FULL {
            behind(pixel, pictures.mean(center), outline.area);
        }
        return;
    }
    let radius_px = (outline.area / PI).sqrt();
    let d = center.normalize();
    let (picture, [u, v]) = pictures.picture(d);
    let mean = if radius_px < MEAN_PX { pictures.mean(d) } else { Vec4::ZERO };
    // From pixels to the disc's (s, t): a plane through the centre.
    let scale = -drop.z / (c.focal * c.radius);
    let across = [axis_x.dot(u) * scale, axis_x.dot(v) * scale];
    let down = [-axis_y.dot(u) * scale, -axis_y.dot(v) * scale];
    for row in top..=bottom {
        for column in left..=right {
            let pixel = &mut pixels[row * TILE + column];
            if pixel.w <= FULL {
                continue;
            }
            let (x, y) = (origin.x + column as f32 + 0.5, origin.y + row as f32 + 0.5);
            let (dx, dy) = (x - outline.x, y - outline.y);
            if radius_px < PICTURE_PX {
                let (s, t) = (dx * across[0] + dy * down[0], dx * across[1] + dy * down[1]);
                let coverage = ((1.0 - (s * s + t * t).sqrt()) * radius_px + 0.5).min(1.0);
                if coverage > 0.0 {
                    let color = if radius_px < MEAN_PX { mean } else { look_up(picture, s, t) };
                    behind(pixel, color, coverage);
                }
            } else {
                let (x, y) = (x - 0.5 * c.width as f32, 0.5 * c.height as f32 - y);
                let ray = (x * axis_x + y * axis_y - c.focal * axis_z).normalize();
                let offset = (center.dot(ray) * ray - center) / c.radius;
                let b = offset.length();
                let coverage = ((1.0 - b) * radius_px + 0.5).min(1.0);
                if coverage > 0.0 {
                    let offset = if b > 1.0 { offset / b } else { offset };
                    behind(pixel, drop_light(sky, ray, offset, 1.0 / radius_px), coverage);
                }
            }
        }
    }
}

/// Bilinear between the texels of a far drop's picture.
#[inline(always)]
fn look_up(picture: &[Vec4; EDGE * EDGE], s: f32, t: f32) -> Vec4 {
    let at = |p: f32| ((0.5 * p + 0.5) * EDGE as f32 - 0.5).clamp(0.0, EDGE as f32 - 1.001);
    let (x, y) = (at(s), at(t));
    let (left, top) = (x as usize, y as usize);
    let (fx, fy) = (x - left as f32, y - top as f32);
    let first = (top * EDGE + left).min(EDGE * EDGE - EDGE - 2);
    let (a, b, c, d) =
        (picture[first], picture[first + 1], picture[first + EDGE], picture[first + EDGE + 1]);
    let (upper, lower) = (a + (b - a) * fx, c + (d - c) * fx);
    upper + (lower - upper) * fy
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

#[inline(always)]
fn luminance(red: f32, green: f32, blue: f32) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Within 2·10⁻⁵, for positive numbers; free of branches, so that a loop of it vectorises.
#[inline(always)]
fn log2(value: f32) -> f32 {
    let bits = value.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
    // ln m = 2 artanh((m-1) / (m+1)).
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let artanh = s * (1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 / 7.0)));
    exponent as f32 + 2.0 * std::f32::consts::LOG2_E * artanh
}
