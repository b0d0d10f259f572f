//! What loads: formats, layers, orientation, and what is mended on the way.

use exr::prelude::*;
use glam::{DVec3, Vec3, vec3};
use raindrops::environment::Environment;
use raindrops::picture::{Picture, srgb_byte};
use raindrops::scene::EnvironmentChoice;

use crate::files::{self, COMPRESSIONS, Folder, HEIGHT, WIDTH, radiance};

/// Largest difference to the test picture, relative to its radiance.
fn largest_error(environment: &Environment) -> f32 {
    assert_eq!((environment.width(), environment.height()), (WIDTH as u32, HEIGHT as u32));
    environment
        .texels()
        .iter()
        .enumerate()
        .map(|(at, texel)| {
            let expected = radiance(at % WIDTH, at / WIDTH);
            ((*texel - expected) / expected).abs().max_element()
        })
        .fold(0.0, f32::max)
}

#[test]
fn every_compression_loads() {
    let folder = Folder::new();
    for compression in COMPRESSIONS {
        for (bytes, lossless) in [
            (files::exr_half(compression), 6e-4),
            (files::exr_float(compression, Blocks::ScanLines), 1e-7),
            (files::exr_float(compression, Blocks::Tiles(Vec2(8, 8))), 1e-7),
        ] {
            let environment = folder.load("any.exr", &bytes).expect("a sound file");
            // PXR24 keeps 24 bits of a float32, B44 about 6 bits of differences in a block.
            let bound = match compression {
                Compression::PXR24 => 6e-4_f32,
                Compression::B44 | Compression::B44A => 0.1,
                _ => lossless,
            };
            let error = largest_error(&environment);
            assert!(error <= bound, "{compression:?}: error {error} over {bound}");
            assert!(environment.mended().is_nothing(), "{compression:?}");
            assert_eq!(environment.name(), "any");
        }
    }
}

/// The cosine compressions: OpenEXR's files, within what its quantisation leaves.
#[test]
fn dwa_files_load() {
    for (name, bytes) in files::DWA {
        let environment = Environment::from_bytes(name, bytes).expect("a sound file");
        let error = largest_error(&environment);
        println!("{name}: {error}");
        assert!(error > 1e-4 && error < 0.1, "{name}: error {error}");
    }
}

#[test]
fn real_dwab_files_load() {
    for path in files::real_environments() {
        let environment = Environment::load(&path).expect("a real environment");
        println!("{}: {}", environment.name(), environment.mended());
        assert_eq!((environment.width(), environment.height()), (1024, 512));
        assert!(environment.texels().iter().all(|t| t.is_finite() && t.min_element() >= 0.0));
        assert!(environment.max_radiance() > 0.1);
        assert_eq!(environment.mended().non_finite, 0);
    }
}

#[test]
fn radiance_hdr_loads_with_either_signature() {
    let folder = Folder::new();
    let bytes = files::hdr();
    // Eight bits of mantissa for the largest component; the smallest is at least a 20th of it.
    assert!(largest_error(&folder.load("a.hdr", &bytes).expect("a sound file")) < 0.08);
    let mut old = b"#?RGBE".to_vec();
    old.extend_from_slice(bytes.strip_prefix(b"#?RADIANCE").expect("the signature"));
    // The format is told by content: a wrong extension does not matter.
    let environment = folder.load("old.png", &old).expect("a sound file");
    assert!(largest_error(&environment) < 0.08);
}

#[test]
fn png_and_jpeg_are_decoded_from_srgb() {
    let folder = Folder::new();
    for (format, bound) in [(image::ImageFormat::Png, 1e-6), (image::ImageFormat::Jpeg, 0.06)] {
        let environment = folder.load("any.exr", &files::display(format)).expect("a sound file");
        for (at, texel) in environment.texels().iter().enumerate() {
            let byte = [(at % WIDTH) as f64 * 8.0, (at / WIDTH) as f64 * 16.0, 128.0];
            for (value, byte) in texel.to_array().into_iter().zip(byte) {
                let display = byte / 255.0;
                let linear = if display <= 0.04045 {
                    display / 12.92
                } else {
                    ((display + 0.055) / 1.055).powf(2.4)
                };
                assert!((f64::from(value) - linear).abs() <= bound, "{format:?} {value} {linear}");
            }
        }
    }
}

