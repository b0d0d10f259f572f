//! LDR-FLIP: how different two pictures look, pixel by pixel, when one is flipped to the other
//! (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images").
//!
//! Written from the paper in float64, for display values that were never rounded to 8 bits;
//! `tests/physics/metrics.rs` holds it against the authors' own code. Filters are applied row by row and
//! then column by column: a Gaussian and its derivatives separate, and the one channel whose filter
//! is a sum of two Gaussians is filtered twice.
//!
//! A pixel's error is `color^(1 - feature)`: the colour difference after the eye's own blur, made
//! larger where edges or points differ.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Picture;

/// Pixels a degree of the field of view: 0.7 m from a display 0.7 m and 3840 pixels wide, the
/// authors' default.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * std::f64::consts::PI / 180.0;

/// Compression of colour differences, section 4.1.
const COLOR_EXPONENT: f64 = 0.7;
/// Colour differences below this share of the largest …
const KNEE: f64 = 0.4;
/// … fill this share of the error's range.
const KNEE_ERROR: f64 = 0.95;
/// Compression of feature differences, section 4.2.
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the feature detectors, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// Contrast sensitivity of the eye (Table 1): terms `a √(π/b) exp(-π² x²/b)`, x in degrees, of the
/// achromatic, red-green and (a sum of two) blue-yellow channel. `a` only matters within a sum.
const ACHROMATIC: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// FLIP error of each pixel, 0 to 1, row by row, of `test` against `reference`: linear display
/// values 0 to 1 (what lies outside is clamped), pictures of the same size.
pub fn flip(reference: &Picture, test: &Picture, pixels_per_degree: f64) -> Vec<f64> {
    let (width, height) = (reference.width as usize, reference.height as usize);
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let [a, b] = [reference, test].map(|picture| {
        let opponent = opponent(picture);
        let perceived = perceived(&opponent, width, pixels_per_degree);
        (perceived, features(&opponent, width, pixels_per_degree))
    });
    let largest = largest_color_difference();
    let ((colors_a, features_a), (colors_b, features_b)) = (a, b);
    (0..width * height)
        .into_par_iter()
        .map(|at| {
            let color = color_error(colors_a[at], colors_b[at], largest);
            let (edge, point) =
                (features_a[at].0 - features_b[at].0, features_a[at].1 - features_b[at].1);
            let strongest = edge.abs().max(point.abs());
            let feature = (strongest * std::f64::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// Linear sRGB to CIE XYZ, D65 (the exact fractions that the primaries and white give).
const TO_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// XYZ of white: the sums of the rows of [`TO_XYZ`].
const WHITE: DVec3 = DVec3::new(
    (10_135_552.0 + 8_788_810.0 + 4_435_075.0) / 24_577_794.0,
    1.0,
    (1_425_312.0 + 8_788_810.0 + 70_074_185.0) / 73_733_382.0,
);

/// XYZ over that of white, from linear RGB.
fn over_white(color: DVec3) -> DVec3 {
    TO_XYZ * color / WHITE
}

/// The linear opponent space YCxCz: achromatic, red-green, blue-yellow.
fn opponent(picture: &Picture) -> Vec<DVec3> {
    let of = |pixel: &glam::Vec3| {
        let p = over_white(pixel.as_dvec3().clamp(DVec3::ZERO, DVec3::ONE));
        DVec3::new(116.0 * p.y - 16.0, 500.0 * (p.x - p.y), 200.0 * (p.y - p.z))
    };
    picture.pixels.par_iter().map(of).collect()
}

/// XYZ of an opponent colour.
fn from_opponent(color: DVec3) -> DVec3 {
    let y = (color.x + 16.0) / 116.0;
    DVec3::new(y + color.y / 500.0, y, y - color.z / 200.0) * WHITE
}

/// CIELAB with chroma scaled by lightness (Hunt's effect: colours fade in the dark).
fn hunt_lab(color: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let p = over_white(color)
        .map(|t| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * p.y - 16.0;
    let hunt = 0.01 * lightness;
    DVec3::new(lightness, 500.0 * (p.x - p.y) * hunt, 200.0 * (p.y - p.z) * hunt)
}

/// HyAB distance: city block in lightness, Euclidean in chroma.
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// The compressed difference of the farthest pair of primaries, green and blue.
fn largest_color_difference() -> f64 {
    hyab(hunt_lab(DVec3::Y), hunt_lab(DVec3::Z)).powf(COLOR_EXPONENT)
}

fn color_error(a: DVec3, b: DVec3, largest: f64) -> f64 {
    let difference = hyab(a, b).powf(COLOR_EXPONENT);
    let knee = KNEE * largest;
    if difference < knee {
        difference * KNEE_ERROR / knee
    } else {
        KNEE_ERROR + (difference - knee) / (largest - knee) * (1.0 - KNEE_ERROR)
    }
}

/// What the eye makes of a picture: each opponent channel blurred by its contrast sensitivity,
/// brought back to a displayable colour, in Hunt-adjusted CIELAB.
fn perceived(opponent: &[DVec3], width: usize, pixels_per_degree: f64) -> Vec<DVec3> {
    // All filters are as wide as the widest needs.
    let widest = BLUE_YELLOW[0].1;
    let pi2 = std::f64::consts::PI.powi(2);
    let radius = (3.0 * (widest / (2.0 * pi2)).sqrt() * pixels_per_degree).ceil() as i64;
    let gaussian = |(_, b): (f64, f64)| -> Vec<f64> {
        let at = |i: i64| (-pi2 * (i as f64 / pixels_per_degree).powi(2) / b).exp();
        let sum: f64 = (-radius..=radius).map(at).sum();
        (-radius..=radius).map(|i| at(i) / sum).collect()
    };
    // A two-dimensional Gaussian of unit height has the volume b/π (times pixels), so the terms of
    // the sum share the volume as a √(π/b) b, up to the sampled sums, which are used instead.
    let volume = |(a, b): (f64, f64)| {
        let line: f64 = (-radius..=radius)
            .map(|i| (-pi2 * (i as f64 / pixels_per_degree).powi(2) / b).exp())
            .sum();
        a * (std::f64::consts::PI / b).sqrt() * line * line
    };
    let [wide, narrow] = BLUE_YELLOW.map(volume);
    let share = wide / (wide + narrow);
    let kernels = [
        gaussian(ACHROMATIC),
        gaussian(RED_GREEN),
        gaussian(BLUE_YELLOW[0]),
        gaussian(BLUE_YELLOW[1]),
    ];

    let channels = |p: &DVec3| [p.x, p.y, p.z, p.z];
    let source: Vec<[f64; 4]> = opponent.iter().map(channels).collect();
    let weights = |i: usize, p: &[f64; 4]| [0, 1, 2, 3].map(|c| kernels[c][i] * p[c]);
    let blurred = convolve(&source, width, radius, Along::Rows, weights);
    let blurred = convolve(&blurred, width, radius, Along::Columns, weights);
    let to_rgb = TO_XYZ.inverse();
    blurred
        .par_iter()
        .map(|&[y, x, wide, narrow]| {
            let color =
                to_rgb * from_opponent(DVec3::new(y, x, share * wide + (1.0 - share) * narrow));
            hunt_lab(color.clamp(DVec3::ZERO, DVec3::ONE))
        })
        .collect()
}

/// Strength of edges and of points at each pixel, from the achromatic channel.
fn features(opponent: &[DVec3], width: usize, pixels_per_degree: f64) -> Vec<(f64, f64)> {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i64;
    let gaussian = |i: i64| (-((i * i) as f64) / (2.0 * deviation * deviation)).exp();
    let first = |i: i64| -(i as f64) * gaussian(i);
    let second = |i: i64| ((i * i) as f64 / (deviation * deviation) - 1.0) * gaussian(i);
    // Positive weights sum to 1, negative ones to -1.
    let balanced = |weight: &dyn Fn(i64) -> f64| -> Vec<f64> {
        let all = || (-radius..=radius).map(weight);
        let positive: f64 = all().filter(|&w| w > 0.0).sum();
        let negative: f64 = -all().filter(|&w| w < 0.0).sum::<f64>();
        all()
            .map(|w| if w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) })
            .collect()
    };
    let (smooth, edge, point) = (balanced(&gaussian), balanced(&first), balanced(&second));

    let grey: Vec<[f64; 4]> =
        opponent.iter().map(|p| [(p.x + 16.0) / 116.0, 0.0, 0.0, 0.0]).collect();
    let rows = convolve(&grey, width, radius, Along::Rows, |i, p| {
        [edge[i] * p[0], point[i] * p[0], smooth[i] * p[0], 0.0]
    });
    let both = convolve(&rows, width, radius, Along::Columns, |i, p| {
        [smooth[i] * p[0], smooth[i] * p[1], edge[i] * p[2], point[i] * p[2]]
    });
    both.iter().map(|&[ex, px, ey, py]| (ex.hypot(ey), px.hypot(py))).collect()
}

/// Which neighbours a one-dimensional filter takes.
#[derive(Clone, Copy)]
enum Along {
    Rows,
    Columns,
}

/// Sum over the neighbours i = 0 … 2 radius of `weigh(i, neighbour)`; at the border the outermost
/// pixel repeats.
fn convolve(
    source: &[[f64; 4]],
    width: usize,
    radius: i64,
    along: Along,
    weigh: impl Fn(usize, &[f64; 4]) -> [f64; 4] + Sync,
) -> Vec<[f64; 4]> {
    let height = source.len() / width;
    let clamped = |at: usize, i: i64, size: usize| {
        (at as i64 + i - radius).clamp(0, size as i64 - 1) as usize
    };
    let mut result = vec![[0.0; 4]; source.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        // Neighbour by neighbour for the whole row: memory is read in sequence.
        for i in 0..=2 * radius {
            let above = &source[clamped(y, i, height) * width..][..width];
            for (x, sum) in row.iter_mut().enumerate() {
                let neighbour = match along {
                    Along::Rows => &source[y * width + clamped(x, i, width)],
                    Along::Columns => &above[x],
                };
                let weighed = weigh(i as usize, neighbour);
                for (sum, weighed) in sum.iter_mut().zip(weighed) {
                    *sum += weighed;
                }
            }
        }
    });
    result
}
