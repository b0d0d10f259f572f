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
use std::sync::LazyLock;

#[cfg(doc)]
use crate::rain::flat_sizes::Parted;
use crate::rain::flat_sizes::Shares;

/// Elevations of a source, elevations of the camera's direction, from straight down to straight up, and azimuths between the
/// two from 0 to a half turn.
pub const ANGLES: usize = crate::abi::FLAT_SUN_ANGLES as usize;

/// A row for each of [`crate::rain::flat_sizes::DIAMETERS`] and elevation of the source, a column an elevation and azimuth of the camera's direction.
const FILE: &[u8] = include_bytes!("../../assets/flat-suns.png");

/// In the file: what a drop shows that sends as much of the light in every direction; and twice as much.
const EVEN: f64 = 128.0;
const OCTAVE: f64 = 16.0;

/// Mean radiance of a drop, for an irradiance of 1, as the file has it: in steps of 4 %.
pub fn byte_of(shown: f64) -> u8 {
    (EVEN + OCTAVE * (4.0 * PI * shown).log2()).round().clamp(0.0, 255.0) as u8
}

/// The mean radiances of the file.
static SHOWN: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let image = image::load_from_memory(FILE).expect("a PNG").into_luma8();
    let shown_of = |byte: u8| ((f64::from(byte) - EVEN) / OCTAVE).exp2() / (4.0 * PI);
    image.into_raw().into_iter().map(shown_of).collect()
});

/// For the drops of a rain together, by elevation of the source, elevation of the camera's direction and azimuth: the part of
/// spheres' light that is shown, and what is shown besides, over the source's irradiance. First of the drops that are a
/// medium, then of those that are shown one by one: their [`Parted::shares_of_suns`].
pub(crate) fn of_rain(shares: &[Shares; 2]) -> Vec<[f32; 4]> {
    let shown = &*SHOWN;
    let all = ANGLES.pow(3);
    let of_drops = |shares: &Shares, at: usize| {
        let shares = shares[at / ANGLES % ANGLES].iter().enumerate();
        shares.map(|(number, share)| share * shown[number * all + at]).sum::<f64>()
    };
    let beside = |flat: f64, sphere: f64| [(flat / sphere).min(1.0), (flat - sphere).max(0.0)];
    let together = (0..all).map(|at| {
        let [far, near] = shares.each_ref().map(|shares| beside(of_drops(shares, at), shown[at]));
        [far[0], far[1], near[0], near[1]].map(|value| value as f32)
    });
    together.collect()
}
