//! The environment's levels: means over solid angles that are known in closed form.

use std::f64::consts::{PI, TAU};

use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::environment::levels::levels;

/// Radiance 1 + y. Over a belt of the sphere between two parallels its mean is that of its values at
/// both (Archimedes: the belt's area goes by its height).
#[test]
fn a_ramp_of_latitude_has_the_means_of_its_belts() {
    let (width, height) = (64u32, 32u32);
    let mean = |row: f64, rows: f64| {
        let at = |row: f64| (PI * row / f64::from(height)).cos();
        1.0 + 0.5 * (at(row) + at(row + rows))
    };
    let texels = (0..width * height)
        .map(|at| Vec3::splat(mean(f64::from(at / width), 1.0) as f32))
        .collect();
    let ramp = Environment::from_texels("ramp", width, height, texels).expect("an image");
    let chain = levels(&ramp);
    assert_eq!(chain.len(), 6, "down to a single row");
    for (number, level) in chain.iter().enumerate() {
        let rows = f64::from(height / level.height);
        for (at, texel) in level.texels.iter().enumerate() {
            let row = at as u32 / level.width;
            let expected = mean(f64::from(row) * rows, rows);
            let off = (f64::from(texel.x) - expected).abs();
            assert!(off < 3e-6, "level {number}, row {row}: {} for {expected}", texel.x);
        }
    }
    // The control: without the weight by solid angle the upper half's mean would be 1 + 2 / π.
    assert!((mean(0.0, 16.0) - 1.5).abs() < 1e-12);
}

/// One column is lit. A texel of the next level is as wide on the sphere in every row: of the columns that
/// it averages the lit one is a part, the smaller the nearer the pole.
#[test]
fn a_lit_column_is_spread_to_the_same_width_everywhere() {
    let (width, height) = (64u32, 32u32);
    let texels =
        (0..width * height).map(|at| Vec3::splat(f32::from(u8::from(at % width == 21)))).collect();
    let column = Environment::from_texels("column", width, height, texels).expect("an image");
    let level = &levels(&column)[1];
    for row in 0..level.height {
        let sine = (PI * (f64::from(row) + 0.5) / f64::from(level.height)).sin();
        let reach = (2.0 / sine).min(f64::from(width));
        let texels = &level.texels[(row * level.width) as usize..][..level.width as usize];
        // Texels 10 holds columns 20 and 21; all of column 21 is within its reach.
        let found = f64::from(texels[10].x);
        assert!((found * reach - 1.0).abs() < 1e-5, "row {row}: {found}, 1 / {reach}");
        let total: f64 = texels.iter().map(|texel| f64::from(texel.x)).sum();
        assert!((total - 0.5).abs() < 1.0 / reach + 1e-5, "row {row}: {total} in all");
    }
}

/// The mean over the sphere is that of the image, weighted by solid angle.
#[test]
fn the_mean_luminance_is_that_of_the_sphere() {
    let (width, height) = (128u32, 64u32);
    let texels = (0..width * height).map(|at| {
        let polar = PI * (f64::from(at / width) + 0.5) / f64::from(height);
        let longitude = TAU * (f64::from(at % width) + 0.5) / f64::from(width);
        Vec3::splat((1.0 + polar.cos().powi(2) + 0.5 * longitude.cos()) as f32)
    });
    let sky = Environment::from_texels("squares", width, height, texels.collect());
    // The mean of y² over the sphere is 1/3, that of the wave nothing.
    let mean = sky.expect("an image").mean_luminance();
    assert!((mean / (4.0 / 3.0) - 1.0).abs() < 1e-3, "{mean}");
}
