//! Each metric against values found independently, and a control that must fail.

use glam::Vec3;
use raindrops::picture::flip::{PIXELS_PER_DEGREE, flip};
use raindrops::picture::metrics::{
    box_filter, compare, max_error, mean_luminance, percentile, psnr_db, rel_mse,
};
use raindrops::picture::tone_map::{DELTA, Exposure, exposure};
use raindrops::picture::{Picture, linear_of_srgb, srgb_of_linear};

fn constant(width: u32, height: u32, color: Vec3) -> Picture {
    Picture { width, height, pixels: vec![color; (width * height) as usize] }
}

/// sRGB bytes that are noise, smooth gradients and hard edges at once.
fn bytes(width: u32, height: u32, seed: u32) -> Vec<u8> {
    (0..width * height)
        .flat_map(|at| {
            let (x, y) = (at % width, at / width);
            let noise = (at ^ seed).wrapping_mul(2_654_435_761) >> 27;
            let edge = if (x / 7 + y / 11 + seed).is_multiple_of(3) { 90 } else { 0 };
            let gradient = x * 120 / width;
            [edge + noise + gradient, gradient + 2 * noise, 200 - gradient - noise]
                .map(|value| value.min(255) as u8)
        })
        .collect()
}

fn picture_of(width: u32, height: u32, bytes: &[u8]) -> Picture {
    let linear = |byte: &u8| linear_of_srgb(f32::from(*byte) / 255.0);
    let pixels = bytes
        .chunks(3)
        .map(|rgb| Vec3::new(linear(&rgb[0]), linear(&rgb[1]), linear(&rgb[2])))
        .collect();
    Picture { width, height, pixels }
}

/// The authors' own FLIP, 8-bit sRGB in.
fn published_flip(width: u32, height: u32, a: &[u8], b: &[u8]) -> Vec<f32> {
    let image = |bytes| nv_flip::FlipImageRgb8::with_data(width, height, bytes);
    nv_flip::flip(image(a), image(b), PIXELS_PER_DEGREE as f32).to_vec()
}

#[test]
fn flip_agrees_with_its_authors_code() {
    let (width, height) = (61, 43);
    let (a, b) = (bytes(width, height, 0), bytes(width, height, 1));
    let published = published_flip(width, height, &a, &b);
    let ours =
        flip(&picture_of(width, height, &a), &picture_of(width, height, &b), PIXELS_PER_DEGREE);
    let worst = ours
        .iter()
        .zip(&published)
        .map(|(ours, published)| (ours - f64::from(*published)).abs())
        .fold(0.0, f64::max);
    assert!(worst < 2e-4, "largest disagreement {worst}");
    let mean = ours.iter().sum::<f64>() / ours.len() as f64;
    assert!(mean > 0.1, "the pictures hardly differ ({mean}): nothing was tested");
    // The control: pictures that change places are another question, but one with the same answer;
    // another picture is not.
    let other = picture_of(width, height, &bytes(width, height, 2));
    let other = flip(&picture_of(width, height, &a), &other, PIXELS_PER_DEGREE);
    let apart = other.iter().zip(&published).filter(|(o, p)| (*o - f64::from(**p)).abs() > 2e-4);
    assert!(apart.count() > ours.len() / 2);
}

#[test]
fn flip_knows_equal_pictures_and_opposite_ones() {
    let (white, black) = (constant(20, 20, Vec3::ONE), constant(20, 20, Vec3::ZERO));
    assert!(flip(&white, &white, PIXELS_PER_DEGREE).iter().all(|&error| error == 0.0));
    // Black and white differ by 100 in lightness alone; green and blue by more, in closed form of
    // CIELAB, and mark the end of the scale.
    let far = flip(&white, &black, PIXELS_PER_DEGREE);
    let published = published_flip(20, 20, &[255; 1200], &[0; 1200]);
    for (ours, published) in far.iter().zip(&published) {
        assert!((ours - f64::from(*published)).abs() < 1e-4, "{ours} {published}");
        assert!((0.95..1.0).contains(ours), "{ours}");
    }
    let green_blue = flip(&constant(9, 9, Vec3::Y), &constant(9, 9, Vec3::Z), PIXELS_PER_DEGREE);
    assert!(green_blue.iter().all(|error| (error - 1.0).abs() < 1e-9));
    assert!(flip(&constant(0, 0, Vec3::Y), &constant(0, 0, Vec3::Z), 67.0).is_empty());
}

