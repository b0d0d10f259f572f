//! How far a picture is from the truth: relMSE and the largest error on linear radiance; PSNR and
//! FLIP on display values after one tone mapping, whose exposure comes from the truth for both.
//!
//! All of them also after a box filter of 8 x 8 pixels: a small bright sun seen through a million
//! drops decides every figure taken pixel by pixel, and whether *this* pixel or its neighbour
//! glints is not what the eye asks.

use glam::{DVec3, Vec3};
use serde::Serialize;

use super::flip::{PIXELS_PER_DEGREE, flip};
use super::{Picture, srgb_of_linear};
use crate::picture::tone_map::{Exposure, display, log_average};

/// Edge of the box filter in pixels.
pub const BOX: u32 = 8;

/// Darkest radiance that relMSE takes relative errors of, over the truth's log-average luminance.
/// Below it an error counts as if it stood there: black need not be met to the last digit.
pub const FLOOR: f64 = 0.05;

/// The figures of one comparison.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Mean over pixels and channels of `(b-a)² / (a² + (0.05 L̄)²)`, L̄ the log-average luminance
    /// of a; over the pixels of the mask where there is one.
    pub rel_mse: f64,
    /// 10 log10(1 / MSE) in decibels, on sRGB values 0 to 1; infinite for equal pictures, which JSON
    /// writes as null.
    pub psnr_db: f64,
    /// Mean FLIP error, 0 to 1.
    pub flip: f64,
    /// 99th percentile of the FLIP errors.
    pub flip_p99: f64,
    /// Largest |b-a| of any channel, in linear radiance.
    pub max_error: f64,
    /// Column and row of the pixel with the largest error.
    pub max_error_at: (u32, u32),
}

impl Metrics {
    /// Root mean square of the difference of sRGB values, 0 to 1.
    pub fn rms(&self) -> f64 {
        10f64.powf(-self.psnr_db / 20.0)
    }
}

/// A comparison, pixel by pixel and after the box filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Pixel by pixel.
    pub pixels: Metrics,
    /// After the box filter; `max_error_at` is in boxes.
    pub boxes: Metrics,
    /// Mean luminance of the truth.
    pub mean_a: f64,
    /// Mean luminance of the picture held against it.
    pub mean_b: f64,
    /// FLIP error of each pixel, row by row.
    pub flip_map: Vec<f64>,
}

/// Compares `b` with the truth `a`. `exposure` is the truth's (`tone_map::exposure(a, key)`); `mask`
/// names the pixels of relMSE and of the largest error (all without it), row by row, over 0 where
/// they count.
///
/// Every figure of a picture that has a NaN or an infinity where the other has not is infinite, but
/// FLIP and PSNR, which see what a display would show.
///
/// # Panics
/// If the pictures, or the mask, differ in size.
pub fn compare(a: &Picture, b: &Picture, mask: Option<&[f32]>, exposure: Exposure) -> Comparison {
    assert_eq!((a.width, a.height), (b.width, b.height), "pictures of different sizes");
    assert!(mask.is_none_or(|mask| mask.len() == a.pixels.len()), "a mask of a different size");
    let (pixels, flip_map) = metrics(a, b, mask, exposure);
    let box_mask = mask.map(|mask| {
        let pixels = mask.iter().map(|&share| Vec3::splat(share)).collect();
        let picture = box_filter(&Picture { pixels, ..*a });
        picture.pixels.iter().map(|share| share.x).collect::<Vec<f32>>()
    });
    let (boxes, _) = metrics(&box_filter(a), &box_filter(b), box_mask.as_deref(), exposure);
    Comparison { pixels, boxes, mean_a: mean_luminance(a), mean_b: mean_luminance(b), flip_map }
}

fn metrics(
    a: &Picture,
    b: &Picture,
    mask: Option<&[f32]>,
    exposure: Exposure,
) -> (Metrics, Vec<f64>) {
    let (shown_a, shown_b) = (display(exposure, a), display(exposure, b));
    let flip_map = flip(&shown_a, &shown_b, PIXELS_PER_DEGREE);
    let (max_error, max_error_at) = max_error(a, b, mask);
    let figures = Metrics {
        rel_mse: rel_mse(a, b, mask),
        psnr_db: psnr_db(&shown_a, &shown_b),
        flip: mean(flip_map.iter().copied()),
        flip_p99: percentile(&flip_map, 0.99),
        max_error,
        max_error_at,
    };
    (figures, flip_map)
}

