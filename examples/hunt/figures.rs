//! What an eye sees of an error, in figures; and which of them a picture without any error would have by the reference's
//! noise alone.
//!
//! The reference is two halves of one number of samples, whose noise is independent. A product of the distances from both
//! has no noise on the mean; so squares are taken as such products, and a root of what is not negative. FLIP is no square: the
//! reference's own, of one half against the mean of both, is taken off in quadrature. It is as far from the mean as the mean
//! is from the truth.

use raindrops::picture::Picture;
use raindrops::picture::flip::{PIXELS_PER_DEGREE, flip};
use raindrops::picture::metrics::percentile;
use raindrops::picture::srgb_of_linear;
use raindrops::picture::tone_map::{Exposure, display};
use serde::{Deserialize, Serialize};

/// Opacity over which a pixel is of a drop.
const OPAQUE: f32 = 0.02;

/// Edge of the mean for `box`, in pixels.
const BOX: usize = 8;

/// A picture's error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Figures {
    /// Largest error after an 8 x 8 mean, in levels of 255.
    #[serde(rename = "box")]
    pub boxes: f64,
    /// RMS over drops' pixels of the error less its 3 x 3 mean, in levels.
    pub dots: f64,
    /// 99th percentile of FLIP over drops' pixels.
    pub flip: f64,
    /// RMS of the error over all pixels, 0 to 1.
    pub rms: f64,
}

/// A picture as it is shown: three levels of 0 to 255 a pixel, not rounded.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    width: usize,
    values: Vec<[f64; 3]>,
}

impl Levels {
    /// The levels of a picture by an exposure.
    pub fn of(picture: &Picture, exposure: Exposure) -> Self {
        let level = |linear: f32| 255.0 * f64::from(srgb_of_linear(linear));
        let shown = display(exposure, picture).pixels;
        let values = shown.iter().map(|pixel| pixel.to_array().map(level)).collect();
        Self { width: picture.width as usize, values }
    }

    /// What it has over another.
    pub fn less(&self, other: &Self) -> Self {
        let pairs = self.values.iter().zip(&other.values);
        let values = pairs.map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
        Self { width: self.width, values }
    }

    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Mean over a rectangle, of its pixels that there are.
    fn mean(&self, [left, upper, right, lower]: [usize; 4]) -> [f64; 3] {
        let (right, lower) = (right.min(self.width), lower.min(self.height()));
        let mut sum = [0.0; 3];
        for y in upper..lower {
            for pixel in &self.values[y * self.width + left..y * self.width + right] {
                (0..3).for_each(|c| sum[c] += pixel[c]);
            }
        }
        sum.map(|sum| sum / ((right - left) * (lower - upper)) as f64)
    }

    /// Means over boxes of 8 x 8 that lie side by side; those at the right and the lower edge may be smaller.
    fn boxed(&self) -> Self {
        let width = self.width.div_ceil(BOX);
        let count = width * self.height().div_ceil(BOX);
        let values = (0..count).map(|at| {
            let (left, upper) = (at % width * BOX, at / width * BOX);
            self.mean([left, upper, left + BOX, upper + BOX])
        });
        Self { width, values: values.collect() }
    }

    /// Each value less the mean of the 3 x 3 around it.
    fn fine(&self) -> Self {
        let values = (0..self.values.len()).map(|at| {
            let (x, y) = (at % self.width, at / self.width);
            let around = self.mean([x.saturating_sub(1), y.saturating_sub(1), x + 2, y + 2]);
            std::array::from_fn(|c| self.values[at][c] - around[c])
        });
        Self { width: self.width, values: values.collect() }
    }
}

/// Mean of the products of two errors over the pixels that count; 0 if none does.
pub fn mean_product(a: &Levels, b: &Levels, counts: impl Fn(usize) -> bool) -> f64 {
    let pairs = a.values.iter().zip(&b.values).enumerate().filter(|(at, _)| counts(*at));
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (_, (a, b))| {
        (sum + (0..3).map(|c| a[c] * b[c]).sum::<f64>(), count + 3.0)
    });
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The largest RMS over the pixels that count that a change may well have, which two halves of a reference found as `a` and `b`: the
/// root of their mean product and of two of its standard errors by the halves' noise. Without noise it is the RMS; 0 if no pixel counts.
pub fn rms_at_most(a: &Levels, b: &Levels, counts: impl Fn(usize) -> bool) -> f64 {
    let pairs = a.values.iter().zip(&b.values).enumerate().filter(|(at, _)| counts(*at));
    // The variance of a b: the square of t d, where t is the halves' mean and d their difference.
    let variances: Vec<f64> = pairs
        .map(|(_, (a, b))| (0..3).map(|c| 0.5 * (a[c] + b[c]) * (a[c] - b[c])).sum::<f64>() / 3.0)
        .map(|moved| moved * moved)
        .collect();
    let error = variances.iter().sum::<f64>().sqrt() / variances.len().max(1) as f64;
    (mean_product(a, b, counts) + 2.0 * error).max(0.0).sqrt()
}

