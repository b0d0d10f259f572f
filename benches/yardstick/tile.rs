//! One tile: its drops over one another front to back, and the sky behind.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};

use crate::frame::{Constants, LANES, Part, Seen, TILE};
use crate::kernel::kernel;
use crate::light::{EDGE, ORDERS, Pictures, Sky, drop_rays, log2, mix, place};

/// Transmittance under which a pixel is full.
const FULL: f32 = 1.0 / 4096.0;
/// Area in pixels under which a drop is one pixel's.
const ONE_PIXEL: f32 = 1.0;
/// Radius in pixels up to which a drop shows its mean colour, and its prefiltered picture.
const MEAN_PX: f32 = 1.0;
const PICTURE_PX: f32 = 4.0;
/// Floats a row of a tile: eight pixels from any column on are in it.
const PITCH: usize = TILE + LANES;
/// Floats of a plane.
const PLANE: usize = PITCH * TILE;

/// A drop's outline on the screen, in pixels.
pub struct Outline {
    x: f32,
    y: f32,
    half_x: f32,
    half_y: f32,
    area: f32,
}

impl Outline {
    #[inline(always)]
    pub fn new(drop: &Seen, c: &Constants) -> Self {
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
    pub fn pixels(&self) -> [f32; 4] {
        let (reach_x, reach_y) =
            if self.area < ONE_PIXEL { (0.0, 0.0) } else { (self.half_x + 0.5, self.half_y + 0.5) };
        [self.x - reach_x, self.x + reach_x, self.y - reach_y, self.y + reach_y]
    }
}

/// What a tile is worked out in.
#[derive(Default)]
pub struct Scratch {
    /// The tile's drops: (distance², index) as one number, drop.
    order: Vec<(u64, Seen)>,
}

/// Red, green and blue so far, and what a pixel lets through.
type Planes = [[f32; PLANE]; 4];

kernel! {
/// A tile's drops front to back, the sky behind; the sum of its log luminances.
pub fn composite(tile: usize, parts: &[Part], c: &Constants, sky: &Sky, pictures: &Pictures,
                 delta: f32, scratch: &mut Scratch, out: &mut [f32]) -> f32 {
    let columns = c.width / TILE;
    let (left, top) = ((tile % columns * TILE) as f32, (tile / columns * TILE) as f32);
    let order = &mut scratch.order;
    order.clear();
    for part in parts {
        let drops = &part.by_tile[part.first[tile] as usize..part.first[tile + 1] as usize];
        for drop in drops {
            // Positive floats are in the order of their bits.
            let distance2 = (drop.x * drop.x + drop.y * drop.y) + drop.z * drop.z;
            order.push((u64::from(distance2.to_bits()) << 32 | u64::from(drop.index), *drop));
        }
    }
    order.sort_unstable_by_key(|(key, _)| *key);

    let mut planes = [[0.0; PLANE], [0.0; PLANE], [0.0; PLANE], [1.0; PLANE]];
    for (_, drop) in order.iter() {
        splat(drop, left, top, c, sky, pictures, &mut planes);
    }

    let (red, rest) = out.split_at_mut(TILE * TILE);
    let (green, blue) = rest.split_at_mut(TILE * TILE);
    let [right, up, back] = c.sight.axes;
    let (size, stride, texels) = sky.finest();
    let mut sums = [0.0f32; LANES];
    for row in 0..TILE {
        let (mut at, mut fx, mut fy) = ([0i32; TILE], [0.0f32; TILE], [0.0f32; TILE]);
        let along = (0.5 * c.height as f32 - (top + row as f32 + 0.5)) * up - c.focal * back;
        for column in 0..TILE {
            let x = left + column as f32 + 0.5 - 0.5 * c.width as f32;
            let [u, v] = place(x * right + along);
            let (u, v) = (u * size.x + 0.5, v * size.y + 0.5);
            let (left, top) = (u as i32, v as i32);
            at[column] = top * stride as i32 + left;
            (fx[column], fy[column]) = (u - left as f32, v - top as f32);
        }
        let mut behind = [[0.0f32; TILE]; 3];
        for column in 0..TILE {
            let color = mix(texels, at[column] as usize, stride, fx[column], fy[column]);
            (behind[0][column], behind[1][column], behind[2][column]) = (color.x, color.y, color.z);
        }
        // From slices whose length is known to arrays, so that no index is checked within the loops.
        let transmittance = &planes[3][row * PITCH..][..TILE];
        for (channel, color) in behind.iter_mut().enumerate() {
            let front = &planes[channel][row * PITCH..][..TILE];
            for column in 0..TILE {
                color[column] = front[column] + color[column] * transmittance[column];
            }
        }
        for (to, color) in [&mut *red, &mut *green, &mut *blue].into_iter().zip(&behind) {
            to[row * TILE..][..TILE].copy_from_slice(color);
        }
        let [reds, greens, blues] = &behind;
        for block in 0..TILE / LANES {
            for (lane, sum) in sums.iter_mut().enumerate() {
                let at = block * LANES + lane;
                *sum += log2(delta + luminance(reds[at], greens[at], blues[at]));
            }
        }
    }
    sums.iter().sum::<f32>() * std::f32::consts::LN_2
}
}

/// Puts a drop behind what is in a tile already, whose upper left pixel is (`left`, `top`).
#[inline(always)]
fn splat(
    drop: &Seen,
    left: f32,
    top: f32,
    c: &Constants,
    sky: &Sky,
    pictures: &Pictures,
    planes: &mut Planes,
) {
    let outline = Outline::new(drop, c);
    let range = outline.pixels();
    let clip = |at: f32| at.clamp(0.0, TILE as f32 - 1.0) as i32 as usize;
    let (first, last) = (clip(range[0] - left), clip(range[1] - left));
    let rows = clip(range[2] - top)..clip(range[3] - top) + 1;
    let [axis_x, axis_y, axis_z] = c.sight.axes;
    let center = drop.x * axis_x + drop.y * axis_y + drop.z * axis_z;
    if outline.area < ONE_PIXEL {
        let at = rows.start * PITCH + first;
        if planes[3][at] > FULL {
            behind(planes, at, pictures.mean(center), outline.area);
        }
        return;
    }
    let radius_px = (outline.area / PI).sqrt();
    let d = center.normalize();
    if radius_px >= PICTURE_PX {
        for row in rows {
            for block in (first..=last).step_by(LANES) {
                let place = [left + block as f32, top + row as f32];
                let at = row * PITCH + block;
                splat_large(center, radius_px, place, at, c, sky, planes);
            }
        }
        return;
    }
    // From pixels to the disc's (s, t): a plane through the centre.
    let (picture, [u, v]) = pictures.picture(d);
    let scale = -drop.z / (c.focal * c.radius);
    let across = [axis_x.dot(u) * scale, axis_x.dot(v) * scale];
    let down = [-axis_y.dot(u) * scale, -axis_y.dot(v) * scale];
    let mean = pictures.mean(d);
    for row in rows {
        let dy = top + row as f32 + 0.5 - outline.y;
        for block in (first..=last).step_by(LANES) {
            let (mut s, mut t, mut coverage) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            for lane in 0..LANES {
                let dx = left + (block + lane) as f32 + 0.5 - outline.x;
                s[lane] = dx * across[0] + dy * down[0];
                t[lane] = dx * across[1] + dy * down[1];
                let rho = (s[lane] * s[lane] + t[lane] * t[lane]).sqrt();
                coverage[lane] = ((1.0 - rho) * radius_px + 0.5).clamp(0.0, 1.0);
            }
            let mut color = [[mean.x; LANES], [mean.y; LANES], [mean.z; LANES]];
            if radius_px >= MEAN_PX {
                for lane in 0..LANES {
                    if coverage[lane] > 0.0 {
                        let texel = look_up(picture, s[lane], t[lane]);
                        (color[0][lane], color[1][lane], color[2][lane]) =
                            (texel.x, texel.y, texel.z);
                    }
                }
            }
            blend(planes, row * PITCH + block, &color, &coverage);
        }
    }
}

/// Eight pixels of a drop, whose centre is in world space, by the closed form along their rays; the
/// first is at `place` in the image and `at` in the planes.
#[inline(always)]
fn splat_large(
    center: Vec3,
    radius_px: f32,
    [left, top]: [f32; 2],
    at: usize,
    c: &Constants,
    sky: &Sky,
    planes: &mut Planes,
) {
    let [axis_x, axis_y, axis_z] = c.sight.axes;
    let along = (0.5 * c.height as f32 - (top + 0.5)) * axis_y - c.focal * axis_z;
    let (mut rays, mut offsets) = ([Vec3::ZERO; LANES], [Vec3::ZERO; LANES]);
    let mut coverage = [0.0f32; LANES];
    for lane in 0..LANES {
        let x = left + lane as f32 + 0.5 - 0.5 * c.width as f32;
        let ray = x * axis_x + along;
        let ray = ray * (1.0 / ray.length());
        let offset = (center.dot(ray) * ray - center) * (1.0 / c.radius);
        let b = offset.length();
        coverage[lane] = ((1.0 - b) * radius_px + 0.5).clamp(0.0, 1.0);
        // Beyond the rim: what the rim shows.
        (rays[lane], offsets[lane]) = (ray, offset * (1.0 / b.max(1.0)));
    }
    let open = &planes[3][at..at + LANES];
    if (0..LANES).all(|lane| coverage[lane] <= 0.0 || open[lane] <= FULL) {
        return;
    }
    let (mut u, mut v) = ([[0.0f32; LANES]; ORDERS], [[0.0f32; LANES]; ORDERS]);
    let (mut level, mut weight) = ([[0.0f32; LANES]; ORDERS], [[0.0f32; LANES]; ORDERS]);
    for lane in 0..LANES {
        let rays = drop_rays(rays[lane], offsets[lane], 1.0 / radius_px);
        for (order, (direction, spread, share)) in rays.into_iter().enumerate() {
            [u[order][lane], v[order][lane]] = place(direction);
            level[order][lane] = sky.level(spread);
            weight[order][lane] = share;
        }
    }
    let mut color = [[0.0f32; LANES]; 3];
    for lane in 0..LANES {
        if coverage[lane] > 0.0 && planes[3][at + lane] > FULL {
            let mut sum = Vec4::ZERO;
            for order in 0..ORDERS {
                let light = sky.trilinear(u[order][lane], v[order][lane], level[order][lane]);
                sum += light * weight[order][lane];
            }
            (color[0][lane], color[1][lane], color[2][lane]) = (sum.x, sum.y, sum.z);
        }
    }
    blend(planes, at, &color, &coverage);
}

/// Puts eight pixels of a drop behind those from `at` on.
#[inline(always)]
fn blend(planes: &mut Planes, at: usize, color: &[[f32; LANES]; 3], coverage: &[f32; LANES]) {
    let [red, green, blue, through] = planes;
    let through = &mut through[at..at + LANES];
    let mut share = [0.0f32; LANES];
    for lane in 0..LANES {
        share[lane] = coverage[lane] * through[lane];
        through[lane] -= share[lane];
    }
    for (plane, color) in [red, green, blue].into_iter().zip(color) {
        let plane = &mut plane[at..at + LANES];
        for lane in 0..LANES {
            plane[lane] += color[lane] * share[lane];
        }
    }
}

/// What covers a pixel hides by that share of what it still lets through.
#[inline(always)]
fn behind(planes: &mut Planes, at: usize, color: Vec4, coverage: f32) {
    let share = coverage * planes[3][at];
    for (plane, channel) in planes.iter_mut().zip([color.x, color.y, color.z, -1.0]) {
        plane[at] += channel * share;
    }
}

/// Bilinear between the texels of a far drop's picture.
#[inline(always)]
fn look_up(picture: &[Vec4; EDGE * EDGE], s: f32, t: f32) -> Vec4 {
    let at = |p: f32| ((0.5 * p + 0.5) * EDGE as f32 - 0.5).clamp(0.0, EDGE as f32 - 1.001);
    let (x, y) = (at(s), at(t));
    let (left, top) = (x as i32, y as i32);
    let first = top as usize * EDGE + left as usize;
    mix(picture, first, EDGE, x - left as f32, y - top as f32)
}

/// Luminance of linear RGB with Rec. 709 primaries.
#[inline(always)]
pub fn luminance(red: f32, green: f32, blue: f32) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}