/// The pairs of pixels that count, with their numbers.
fn pairs<'a>(
    a: &'a Picture,
    b: &'a Picture,
    mask: Option<&'a [f32]>,
) -> impl Iterator<Item = (usize, DVec3, DVec3)> + 'a {
    let all = a.pixels.iter().zip(&b.pixels).enumerate();
    all.filter(move |(at, _)| mask.is_none_or(|mask| mask[*at] > 0.0))
        .map(|(at, (a, b))| (at, a.as_dvec3(), b.as_dvec3()))
}

/// |b-a| of a channel; 0 for equal infinities or two NaNs, infinite if only one is no number.
fn difference(a: f64, b: f64) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    let difference = (b - a).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}

/// Relative mean squared error of `b` against the truth `a`, see [`Metrics::rel_mse`]; 0 when no
/// pixel counts.
pub fn rel_mse(a: &Picture, b: &Picture, mask: Option<&[f32]>) -> f64 {
    let floor = FLOOR * log_average(a);
    mean(pairs(a, b, mask).flat_map(|(_, a, b)| {
        [0, 1, 2].map(|channel| {
            let error = difference(a[channel], b[channel]);
            let scale = a[channel] * a[channel] + floor * floor;
            // A black truth has no scale: any error from it is infinite, none is none.
            match error {
                0.0 => 0.0,
                f64::INFINITY => error,
                _ => error * error / scale,
            }
        })
    }))
}

/// Largest difference of any channel, and the column and row of the first pixel that has it.
pub fn max_error(a: &Picture, b: &Picture, mask: Option<&[f32]>) -> (f64, (u32, u32)) {
    let mut largest = (0.0, 0);
    for (at, a, b) in pairs(a, b, mask) {
        for channel in 0..3 {
            let error = difference(a[channel], b[channel]);
            if error > largest.0 {
                largest = (error, at as u32);
            }
        }
    }
    (largest.0, (largest.1 % a.width.max(1), largest.1 / a.width.max(1)))
}

/// Peak signal-to-noise ratio in decibels of linear display values, taken on the sRGB curve where
/// the peak is 1; infinite for equal pictures.
pub fn psnr_db(a: &Picture, b: &Picture) -> f64 {
    -10.0 * mean_square(a, b).log10()
}

/// Mean square of the difference of linear display values, taken on the sRGB curve.
pub fn mean_square(a: &Picture, b: &Picture) -> f64 {
    let squares = a.pixels.iter().zip(&b.pixels).flat_map(|(a, b)| {
        [0, 1, 2].map(|c| f64::from(srgb_of_linear(a[c]) - srgb_of_linear(b[c])).powi(2))
    });
    mean(squares)
}

/// Mean Rec. 709 luminance.
pub fn mean_luminance(picture: &Picture) -> f64 {
    mean(picture.pixels.iter().map(|pixel| crate::picture::tone_map::luminance(pixel.as_dvec3())))
}

/// Mean of the numbers; 0 if there are none.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The least value that at least this share of the values does not exceed; 0 if there are none.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    let rank = (share * values.len() as f64).ceil().max(1.0) as usize - 1;
    if rank >= sorted.len() {
        return 0.0;
    }
    *sorted.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// Means over boxes of [`BOX`] x [`BOX`] pixels that do not overlap; at the right and lower edge a
/// box takes the pixels that there are.
pub fn box_filter(picture: &Picture) -> Picture {
    let (width, height) = (picture.width.div_ceil(BOX), picture.height.div_ceil(BOX));
    let boxed = |column: u32, row: u32| {
        let mut sum = DVec3::ZERO;
        let mut count = 0.0;
        for y in row * BOX..(row * BOX + BOX).min(picture.height) {
            for x in column * BOX..(column * BOX + BOX).min(picture.width) {
                sum += picture.pixels[y as usize * picture.width as usize + x as usize].as_dvec3();
                count += 1.0;
            }
        }
        (sum / count).as_vec3()
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| boxed(x, y))).collect();
    Picture { width, height, pixels }
}