/// Both halves of a reference, and what is of a drop.
#[derive(Clone, Debug, PartialEq)]
pub struct Halves {
    /// Radiance.
    pub halves: [Picture; 2],
    /// Share of the light behind that drops take away, for each pixel.
    pub opacity: Vec<f32>,
    /// Samples a pixel of each.
    pub samples: u32,
}

impl Halves {
    /// The mean of both.
    pub fn mean(&self) -> Picture {
        let [a, b] = &self.halves;
        let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| 0.5 * (*a + *b)).collect();
        Picture { pixels, ..*a }
    }

    /// Whether a pixel is of a drop.
    pub fn is_drop(&self, at: usize) -> bool {
        self.opacity[at] > OPAQUE
    }

    /// Share of the pixels that are of a drop.
    pub fn of_drops(&self) -> f64 {
        let count = self.opacity.iter().filter(|opacity| **opacity > OPAQUE).count();
        count as f64 / self.opacity.len().max(1) as f64
    }

    /// The figures of the noise of their mean.
    pub fn noise(&self, exposure: Exposure) -> Figures {
        let [a, b] = self.halves.each_ref().map(|half| Levels::of(half, exposure));
        let apart = a.less(&b);
        let of_mean = |square: f64| 0.5 * square.max(0.0).sqrt();
        let boxes = apart.boxed();
        let largest = boxes.values.iter().flatten().map(|value| value.abs()).fold(0.0, f64::max);
        let fine = apart.fine();
        let mean = self.mean();
        Figures {
            boxes: 0.5 * largest,
            dots: of_mean(mean_product(&fine, &fine, |at| self.is_drop(at))),
            flip: self.flip(&mean, &self.halves[0], exposure),
            rms: of_mean(mean_product(&apart, &apart, |_| true)) / 255.0,
        }
    }

    /// The figures of a picture's error, without the noise.
    pub fn figures(&self, picture: &Picture, exposure: Exposure, noise: &Figures) -> Figures {
        let shown = Levels::of(picture, exposure);
        let [a, b] = self.halves.each_ref().map(|half| shown.less(&Levels::of(half, exposure)));
        let (boxes_a, boxes_b) = (a.boxed(), b.boxed());
        let both = boxes_a.values.iter().flatten().zip(boxes_b.values.iter().flatten());
        let flip = self.flip(&self.mean(), picture, exposure);
        Figures {
            boxes: both.map(|(a, b)| (a * b).max(0.0).sqrt()).fold(0.0, f64::max),
            dots: mean_product(&a.fine(), &b.fine(), |at| self.is_drop(at)).max(0.0).sqrt(),
            flip: (flip * flip - noise.flip * noise.flip).max(0.0).sqrt(),
            rms: mean_product(&a, &b, |_| true).max(0.0).sqrt() / 255.0,
        }
    }

    /// 99th percentile of FLIP over drops' pixels.
    fn flip(&self, a: &Picture, b: &Picture, exposure: Exposure) -> f64 {
        let all = flip(&display(exposure, a), &display(exposure, b), PIXELS_PER_DEGREE);
        let of_drops: Vec<f64> =
            (0..all.len()).filter(|at| self.is_drop(*at)).map(|at| all[at]).collect();
        percentile(&of_drops, 0.99)
    }

    /// Middle of the box with the largest error, in pixels.
    pub fn worst_place(&self, picture: &Picture, exposure: Exposure) -> [u32; 2] {
        let error = Levels::of(picture, exposure).less(&Levels::of(&self.mean(), exposure));
        let boxes = error.boxed();
        let size =
            |at: &usize| boxes.values[*at].iter().map(|value| value.abs()).fold(0.0, f64::max);
        let all = 0..boxes.values.len();
        let worst = all.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        [worst % boxes.width, worst / boxes.width].map(|at| (at * BOX + BOX / 2) as u32)
    }
}
