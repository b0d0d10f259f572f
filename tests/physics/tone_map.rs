//! The tone map against closed forms.

use glam::Vec3;
use raindrops::picture::Picture;
use raindrops::picture::tone_map::{DELTA, Exposure, apply, display, exposure, log_average};

fn picture(pixels: Vec<Vec3>) -> Picture {
    Picture { width: pixels.len() as u32, height: 1, pixels }
}

#[test]
fn a_constant_picture_maps_to_the_key_over_one_plus_the_key() {
    for radiance in [1e-6_f32, 0.18, 1.0, 7e4] {
        let grey = picture(vec![Vec3::splat(radiance); 12]);
        for key in [0.18, 0.72] {
            // The log-average is (1 + δ) times the luminance.
            let level = key / (1.0 + DELTA);
            let expected = level / (1.0 + level);
            let shown = apply(exposure(&grey, key), grey.pixels[0]);
            assert!((f64::from(shown.y) - expected).abs() < 1e-6, "{radiance} {key} {shown}");
        }
    }
}

#[test]
fn the_log_average_is_the_geometric_mean() {
    let half = picture([vec![Vec3::splat(0.01); 50], vec![Vec3::splat(100.0); 50]].concat());
    // δ = 1e-4 of the mean, 50.005, lifts the darker half by half.
    let delta = DELTA * 50.005;
    let expected = ((0.01 + delta) * (100.0 + delta)).sqrt();
    assert!((log_average(&half) / expected - 1.0).abs() < 1e-6);
}

#[test]
fn the_unit_of_radiance_does_not_matter() {
    let some: Vec<Vec3> = (0..100_u8).map(|i| Vec3::new(1.0, 2.0, 0.5) * f32::from(i)).collect();
    let more: Vec<Vec3> = some.iter().map(|pixel| *pixel * 1024.0).collect();
    let (some, more) = (picture(some), picture(more));
    let (a, b) = (display(exposure(&some, 0.18), &some), display(exposure(&more, 0.18), &more));
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        assert!((*a - *b).abs().max_element() < 1e-6);
    }
}

#[test]
fn black_stays_black_and_infinity_becomes_white() {
    let black = picture(vec![Vec3::ZERO; 4]);
    assert_eq!(log_average(&black), 0.0);
    assert_eq!(display(exposure(&black, 0.18), &black), black);
    assert_eq!(log_average(&picture(Vec::new())), 0.0);

    let sun = picture(vec![Vec3::INFINITY, Vec3::ONE, Vec3::NAN, -Vec3::ONE]);
    let exposure = exposure(&sun, 0.18);
    assert!(matches!(exposure, Exposure::Photographic(scale) if scale.is_finite() && scale > 0.0));
    let shown = display(exposure, &sun);
    assert_eq!(shown.pixels[0], Vec3::ONE);
    assert_eq!([shown.pixels[2], shown.pixels[3]], [Vec3::ZERO, Vec3::ZERO]);
    assert!(shown.pixels[1].x > 0.0 && shown.pixels[1].x < 1.0);
    // Finite but huge: arbitrarily near to white, never over.
    assert!(apply(exposure, Vec3::splat(f32::MAX)).x > 0.9999);
    assert_eq!(
        apply(Exposure::Clipped(1.0), Vec3::new(0.5, 2.0, f32::NAN)),
        Vec3::new(0.5, 1.0, 0.0)
    );
}

#[test]
fn colours_keep_their_hue() {
    let exposure = Exposure::Photographic(2.0);
    let color = Vec3::new(0.3, 0.2, 0.1);
    let shown = apply(exposure, color);
    assert!((shown / shown.x - color / color.x).abs().max_element() < 1e-6);
}
