//! From radiance to display in float64: the global photographic operator of Reinhard, Stark,
//! Shirley and Ferwerda 2002 ("Photographic tone reproduction for digital images"). The formulas are those of
//! `glsl/tone_map.frag`.
//!
//! With luminance Lw (Rec. 709) and log-average L̄ = exp(mean(log(δ + Lw))):
//! `L = key / L̄ · Lw`, `Ld = L / (1 + L)`, and the colour is scaled by Ld / Lw. (As printed, the
//! paper's equation 1 divides outside of the exponential; the mean of the logarithms is meant.)
//!
//! A fixed exposure ([`ToneMap::exposure`]) stands in for key / L̄, so that pictures of a sequence, or parts
//! of one picture, share it.
//!
//! δ keeps black pixels from pulling L̄ to zero. A fixed δ makes the picture depend on the unit of
//! radiance, so it is [`DELTA`] times the mean luminance of all but small bright parts. So neither
//! the unit nor a sun in the picture decides how bright the rest is.

use glam::{DVec3, Vec3};

use crate::environment::ordinary::settled;
use crate::picture::Picture;
use crate::scene::ToneMap;
use crate::scene::model::Operator;

/// δ over the mean luminance of all but small bright parts. A black pixel then counts as four decades under the mean: with a
/// tenth of the pixels black the log-average falls by a factor of 0.4, and no further however
/// black they are.
pub const DELTA: f64 = 1e-4;

/// Luminance of linear RGB with Rec. 709 (sRGB) primaries.
pub fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// How radiance becomes display values, fixed before any pixel is mapped: the same for every
/// picture that is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The photographic operator with this scale, `key / L̄` or a fixed one.
    Photographic(f64),
    /// No curve after this scale: values over 1 clip.
    Clipped(f64),
}

/// Log-average luminance of a picture, over its finite pixels; 0 for a black or an empty one.
/// Negative luminance counts as 0.
pub fn log_average(picture: &Picture) -> f64 {
    let luminances = || {
        let all = picture.pixels.iter().map(|pixel| luminance(pixel.as_dvec3()));
        all.filter(|luminance| luminance.is_finite()).map(|luminance| luminance.max(0.0))
    };
    let count = luminances().count() as f64;
    let sum_of = |seen: &dyn Fn(f64) -> f64| luminances().map(seen).sum::<f64>() / count;
    let mean = sum_of(&|luminance| luminance);
    // Without a sun in the picture, beside which all else would be as black as δ.
    let ordinary = settled(mean, |bound| {
        let others = sum_of(&|luminance| if luminance > bound { 0.0 } else { luminance });
        (others, sum_of(&|luminance| f64::from(u8::from(luminance > bound))))
    });
    let delta = DELTA * if ordinary > 0.0 { ordinary } else { mean };
    // An empty picture's mean is 0/0, which fails the test as well.
    if delta > 0.0 {
        (luminances().map(|luminance| (delta + luminance).ln()).sum::<f64>() / count).exp()
    } else {
        0.0
    }
}

/// Exposure that brings the picture's log-average luminance to `key` before compression. A black
/// picture has no log-average: every exposure shows it black, and 0 is taken.
pub fn exposure(picture: &Picture, key: f64) -> Exposure {
    let average = log_average(picture);
    Exposure::Photographic(if average > 0.0 { key / average } else { 0.0 })
}

/// The exposure of a scene's picture: its fixed one, or as its operator derives it.
pub fn exposure_of(tone_map: &ToneMap, picture: &Picture) -> Exposure {
    match (tone_map.operator, tone_map.exposure) {
        (Operator::Photographic, Some(fixed)) => Exposure::Photographic(fixed),
        (Operator::Photographic, None) => exposure(picture, tone_map.key),
        (Operator::None, fixed) => Exposure::Clipped(fixed.unwrap_or(1.0)),
    }
}

/// Linear display value, each channel 0 to 1, of a pixel's radiance.
///
/// A saturated colour's strongest channel can exceed 1 and clips, as on a display. An infinite
/// channel is white at its limit, 1; negative and NaN ones are 0.
pub fn apply(exposure: Exposure, radiance: Vec3) -> Vec3 {
    let color = radiance.as_dvec3();
    let scaled = match exposure {
        Exposure::Clipped(scale) => scale * color,
        Exposure::Photographic(scale) => {
            // Ld/Lw = scale / (1 + scale Lw); written so, nothing is divided by a black pixel.
            let finite = color.map(|channel| if channel.is_finite() { channel } else { 0.0 });
            let compressed = finite * (scale / (1.0 + scale * luminance(finite).max(0.0)));
            DVec3::select(color.cmpeq(DVec3::INFINITY), DVec3::INFINITY, compressed)
        }
    };
    // NaN is not over 0, so that it becomes 0.
    scaled.map(|channel| if channel > 0.0 { channel.min(1.0) } else { 0.0 }).as_vec3()
}

/// Every pixel of a picture by [`apply`].
pub fn display(exposure: Exposure, picture: &Picture) -> Picture {
    let pixels = picture.pixels.iter().map(|&pixel| apply(exposure, pixel)).collect();
    Picture { pixels, ..*picture }
}
