//! The computed sky: the committed file is what the program computes, and its light is right.

use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use raindrops::environment::Environment;
use raindrops::environment::sky;

use crate::files::Folder;

/// Most bytes of the committed file: every copy of the program holds it.
const MAX_BYTES: u64 = 600_000;

/// Solid angle of a texel in steradians.
fn solid_angle(width: u32, row: u32) -> f64 {
    let step = 2.0 * PI / f64::from(width);
    step * ((f64::from(row) * step).cos() - (f64::from(row + 1) * step).cos())
}

#[test]
fn the_committed_sky_is_the_computed_one() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/sky.exr");
    assert!(std::fs::metadata(&file).expect("the file").len() < MAX_BYTES);
    let bundled = Environment::bundled().expect("the bundled sky");
    let computed = sky::picture(sky::BUNDLED_WIDTH, sky::Sun::default());
    assert_eq!((bundled.width(), bundled.height()), (computed.width, computed.height));
    assert!(bundled.mended().is_nothing());
    // Half a step of float16 (2^-11), and as much again where sin and cos differ by platform.
    for (at, (stored, computed)) in bundled.texels().iter().zip(&computed.pixels).enumerate() {
        let error = (*stored - *computed).abs() / computed.max(glam::Vec3::splat(1e-4));
        assert!(error.max_element() <= 1.0 / 1024.0, "texel {at}: {stored} is not {computed}");
    }
}

#[test]
fn the_sun_is_brightest_and_its_irradiance_does_not_depend_on_the_width() {
    for width in [64, 150, 400] {
        let picture = sky::picture(width, sky::Sun::default());
        assert!(picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
        // Fits into float16.
        assert!(picture.pixels.iter().all(|p| p.max_element() < 65_504.0), "width {width}");
        let direction = |at: u32| {
            let azimuth = (f64::from(at % width) + 0.5) / f64::from(width) * 2.0 * PI - PI;
            let polar = (f64::from(at / width) + 0.5) / f64::from(picture.height) * PI;
            DVec3::new(azimuth.sin() * polar.sin(), polar.cos(), -azimuth.cos() * polar.sin())
        };
        let mut irradiance = DVec3::ZERO;
        let mut brightest = (0.0, 0);
        let reach = (2.0_f64 * 2.0 * PI / f64::from(width)).max(0.01).cos();
        for (at, pixel) in picture.pixels.iter().enumerate() {
            let at = at as u32;
            if pixel.x > brightest.0 {
                brightest = (pixel.x, at);
            }
            if direction(at).dot(sky::Sun::default().direction()) > reach {
                irradiance += pixel.as_dvec3() * solid_angle(width, at / width);
            }
        }
        let error = (irradiance / sky::Sun::default().irradiance() - 1.0).abs().max_element();
        // The sky around the sun adds its part, up to 0.4 times the few coarse texels it is.
        let bound = 0.005 + 0.4 * PI * (2.0 * 2.0 * PI / f64::from(width)).powi(2);
        assert!(error < bound, "width {width}: {error} over {bound}");
        let angle = direction(brightest.1).dot(sky::Sun::default().direction()).acos();
        // A texel's diagonal, or half of it and the sun's radius.
        assert!(angle < 2.0 * PI / f64::from(width) + 0.005, "width {width}: {angle} off the sun");
    }
}

#[test]
fn the_default_view_has_sky_above_darker_ground_and_no_sun() {
    let bundled = Environment::bundled().expect("the bundled sky");
    let mut means = [0.0; 2];
    let count = 64;
    for at in 0..count * count {
        let (x, y) = (at % count, at / count);
        let place = |i: i32| f64::from(2 * i + 1) / f64::from(count) - 1.0;
        let radiance = bundled.radiance(DVec3::new(place(x), -place(y), -1.0).normalize());
        assert!(radiance.max_element() < 5.0, "the view is blown out: {radiance}");
        means[usize::from(y >= count / 2)] += radiance.y / f64::from(count * count / 2);
    }
    let [above, below] = means;
    assert!((0.1..1.0).contains(&above) && below < 0.7 * above, "above {above}, below {below}");
}

#[test]
fn the_command_writes_a_sky_that_loads() {
    let folder = Folder::new();
    let path = folder.path("out.exr");
    let run = |width: &str| {
        Command::new(env!("CARGO_BIN_EXE_raindrops"))
            .args(["sky", "--width", width, "-o"])
            .arg(&path)
            .output()
            .expect("the command starts")
    };
    assert_eq!(run("17").status.code(), Some(2), "an odd width");
    assert!(!path.exists());
    let output = run("64");
    assert!(output.status.success() && output.stdout.is_empty());
    let sky = Environment::load(&path).expect("what the command wrote");
    assert_eq!((sky.width(), sky.height()), (64, 32));
}
