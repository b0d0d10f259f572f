//! The small and very bright parts of an environment, apart from the rest: a bare sun, lamps.
//!
//! A drop shows the sun as a glint of some 10⁻⁵ of its disc, 10⁵ times as bright as what is around
//! it: rays that are spread evenly over the disc meet it by chance. Who knows where the bright parts
//! are can look for their images instead (`reference/glints.rs`).
//!
//! Each texel is split at a threshold, `texel = min(texel, threshold) + excess`, a component at a
//! time. Interpolation is linear, so the two parts add up to the whole in every direction.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::levels::{direction_of, interpolate};
use super::ordinary::THRESHOLD;
use super::{Environment, LUMINANCE};

/// Mean square of an excess over the sphere, over the square of the mean luminance, under which
/// samples serve: this many samples a pixel bring the noise down to the mean itself.
const WORTHWHILE: f64 = 1.0;

/// Angular radius above which samples meet an excess often enough by themselves.
const LARGEST: f64 = 15.0 * PI / 180.0;

/// Most regions that the reference looks for; those of the most noise. Each costs time in every drop.
const MOST: usize = 16;

/// An environment in two parts.
#[derive(Clone, Debug)]
pub struct Bright {
    /// What is left without the excess.
    pub rest: Environment,
    /// Where the excess is.
    pub regions: Vec<Region>,
}

impl Bright {
    /// These parts of `environment`, where a region whose middle is far brighter than its edge, such as a sun in its halo,
    /// becomes several: see `layers`.
    pub fn in_layers(self, environment: &Environment) -> Self {
        let mut regions = Vec::new();
        for region in self.regions {
            layers(environment, region, &mut regions);
        }
        Self { regions, ..self }
    }

    /// The light of the bright parts over that of the rest, both from all around.
    pub fn strength(&self) -> f64 {
        let light = |region: &Region| region.luminance * region.solid_angle();
        let bright: f64 = self.regions.iter().map(light).sum();
        bright / (4.0 * PI * self.rest.mean_luminance()).max(f64::MIN_POSITIVE)
    }
}

/// Solid angle of a cap of this angular radius.
fn cap(radius: f64) -> f64 {
    TAU * (1.0 - radius.cos())
}

/// Texels with an excess that touch each other, within a cap.
#[derive(Clone, Debug)]
pub struct Region {
    /// Unit vector to the middle of the cap.
    pub direction: DVec3,
    /// Angular radius of the cap, in radians; beyond it the excess is 0.
    pub radius: f64,
    /// Mean luminance of the excess over the cap.
    pub luminance: f64,
    /// Size of the whole environment, in texels.
    width: u32,
    height: u32,
    /// Leftmost column and uppermost row of the texels below; the columns go on around the seam.
    left: i64,
    top: i64,
    columns: i64,
    rows: i64,
    /// What a texel has beyond this is its excess.
    from: f32,
    excess: Vec<Vec3>,
}

/// An even disc with the light, the middle and the breadth of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Unit vector to its middle.
    pub direction: DVec3,
    /// Angular radius in radians: that of the disc with the region's mean square distance from the middle.
    pub radius: f64,
    /// Radiance times solid angle.
    pub light: DVec3,
}

impl Region {
    /// Is the region not much wider than the disc that stands for it? Of a sun in its halo that disc is the sun's, and the
    /// halo would be missed where it is.
    pub fn is_disc(&self) -> bool {
        let texel = PI / f64::from(self.height);
        self.radius <= 2.0 * (self.source().radius + texel)
    }

    /// Solid angle of the cap.
    pub fn solid_angle(&self) -> f64 {
        cap(self.radius)
    }

    /// A direction within the cap, by two numbers of 0 to 1, evenly.
    pub(crate) fn at(&self, height: f64, turn: f64) -> DVec3 {
        let (u, v) = self.direction.any_orthonormal_pair();
        let height = 1.0 - height * (1.0 - self.radius.cos());
        let (sine, cosine) = (TAU * turn).sin_cos();
        let aside = (1.0 - height * height).max(0.0).sqrt();
        height * self.direction + aside * (cosine * u + sine * v)
    }

