//! The samples of a pixel: places in it, and where there is a lens or an exposure also places on the lens
//! and moments. A pure function of (pixel, sample, seed), so that a picture does not depend on the number
//! of threads.

use glam::DVec2;

use super::sobol::Sobol;
use crate::rain::{pcg4d, unit};

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Place in the pixel from its left edge, 0 to 1.
    pub x: f64,
    /// Place in the pixel from its upper edge, 0 to 1.
    pub y: f64,
    /// Place on the lens, within the unit circle.
    pub lens: DVec2,
    /// Share of the exposure that has gone by, 0 to 1.
    pub moment: f64,
}

/// How a pixel is sampled.
#[derive(Clone, Debug)]
pub enum Samples {
    /// By place alone.
    Places(Strata),
    /// By place, moment and place on the lens together.
    Exposed(Box<Sobol>),
}

impl Samples {
    /// `count` samples a pixel (0 is taken as 1).
    pub fn new(count: u32, seed: u64, is_exposed: bool) -> Self {
        match is_exposed {
            true => Self::Exposed(Box::new(Sobol::new(count, seed))),
            false => Self::Places(Strata::new(count, seed)),
        }
    }

    /// Fills `found` with the samples of a pixel, by its number in the picture.
    pub fn of_pixel(&self, pixel: u32, found: &mut Vec<Sample>) {
        found.clear();
        match self {
            Self::Places(strata) => {
                found.extend(strata.places(pixel).map(|(x, y)| Sample {
                    x,
                    y,
                    ..Sample::default()
                }));
            }
            Self::Exposed(sobol) => {
                found.extend(sobol.points(pixel).map(|[x, y, moment, right, up]| Sample {
                    x,
                    y,
                    lens: disc(right, up),
                    moment,
                }));
            }
        }
    }
}

/// A place in the unit square to one in the unit disc, area for area, squares around the middle to circles
/// (Shirley and Chiu 1997), so that what is stratified stays so.
fn disc(x: f64, y: f64) -> DVec2 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) = match a.abs() > b.abs() {
        true => (a, FRAC_PI_4 * b / a),
        false => (b, FRAC_PI_2 - FRAC_PI_4 * a / b),
    };
    radius * DVec2::from_angle(angle)
}

/// Strata of equal area that fill a pixel, one a sample, for any number of samples.
///
/// The pixel is cut into ⌊√N⌋ rows; the N strata are dealt out to the rows as evenly as they go,
/// and a row is as high as its share of them. For a square number that is the usual jittered grid,
/// whose error falls like N^(-3/4) where an edge crosses the pixel and like 1/N elsewhere
/// (Mitchell 1996, "Consequences of stratified sampling in graphics"), against N^(-1/2) unstratified.
#[derive(Clone, Debug)]
pub struct Strata {
    seed: u64,
    /// Left, upper, width, height of each stratum in pixels.
    cells: Vec<[f64; 4]>,
}

impl Strata {
    /// Strata for `samples` samples a pixel (0 is taken as 1).
    pub fn new(samples: u32, seed: u64) -> Self {
        let samples = u64::from(samples.max(1));
        let rows = samples.isqrt();
        let mut cells = Vec::with_capacity(samples as usize);
        for row in 0..rows {
            let (first, end) = (row * samples / rows, (row + 1) * samples / rows);
            let columns = (end - first) as f64;
            for column in 0..end - first {
                cells.push([
                    column as f64 / columns,
                    first as f64 / samples as f64,
                    1.0 / columns,
                    columns / samples as f64,
                ]);
            }
        }
        Self { seed, cells }
    }

    /// Places of the samples in pixel (0 to 1 from its upper left corner), by the number of the
    /// pixel in its picture.
    pub fn places(&self, pixel: u32) -> impl Iterator<Item = (f64, f64)> {
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        self.cells.iter().zip(0..).map(move |(&[left, upper, width, height], sample)| {
            let [x, y, ..] = pcg4d([pixel, sample, low, high]);
            (left + width * unit(x), upper + height * unit(y))
        })
    }
}