/// A photograph stands as the camera was held.
#[test]
fn pictures_are_turned_as_they_say() {
    let folder = Folder::new();
    let level = folder.load("level.jpg", &files::turned(1)).expect("a sound file");
    let over = folder.load("over.jpg", &files::turned(3)).expect("a sound file");
    let reversed: Vec<_> = over.texels().iter().rev().copied().collect();
    assert!(level.texels() == reversed);
    let path = folder.path("left.jpg");
    std::fs::write(&path, files::turned(6)).expect("a file");
    let upright = Picture::read(&path).expect("a picture");
    assert_eq!((upright.width as usize, upright.height as usize), (HEIGHT, WIDTH));
    for (at, pixel) in upright.pixels.iter().enumerate() {
        let lying = (HEIGHT - 1 - at % HEIGHT) * WIDTH + at / HEIGHT;
        assert!((*pixel - level.texels()[lying]).abs().max_element() < 1e-5, "pixel {at}");
    }
}

#[test]
fn sixteen_bit_grey_and_transparent_png_load() {
    let folder = Folder::new();
    let path = folder.path("grey.png");
    image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(4, 2, image::Luma([u16::MAX]))
        .save(&path)
        .expect("a file");
    assert_eq!(Environment::load(&path).expect("a sound file").texels(), [Vec3::ONE; 8]);
    let path = folder.path("transparent.png");
    image::RgbaImage::from_pixel(4, 2, image::Rgba([255, 0, 255, 0])).save(&path).expect("a file");
    // Alpha is left out, not multiplied in.
    let expected = [vec3(1.0, 0.0, 1.0); 8];
    assert_eq!(Environment::load(&path).expect("a sound file").texels(), expected);
}

#[test]
fn layers_groups_luminance_and_integers_are_found() {
    let folder = Folder::new();
    let zip = Compression::ZIP16;
    let load = |channels: &[files::NamedChannel<f32>]| {
        folder.load("a.exr", &files::exr((4, 2), zip, Blocks::ScanLines, channels))
    };
    let flat = |value: f32| move |_: usize, _: usize| value;

    let luminance = load(&[("Y", &flat(3.0)), ("A", &flat(1.0))]).expect("luminance");
    assert_eq!(luminance.texels(), [Vec3::splat(3.0); 8]);
    let group = load(&[
        ("Depth.Z", &flat(9.0)),
        ("View.Combined.B", &flat(3.0)),
        ("View.Combined.G", &flat(2.0)),
        ("View.Combined.R", &flat(1.0)),
    ]);
    assert_eq!(group.expect("a group").texels(), [vec3(1.0, 2.0, 3.0); 8]);
    let bright = load(&[("R", &flat(1e9)), ("G", &flat(2e-30)), ("B", &flat(0.0))]);
    let bright = bright.expect("an extreme range");
    assert_eq!(bright.texels(), [vec3(1e9, 2e-30, 0.0); 8], "values stay as they are");
    assert_eq!(bright.max_radiance(), 1e9);

    let integer = files::exr::<u32>(
        (4, 2),
        zip,
        Blocks::ScanLines,
        &[("R", &|x, _| x as u32), ("G", &|_, y| y as u32), ("B", &|_, _| 7)],
    );
    let integer = folder.load("u32.exr", &integer).expect("integers");
    assert_eq!(integer.texels()[6], vec3(2.0, 1.0, 7.0));

    // Colours in the second layer only.
    let layer = |name: &str, channels: &[(&str, f32)]| {
        let list = channels
            .iter()
            .map(|(name, value)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; 8])));
        let channels = AnyChannels::sort(list.collect());
        Layer::new((4, 2), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, channels)
    };
    let layers = vec![
        layer("depth", &[("Z", 1.0), ("Y", 8.0)]),
        layer("beauty", &[("R", 4.0), ("G", 5.0), ("B", 6.0)]),
    ];
    let window = IntegerBounds::from_dimensions((4, 2));
    let path = folder.path("layers.exr");
    let image = Image::from_layers(ImageAttributes::new(window), layers);
    image.write().to_file(&path).expect("a file");
    let layers = Environment::load(&path).expect("layers");
    assert_eq!(layers.texels(), [vec3(4.0, 5.0, 6.0); 8]);
}