#[test]
fn rel_mse_is_the_formula() {
    // Log-average of a constant picture is (1 + δ) times its luminance.
    let floor = 0.05 * 2.0 * (1.0 + DELTA);
    let (a, b) = (constant(4, 4, Vec3::splat(2.0)), constant(4, 4, Vec3::new(2.5, 2.0, 2.0)));
    let expected = 0.25 / (4.0 + floor * floor) / 3.0;
    assert!((rel_mse(&a, &b, None) - expected).abs() < 1e-7);
    assert_eq!(rel_mse(&a, &a, None), 0.0);
    assert_ne!(rel_mse(&b, &a, None), rel_mse(&a, &b, None), "the truth's scale is meant");

    // Over a mask: only the pixels that are over 0 in it count.
    let mut half = a.clone();
    half.pixels[0] = Vec3::splat(3.0);
    let mut mask = vec![0.0; 16];
    mask[0] = 0.01;
    let whole = rel_mse(&a, &half, None);
    assert!((rel_mse(&a, &half, Some(&mask)) - 16.0 * whole).abs() < 1e-9);
    mask[0] = 0.0;
    mask[1] = 1.0;
    assert_eq!(rel_mse(&a, &half, Some(&mask)), 0.0);

    // Black truth: nothing to be relative to.
    let black = constant(4, 4, Vec3::ZERO);
    assert_eq!(rel_mse(&black, &black, None), 0.0);
    assert_eq!(rel_mse(&black, &a, None), f64::INFINITY);
}

#[test]
fn psnr_is_the_formula() {
    let shown = |srgb: f32| constant(8, 8, Vec3::splat(linear_of_srgb(srgb)));
    assert!((psnr_db(&shown(0.5), &shown(0.6)) - 20.0).abs() < 1e-4);
    assert!((psnr_db(&shown(0.5), &shown(0.51)) - 40.0).abs() < 1e-3);
    assert_eq!(psnr_db(&shown(0.5), &shown(0.5)), f64::INFINITY);
}

#[test]
fn the_largest_error_and_its_place() {
    let a = constant(5, 4, Vec3::ONE);
    let mut b = a.clone();
    b.pixels[2 * 5 + 3] = Vec3::new(1.0, 0.25, 1.5);
    assert_eq!(max_error(&a, &b, None), (0.75, (3, 2)));
    assert_eq!(max_error(&a, &a, None), (0.0, (0, 0)));
    assert_eq!(max_error(&a, &b, Some(&[0.0; 20])), (0.0, (0, 0)));
}

#[test]
fn what_is_no_number_is_an_error() {
    let a = constant(4, 4, Vec3::ONE);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut b = a.clone();
        b.pixels[5].y = bad;
        assert_eq!(max_error(&a, &b, None), (f64::INFINITY, (1, 1)));
        assert_eq!(rel_mse(&a, &b, None), f64::INFINITY);
        assert_eq!(rel_mse(&b, &a, None), f64::INFINITY);
        assert_eq!(max_error(&b, &b, None).0, 0.0);
        let comparison = compare(&a, &b, None, exposure(&a, 0.18));
        assert!(comparison.pixels.flip.is_finite() && comparison.pixels.psnr_db.is_finite());
    }
}

