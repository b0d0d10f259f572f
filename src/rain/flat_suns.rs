//! What falling drops that are flattened show of a small bright source, beside what spheres show.
//!
//! A far drop is too small to show its shape, but a flattened one sends a bare sun's light elsewhere: of one 51° from where
//! the camera looks a drop of 3 mm shows half as much as a sphere, one of 6 mm a third. How much depends on the drop's
//! size, on both elevations and on the azimuth between. `assets/flat-suns.png` has it, as means over cones of 5°
//! (`examples/flat_suns.rs` makes the file, by rays). Where flattened rain shows less than its spheres would, it has a part
//! of their light, with the colours of their bows; where it shows more, the rest besides, which has the source's colour.
//!
//! Error: of rain before a dim sky up to 5 % in eight of ten directions, 10 % in the worst, in the mean over cones of 12°,
//! where spheres show up to 31 % too much or 77 % too little (`tests/drawn/flat_suns.rs`). The file is for water in air; drops
//! of another index are drawn by it, too.

use std::f64::consts::PI;

use crate::rain::law::Law;
use crate::rain::shape::{Halves, SMALLEST_FLATTENED};

/// Elevations of a source, elevations of the camera's direction, from straight down to straight up, and azimuths between the
/// two from 0 to a half turn.
pub const ANGLES: usize = crate::abi::FLAT_SUN_ANGLES as usize;

/// Diameters in mm of the file's drops, of which the first is a sphere.
pub const DIAMETERS: [f64; 5] = [SMALLEST_FLATTENED, 2.0, 3.0, 4.0, 6.0];

/// A row a diameter and elevation of the source, a column an elevation and azimuth of the camera's direction.
const FILE: &[u8] = include_bytes!("../../assets/flat-suns.png");

/// In the file: what a drop shows that sends as much of the light in every direction; and twice as much.
const EVEN: f64 = 128.0;
const OCTAVE: f64 = 16.0;

/// Sizes of a rain's drops that block as much as each other.
const SIZES: u32 = 32;

/// Mean radiance of a drop, for an irradiance of 1, as the file has it: in steps of 4 %.
pub fn byte_of(shown: f64) -> u8 {
    (EVEN + OCTAVE * (4.0 * PI * shown).log2()).round().clamp(0.0, 255.0) as u8
}

fn shown_of(byte: u8) -> f64 {
    ((f64::from(byte) - EVEN) / OCTAVE).exp2() / (4.0 * PI)
}

/// For the drops of a law together, by elevation of the source, elevation of the camera's direction and azimuth: the part of
/// spheres' light that is shown, and what is shown besides, over the source's irradiance. First of the drops that are a
/// medium, then of those that are shown one by one: nearer than `one_by_one` for each millimetre, of a rain that ends at
/// `extent`, both in one unit.
pub(crate) fn of_law(law: &Law, one_by_one: f64, extent: f64) -> Vec<[f32; 4]> {
    let image = image::load_from_memory(FILE).expect("a PNG").into_luma8();
    let shown: Vec<f64> = image.as_raw().iter().map(|byte| shown_of(*byte)).collect();
    // Of all that drops of a size block, the part by those that are shown one by one, times a factor.
    let is_endless = extent == f64::INFINITY;
    let near = |mm: f64| if is_endless { mm } else { (one_by_one * mm / extent).min(1.0) };
    let far = |mm: f64| if is_endless { 1.0 } else { 1.0 - near(mm) };
    let [far, near] = [of_drops(law, far, &shown), of_drops(law, near, &shown)];
    let beside = |flat: f64, sphere: f64| [(flat / sphere).min(1.0), (flat - sphere).max(0.0)];
    let together = far.into_iter().zip(near).zip(&shown).map(|((far, near), sphere)| {
        let [[a, b], [c, d]] = [far, near].map(|flat| beside(flat, *sphere));
        [a, b, c, d].map(|value| value as f32)
    });
    together.collect()
}

/// Of drops of which so great a part is meant, by diameter, by what single ones have `shown`.
fn of_drops(law: &Law, part: impl Fn(f64) -> f64, shown: &[f64]) -> Vec<f64> {
    let sizes: Vec<_> = (0..SIZES)
        .map(|size| law.quantile(2.0, (f64::from(size) + 0.5) / f64::from(SIZES)))
        // No size is left out whole, so that there is a mean even of no drops.
        .map(|diameter| (diameter, part(diameter).max(1e-30), Halves::of_diameter(diameter)))
        .collect();
    // Of what is blocked, by elevation of the camera's direction, the part that each of the file's drops stands for.
    let parts: Vec<_> = (0..ANGLES)
        .map(|number| {
            let elevation = PI * (number as f64 / (ANGLES - 1) as f64 - 0.5);
            let mut parts = [0.0; DIAMETERS.len()];
            for (diameter, part, halves) in &sizes {
                let above = DIAMETERS.partition_point(|of| of <= diameter);
                let above = above.clamp(1, DIAMETERS.len() - 1);
                let [from, to] = [DIAMETERS[above - 1], DIAMETERS[above]];
                let share = ((diameter - from) / (to - from)).clamp(0.0, 1.0);
                let outline = part * halves.outline_area(elevation.sin());
                parts[above - 1] += (1.0 - share) * outline;
                parts[above] += share * outline;
            }
            let all = parts.iter().sum::<f64>();
            parts.map(|part| part / all)
        })
        .collect();
    let all = ANGLES.pow(3);
    let of_direction = |at: usize| {
        let parts = parts[at / ANGLES % ANGLES].iter().enumerate();
        parts.map(|(number, part)| part * shown[number * all + at]).sum()
    };
    (0..all).map(of_direction).collect()
}