    /// The disc that stands for the region.
    pub fn source(&self) -> Source {
        let texel = PI / f64::from(self.height);
        let (mut light, mut square, mut all) = (DVec3::ZERO, 0.0, 0.0);
        for (direction, of_texel) in self.lights() {
            let luminance = of_texel.dot(LUMINANCE);
            light += of_texel;
            square += luminance * direction.angle_between(self.direction).powi(2);
            all += luminance;
        }
        // A texel's own light is spread as interpolation does it, by a sixth of its square along each axis. The mean
        // square distance in a disc is half of its radius'.
        let mean_square = square / all.max(f64::MIN_POSITIVE) + texel * texel / 3.0;
        Source { direction: self.direction, radius: (2.0 * mean_square).sqrt(), light }
    }

    /// The direction of each texel of the region, and its excess times its solid angle.
    fn lights(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        (0..).zip(&self.excess).map(move |(index, excess)| {
            let (x, y) = (self.left + index % self.columns, self.top + index / self.columns);
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            let solid_angle = TAU / width * (PI / height) * (PI * y / height).sin();
            (direction_of(x / width, y / height), solid_angle * excess.as_dvec3())
        })
    }

    /// Without what texels have beyond a bound.
    fn up_to(mut self, bound: f32) -> Self {
        for excess in &mut self.excess {
            *excess = excess.min(Vec3::splat(bound - self.from));
        }
        let power: f64 = self.lights().map(|(_, light)| light.dot(LUMINANCE)).sum();
        self.luminance = power / cap(self.radius);
        self
    }

    /// The excess of a texel; columns go on beyond the seam.
    fn excess_at(&self, (column, row): (i64, i64)) -> Vec3 {
        let column = (column - self.left).rem_euclid(i64::from(self.width));
        let row = row - self.top;
        let is_within = column < self.columns && (0..self.rows).contains(&row);
        if is_within { self.excess[(row * self.columns + column) as usize] } else { Vec3::ZERO }
    }

    /// The excess in a unit direction.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        interpolate(self.width, self.height, direction, |column, row| {
            self.excess_at((column as i64, row as i64)).as_dvec3()
        })
    }
}

/// The small bright parts apart from the rest; `None` where there are none.
pub fn split(environment: &Environment) -> Option<Bright> {
    split_off(environment, MOST, |region| region.radius <= LARGEST)
}

/// Part of a region's brightest texel under which nothing is worth a layer of its own.
const FAINTEST: f32 = 1.0 / 65_536.0;

/// A region in layers of radiance. Samples that are spread evenly over its cap would rarely meet a sun of half a degree
/// in a halo of nine; what is brighter than a bound is another region, with a cap of its own, where that is at most half
/// as wide.
fn layers(environment: &Environment, region: Region, found: &mut Vec<Region>) {
    let brightest = region.excess.iter().fold(0f32, |most, excess| most.max(excess.max_element()));
    // On black every texel has an excess, and no bound is twice 0.
    let mut bound = (2.0 * region.from).max(FAINTEST * brightest);
    loop {
        let inner: Vec<Region> = connected(environment, Vec3::splat(bound))
            .iter()
            .filter(|texels| region.excess_at(texels[0]) != Vec3::ZERO)
            .map(|texels| self::region(environment, texels, bound).1)
            .collect();
        if inner.is_empty() {
            return found.push(region);
        }
        if inner.iter().all(|inner| inner.radius <= 0.5 * region.radius) {
            found.push(region.up_to(bound));
            return inner.into_iter().for_each(|inner| layers(environment, inner, found));
        }
        bound *= 2.0;
    }
}

/// Like [`split`], but `most` regions at most, and those alone that are `wanted`; further ones stay in the rest. Of another,
/// such as a sun in its halo, what is brighter than a bound is a region where that is wanted: the halo stays in the rest.
pub fn split_off(
    environment: &Environment,
    most: usize,
    wanted: impl Fn(&Region) -> bool,
) -> Option<Bright> {
    let mean = environment.ordinary_luminance();
    let mut found: Vec<(f64, Region)> = Vec::new();
    let (mut from, mut is_wide) = ((THRESHOLD * mean) as f32, true);
    while is_wide {
        is_wide = false;
        for texels in connected(environment, Vec3::splat(from)) {
            if found.iter().any(|(_, region)| region.excess_at(texels[0]) != Vec3::ZERO) {
                continue;
            }
            let (mean_square, region) = region(environment, &texels, from);
            let is_worthwhile = mean_square >= WORTHWHILE * mean * mean;
            if is_worthwhile && wanted(&region) {
                found.push((mean_square, region));
            } else {
                // With a higher bound it would be the less worth while.
                is_wide |= is_worthwhile;
            }
        }
        // Before black no bound is twice the one before.
        from = (2.0 * from).max(FAINTEST * environment.max_radiance());
    }
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    found.truncate(most);
    if found.is_empty() {
        return None;
    }
    let regions: Vec<Region> = found.into_iter().map(|(_, region)| region).collect();
    let mut rest = environment.clone();
    for region in &regions {
        for (index, excess) in (0..).zip(&region.excess) {
            let column = (region.left + index % region.columns).rem_euclid(i64::from(rest.width));
            let row = region.top + index / region.columns;
            let texel = &mut rest.texels[(row * i64::from(rest.width) + column) as usize];
            if *excess != Vec3::ZERO {
                *texel = texel.min(Vec3::splat(region.from));
            }
        }
    }
    Some(Bright { rest, regions })
}