#[test]
fn boxes_percentiles_and_means() {
    // 10 x 9: one whole box, three parts.
    let pixels = (0..90_u8).map(|at| Vec3::splat(f32::from(at % 10))).collect();
    let boxed = box_filter(&Picture { width: 10, height: 9, pixels });
    assert_eq!((boxed.width, boxed.height), (2, 2));
    assert_eq!(boxed.pixels.iter().map(|p| p.x).collect::<Vec<_>>(), [3.5, 8.5, 3.5, 8.5]);

    let values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
    assert_eq!(percentile(&values, 0.99), 198.0);
    assert_eq!([percentile(&values, 0.0), percentile(&values, 1.0)], [1.0, 200.0]);
    assert_eq!(percentile(&[], 0.5), 0.0);
    assert!((mean_luminance(&constant(3, 3, Vec3::new(0.0, 1.0, 0.0))) - 0.7152).abs() < 1e-12);
}

#[test]
fn the_box_filter_forgives_a_glint_next_door() {
    let mut a = constant(32, 32, Vec3::splat(0.2));
    let mut b = a.clone();
    a.pixels[5 * 32 + 5] = Vec3::splat(1000.0);
    b.pixels[5 * 32 + 6] = Vec3::splat(1000.0);
    let moved = compare(&a, &b, None, exposure(&a, 0.18));
    assert!(moved.pixels.rel_mse > 10.0 && moved.boxes.rel_mse < 1e-9);
    assert!(moved.pixels.psnr_db < 40.0 && moved.boxes.psnr_db > 100.0);
    // The control: a glint that is gone is gone from the boxes, too.
    let gone = compare(&a, &constant(32, 32, Vec3::splat(0.2)), None, exposure(&a, 0.18));
    assert!(gone.boxes.rel_mse > 0.01 && gone.boxes.psnr_db < 40.0 && gone.boxes.flip > 0.01);
}

#[test]
fn the_truth_exposes_both_pictures() {
    // Twice as bright is an error, though each picture by itself would look the same.
    let (a, b) = (constant(16, 16, Vec3::splat(0.5)), constant(16, 16, Vec3::splat(1.0)));
    let comparison = compare(&a, &b, None, exposure(&a, 0.18));
    assert!(comparison.pixels.psnr_db < 20.0 && comparison.pixels.flip > 0.1);
    let same = compare(&a, &a, None, Exposure::Clipped(1.0));
    assert_eq!((same.pixels.psnr_db, same.pixels.flip), (f64::INFINITY, 0.0));
}

#[test]
fn pictures_survive_the_disk() {
    let folder = tempfile::tempdir().expect("a folder");
    let values = [Vec3::new(-1.0, 0.0, 1e-20), Vec3::new(7e4, f32::INFINITY, 0.1)];
    let picture = Picture { width: 2, height: 1, pixels: values.to_vec() };
    let path = folder.path().join("p.exr");
    picture.write_exr(&path).expect("written");
    assert_eq!(Picture::read(&path).expect("read"), picture);
    assert!(!Picture::is_display(&path).expect("read"));

    let path = folder.path().join("p.png");
    let bytes: Vec<u8> = (0..=254).collect();
    raindrops::picture::write_png(&path, 85, 1, &bytes).expect("written");
    assert!(Picture::is_display(&path).expect("read"));
    let read = Picture::read(&path).expect("read");
    let back = read.srgb();
    assert_eq!(back, bytes);
    for step in 0_u8..=255 {
        let value = f32::from(step) / 255.0;
        assert!((srgb_of_linear(linear_of_srgb(value)) - value).abs() < 1e-6);
    }

    for (name, content) in
        [("empty.exr", &[][..]), ("cut.exr", &[0x76, 0x2f, 0x31, 0x01, 2]), ("x.png", b"hi")]
    {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("written");
        let message = Picture::read(&path).expect_err("not a picture").to_string();
        assert!(message.contains(name) && !message.contains('\n'), "{message}");
    }
    assert!(Picture::read(&folder.path().join("none.exr")).is_err());
}