#[test]
fn a_cropped_data_window_is_put_into_its_display_window() {
    let folder = Folder::new();
    let path = folder.path("cropped.exr");
    let channels =
        SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32 + 1.0, at.y() as f32, 0.5_f32));
    let attributes = LayerAttributes::named("crop").with_position(Vec2(12, 21));
    let layer = Layer::new((3, 2), attributes, Encoding::FAST_LOSSLESS, channels);
    let window = IntegerBounds::new((10, 20), (8, 4));
    Image::new(ImageAttributes::new(window), layer).write().to_file(&path).expect("a file");
    let environment = Environment::load(&path).expect("a cropped file");
    assert_eq!((environment.width(), environment.height()), (8, 4));
    assert_eq!(environment.texels()[8 + 2], vec3(1.0, 0.0, 0.5));
    assert_eq!(environment.texels()[16 + 4], vec3(3.0, 1.0, 0.5));
    assert_eq!(environment.texels()[0], Vec3::ZERO);
    assert_eq!(environment.mended().missing, 32 - 6);
    assert_eq!(environment.mended().to_string(), "texels mended: 26 missing (black)");
}

#[test]
fn directions_fall_on_the_texels_of_the_convention() {
    let folder = Folder::new();
    let (left, right) = (WIDTH / 4, WIDTH * 3 / 4);
    let middle = [HEIGHT / 2 - 1, HEIGHT / 2];
    let all: Vec<usize> = (0..WIDTH).collect();
    // An axis lies on a corner between texels, so those around it are lit.
    let cases: [(DVec3, Vec<usize>, &[usize]); 6] = [
        (DVec3::NEG_Z, vec![WIDTH / 2 - 1, WIDTH / 2], &middle),
        (DVec3::X, vec![right - 1, right], &middle),
        (DVec3::Z, vec![WIDTH - 1, 0], &middle),
        (DVec3::NEG_X, vec![left - 1, left], &middle),
        (DVec3::Y, all.clone(), &[0]),
        (DVec3::NEG_Y, all, &[HEIGHT - 1]),
    ];
    for (axis, columns, rows) in &cases {
        let lit = |x, y| f32::from(u8::from(columns.contains(&x) && rows.contains(&y)));
        let bytes = files::exr::<f32>(
            (WIDTH, HEIGHT),
            Compression::ZIP16,
            Blocks::ScanLines,
            &[("R", &lit), ("G", &lit), ("B", &lit)],
        );
        let environment = folder.load("axis.exr", &bytes).expect("a sound file");
        for (direction, ..) in &cases {
            let expected = if direction == axis { DVec3::ONE } else { DVec3::ZERO };
            let found = environment.radiance(*direction);
            assert!((found - expected).length() < 1e-9, "{axis} lit, {direction}: {found}");
        }
    }
    // One texel, at its centre: three eighths of a turn right of -z, an eighth above the horizon.
    let mut texels = vec![Vec3::ZERO; 8 * 4];
    texels[8 + 7] = Vec3::ONE;
    let one = Environment::from_texels("one", 8, 4, texels).expect("texels");
    let (azimuth, elevation) = (157.5_f64.to_radians(), 22.5_f64.to_radians());
    let toward = DVec3::new(
        azimuth.sin() * elevation.cos(),
        elevation.sin(),
        -azimuth.cos() * elevation.cos(),
    );
    assert!((one.radiance(toward) - DVec3::ONE).length() < 1e-9);
}

#[test]
fn the_seam_is_bilinear() {
    let mut texels = vec![Vec3::ZERO; 8];
    for row in 0..2 {
        texels[row * 4] = Vec3::splat(1.0);
        texels[row * 4 + 3] = Vec3::splat(3.0);
    }
    let environment = Environment::from_texels("seam", 4, 2, texels).expect("texels");
    // +z is half way between the last column and the first.
    assert!((environment.radiance(DVec3::Z).x - 2.0).abs() < 1e-12);
    for (nudge, expected) in [(0.25, 2.5), (-0.25, 1.5)] {
        // A quarter of a texel, a texel being a quarter turn.
        let angle: f64 = nudge * std::f64::consts::FRAC_PI_2;
        let found = environment.radiance(DVec3::new(angle.sin(), 0.0, angle.cos())).x;
        assert!((found - expected).abs() < 1e-9, "{nudge}: {found}");
    }
    assert!(environment.radiance(DVec3::new(-0.0, 0.0, 1.0)).is_finite());
}