/// Columns and rows of the texels above the threshold, those together that touch, by a corner too.
/// Columns go on beyond the seam instead of starting anew.
fn connected(environment: &Environment, threshold: Vec3) -> Vec<Vec<(i64, i64)>> {
    let (width, height) = (i64::from(environment.width), i64::from(environment.height));
    let index = |column: i64, row: i64| (row * width + column.rem_euclid(width)) as usize;
    let mut is_open: Vec<bool> =
        environment.texels.iter().map(|texel| texel.cmpgt(threshold).any()).collect();
    let mut all = Vec::new();
    for start in 0..is_open.len() {
        if !std::mem::take(&mut is_open[start]) {
            continue;
        }
        let mut texels = vec![(start as i64 % width, start as i64 / width)];
        let mut next = 0;
        while let Some(&(column, row)) = texels.get(next) {
            next += 1;
            for y in (row - 1).max(0)..=(row + 1).min(height - 1) {
                for x in column - 1..=column + 1 {
                    if std::mem::take(&mut is_open[index(x, y)]) {
                        texels.push((x, y));
                    }
                }
            }
        }
        all.push(texels);
    }
    all
}

/// A region of what these texels have beyond `from`, and the mean square of its luminance over the sphere.
fn region(environment: &Environment, texels: &[(i64, i64)], from: f32) -> (f64, Region) {
    let (width, height) = (f64::from(environment.width), f64::from(environment.height));
    // In texels from the left and the upper edge.
    let direction = |x: f64, y: f64| direction_of(x / width, y / height);
    let center = |&(column, row): &(i64, i64)| (column as f64 + 0.5, row as f64 + 0.5);
    let excess = |&(column, row): &(i64, i64)| {
        let column = column.rem_euclid(i64::from(environment.width));
        let texel = environment.texels[(row * i64::from(environment.width) + column) as usize];
        texel - texel.min(Vec3::splat(from))
    };
    let (mut power, mut square, mut toward) = (0.0, 0.0, DVec3::ZERO);
    for texel in texels {
        let (x, y) = center(texel);
        let solid_angle = TAU / width * (PI / height) * (PI * y / height).sin();
        let luminance = excess(texel).as_dvec3().dot(LUMINANCE);
        power += solid_angle * luminance;
        square += solid_angle * luminance * luminance;
        toward += solid_angle * luminance * direction(x, y);
    }
    let middle = toward.normalize_or(DVec3::Y);
    // A texel's light fades to nothing at its neighbours' centres.
    let reach = texels.iter().flat_map(|texel| {
        let (x, y) = center(texel);
        [-1.0, 0.0, 1.0].into_iter().flat_map(move |right| {
            [-1.0, 0.0, 1.0].map(|down| direction(x + right, y + down).angle_between(middle))
        })
    });
    let radius = reach.fold(0.0, f64::max);

    let least = |of: fn(&(i64, i64)) -> i64| texels.iter().map(of).min().unwrap_or(0);
    let most = |of: fn(&(i64, i64)) -> i64| texels.iter().map(of).max().unwrap_or(0);
    let (left, top) = (least(|texel| texel.0), least(|texel| texel.1));
    let columns = (most(|texel| texel.0) - left + 1).min(i64::from(environment.width));
    let rows = most(|texel| texel.1) - top + 1;
    let mut block = vec![Vec3::ZERO; (columns * rows) as usize];
    for texel in texels {
        let column = (texel.0 - left).rem_euclid(i64::from(environment.width));
        block[((texel.1 - top) * columns + column) as usize] = excess(texel);
    }
    let region = Region {
        direction: middle,
        radius,
        luminance: power / cap(radius),
        width: environment.width,
        height: environment.height,
        left,
        top,
        columns,
        rows,
        from,
        excess: block,
    };
    (square / (4.0 * PI), region)
}