#[test]
fn negative_and_non_finite_texels_are_mended_and_counted() {
    let mut texels = vec![Vec3::splat(2.0); 32];
    texels[3] = vec3(-0.003, 1.0, 5.0);
    texels[8] = vec3(f32::NAN, 1.0, 1.0);
    texels[15] = vec3(1.0, f32::INFINITY, -1.0);
    texels[22] = Vec3::splat(f32::NEG_INFINITY);
    texels[31] = Vec3::splat(1e9);
    let environment = Environment::from_texels("mended", 8, 4, texels).expect("texels");
    let mended = environment.mended();
    assert_eq!((mended.negative, mended.non_finite, mended.missing), (2, 2, 0));
    assert_eq!(
        mended.to_string(),
        "texels mended: 2 negative (set to 0), 2 NaN (set to the mean of the neighbours), 1 infinite (set to 1000000000)"
    );
    assert_eq!(environment.texels()[3], vec3(0.0, 1.0, 5.0));
    // What has overflowed is the brightest finite value, also for its neighbour 8 across the seam.
    assert_eq!(environment.texels()[15], vec3(1.0, 1e9, 0.0));
    assert!((environment.texels()[8].y - (7.0 * 2.0 + 1e9) / 8.0).abs() < 100.0);
    assert!((environment.texels()[22].x - (6.0 * 2.0 + 1.0 + 1e9) / 8.0).abs() < 100.0);
    assert_eq!(environment.max_radiance(), 1e9);
    assert_eq!(raindrops::environment::Mended::default().to_string(), "no texel had to be mended");
}

#[test]
fn a_hole_without_finite_neighbours_is_black_and_huge_neighbours_do_not_overflow() {
    let mut texels = vec![Vec3::NAN; 32];
    texels[0] = Vec3::splat(f32::MAX);
    texels[1] = Vec3::splat(f32::MAX);
    let environment = Environment::from_texels("holes", 8, 4, texels).expect("texels");
    assert_eq!(environment.mended().non_finite, 30);
    assert_eq!(environment.texels()[8], Vec3::splat(f32::MAX));
    assert_eq!(environment.texels()[28], Vec3::ZERO);
}

#[test]
fn a_scene_s_choice_is_opened() {
    let folder = Folder::new();
    let file = Some(folder.write("my sky.v2.exr", &files::exr_half(Compression::ZIP16)));
    let opened = Environment::open(&EnvironmentChoice { file, ..EnvironmentChoice::default() })
        .expect("a file");
    assert_eq!(opened.name(), "my sky.v2");
    let constant = |radiance| {
        Environment::open(&EnvironmentChoice {
            radiance: Some(radiance),
            ..EnvironmentChoice::default()
        })
    };
    let white = constant(Vec3::ONE).expect("a furnace");
    assert_eq!((white.name(), white.radiance(DVec3::Y)), ("constant 1", DVec3::ONE));
    assert_eq!(constant(vec3(1.0, 0.5, 0.0)).expect("a colour").name(), "constant 1 0.5 0");
    assert!(constant(vec3(1.0, -0.5, 0.0)).is_err());
    assert!(constant(vec3(f32::NAN, 0.5, 0.0)).is_err());
    let sky = Environment::open(&EnvironmentChoice::default()).expect("the bundled sky");
    assert_eq!(sky.name(), "sky (bundled)");
}

/// Bytes are looked up; the curve itself says the same, at both sides of each step and everywhere else.
#[test]
fn bytes_are_those_of_the_srgb_curve() {
    let by_curve = |linear: f64| {
        let encoded = match linear <= 0.003_130_8 {
            true => 12.92 * linear,
            false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
        };
        255.0 * encoded
    };
    for step in 0..=2_000_000u32 {
        let linear = f64::from(step) / 2e6;
        let (found, exact) = (srgb_byte(linear as f32), by_curve(linear));
        // In float32 a value at half a byte may be either.
        assert!((f64::from(found) - exact).abs() < 0.5 + 1e-4, "{linear}: {found}, {exact}");
    }
    let odd = [-1.0, f32::NAN, f32::NEG_INFINITY, 0.0, 1.0, 2.0, f32::INFINITY];
    assert_eq!(odd.map(srgb_byte), [0, 0, 0, 0, 255, 255, 255]);
}
