//! Files as other programs write them: what is read of each, and what is refused. `tests/data/cases` has a folder a
//! kind; the README in each has the right values.

use std::path::{Path, PathBuf};

use exr::prelude::{AttributeValue, ImageAttributes, IntegerBounds, Text, WritableImage, f16};
use glam::{Vec3, vec3};
use raindrops::Result;
use raindrops::environment::Environment;
use raindrops::picture::depth::SKY;
use raindrops::picture::plate::Plate;
use raindrops::picture::read::{Decoded, Request};
use raindrops::remark::{Remark, Severity};
use raindrops::scene::background::Background;
use raindrops::scene::{EnvironmentChoice, Scene};

use crate::files::Folder;
use crate::reading_depth::depth;

/// The colour that nearly all of the files hold, linear Rec. 709.
const COLOR: Vec3 = vec3(0.8, 0.3, 0.1);

pub fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases").join(name)
}

/// A file as plate, of its own size.
fn plate(name: &str, size: (u32, u32)) -> Result<Plate> {
    let background = Background { color: Some(case(name)), ..Background::default() };
    Plate::open(&background, size.0, size.1)
}

fn environment(name: &str) -> Result<Environment> {
    Environment::open(&EnvironmentChoice { file: Some(case(name)), ..EnvironmentChoice::default() })
}

/// A picture as `compare` reads it.
fn compared(name: &str) -> Result<Decoded> {
    Decoded::read(&case(name), Request::new("--layer"))
}

/// How far all pixels are from a colour, relative to it.
fn off(pixels: &[Vec3], color: Vec3) -> f32 {
    pixels.iter().map(|pixel| ((*pixel - color) / color).abs().max_element()).fold(0.0, f32::max)
}

#[track_caller]
fn is_color(name: &str, pixels: &[Vec3], color: Vec3, bound: f32) {
    let off = off(pixels, color);
    assert!(off < bound, "{name}: off by {off}, {} for {color}", pixels[0]);
}

fn pixels(plate: &Plate) -> &[Vec3] {
    &plate.color().expect("a colour").pixels
}

#[track_caller]
pub fn refusal<T>(read: Result<T>, expected: &str) {
    let said = read.err().expect("it is refused").to_string();
    assert!(said.contains(expected) && !said.contains('\n'), "{said}");
}

pub fn says(remarks: impl Iterator<Item = Remark>, severity: Severity, expected: &str) -> bool {
    let mut remarks = remarks;
    remarks.any(|remark| remark.severity == severity && remark.text.contains(expected))
}

/// A file means the same as environment, as plate and to `compare`.
#[test]
fn primaries_of_open_exr_are_converted() {
    for name in ["rec709", "aces-ap0", "xyz"] {
        let file = format!("01-exr-chromaticities/{name}.exr");
        is_color(name, environment(&file).expect("colours").texels(), COLOR, 2e-3);
        is_color(name, &compared(&file).expect("colours").picture.pixels, COLOR, 2e-3);
        let file = format!("01-exr-chromaticities/plate-{name}.exr");
        is_color(name, pixels(&plate(&file, (64, 64)).expect("colours")), COLOR, 2e-3);
    }
}

/// A flat OpenEXR with an attribute, as a picture to compare.
fn with_attribute(color: Vec3, set: impl Fn(&mut ImageAttributes)) -> Decoded {
    let folder = Folder::new();
    let channels = exr::prelude::SpecificChannels::rgb(|_: exr::math::Vec2<usize>| {
        (color.x, color.y, color.z)
    });
    let mut image = exr::prelude::Image::from_channels((4, 2), channels);
    image.attributes = ImageAttributes::new(IntegerBounds::from_dimensions((4, 2)));
    set(&mut image.attributes);
    let path = folder.path("attribute.exr");
    image.write().to_file(&path).expect("a file");
    Decoded::read(&path, Request::new("--layer")).expect("a picture")
}

/// Linear Rec. 709 (0.8, 0.3, 0.1) in AP1 and Rec. 2020 by their chromaticities and Bradford's adaptation, computed in
/// numpy.
#[test]
fn names_of_colour_spaces_are_heeded() {
    let text = |name: &'static str, value: &'static str| {
        move |attributes: &mut ImageAttributes| {
            attributes.other.insert(Text::from(name), AttributeValue::Text(Text::from(value)));
        }
    };
    let ap1 = vec3(0.597_073, 0.332_406, 0.136_345);
    for set in [text("oiio:ColorSpace", "ACEScg"), text("colorInteropID", "lin_ap1_scene")] {
        is_color("ACEScg", &with_attribute(ap1, set).picture.pixels, COLOR, 1e-3);
    }
    let rec2020 = vec3(0.605_039, 0.332_276, 0.129_077);
    let read = with_attribute(rec2020, text("colorInteropID", "lin_rec2020_scene"));
    is_color("Rec. 2020", &read.picture.pixels, COLOR, 1e-3);
    let read = with_attribute(COLOR, text("oiio:ColorSpace", "S-Log3"));
    is_color("unknown", &read.picture.pixels, COLOR, 1e-6);
    assert!(says(read.remarks.into_iter(), Severity::Warning, "'S-Log3'"));
    let read = with_attribute(COLOR, |attributes| attributes.pixel_aspect = 2.0);
    assert!(says(read.remarks.into_iter(), Severity::Warning, "2.000 times as wide as high"));
    let read = with_attribute(COLOR, |_| ());
    assert!(read.remarks.iter().all(|remark| remark.severity == Severity::Detail));
}

#[test]
fn lines_of_radiance_headers_are_heeded() {
    for name in ["plain", "exposure", "primaries", "colorcorr", "crlf"] {
        let file = format!("02-hdr-header/{name}.hdr");
        // A mantissa has eight bits.
        is_color(name, environment(&file).expect("colours").texels(), COLOR, 0.03);
        is_color(name, pixels(&plate(&file, (32, 16)).expect("colours")), COLOR, 0.03);
        is_color(name, &compared(&file).expect("colours").picture.pixels, COLOR, 0.03);
    }
    // The middle of a step: 204.5 and 76.5 of 256, and 25.5.
    let plain = environment("02-hdr-header/plain.hdr").expect("colours");
    is_color("plain", plain.texels(), vec3(204.5, 76.5, 25.5) / 256.0, 1e-6);
    // CIE XYZ 0.8, 0.3, 0.1 is out of Rec. 709's green, as sRGB's matrix says.
    let xyz = plate("02-hdr-header/xyze.hdr", (32, 16)).expect("colours");
    is_color("xyze", pixels(&xyz), vec3(2.083, -0.208, 0.0915), 0.03);
    assert_eq!(environment("02-hdr-header/xyze.hdr").expect("colours").mended().negative, 512);
}

#[test]
fn radiance_files_stand_upright() {
    let upright = environment("02-hdr-header/orient0.hdr").expect("a panorama");
    for name in ["orient1", "orient2", "orient3"] {
        let other = environment(&format!("02-hdr-header/{name}.hdr")).expect("a panorama");
        assert!(other.texels() == upright.texels(), "{name}");
    }
}

#[test]
fn radiance_headers_that_say_nothing_sound_are_refused() {
    let folder = Folder::new();
    let load = |line: &str| {
        let head = format!("#?RADIANCE\n{line}\n\n-Y 1 +X 2\n");
        folder.refusal("a.hdr", &[head.as_bytes(), &[1, 2, 3, 128].repeat(2)].concat())
    };
    for (line, expected) in [
        ("EXPOSURE=0", "EXPOSURE is '0'"),
        ("EXPOSURE=much", "EXPOSURE is 'much'"),
        ("COLORCORR=1 2", "COLORCORR is '1 2'"),
        ("PRIMARIES=1 2 3", "PRIMARIES is '1 2 3'"),
        ("PRIMARIES=0.3 0.3 0.3 0.3 0.3 0.3 0.3 0.3", "primaries that span no colours"),
        ("FORMAT=16-bit", "the format 16-bit"),
    ] {
        let said = load(line);
        assert!(said.contains(expected), "{said}");
    }
}

/// CMYK and YCCK within a step of JPEG; (200, 120, 60) in sRGB.
#[test]
fn inks_are_colours() {
    let color = vec3(0.578, 0.188, 0.045);
    for name in ["cmyk-adobe", "ycck-adobe"] {
        let plate = plate(&format!("03-jpeg-cmyk-ycck/{name}.jpg"), (64, 64)).expect("a plate");
        is_color(name, pixels(&plate), color, 0.08);
        let panorama = environment(&format!("03-jpeg-cmyk-ycck/{name}-env.jpg"));
        is_color(name, panorama.expect("a panorama").texels(), color, 0.08);
    }
}

#[test]
fn colour_profiles_are_applied() {
    for (name, bound) in [
        ("display-p3.png", 0.015),
        ("display-p3.jpg", 0.03),
        ("adobe-rgb.jpg", 0.02),
        ("chrm-adobe.png", 0.01),
        ("linear-gama1.png", 0.01),
        ("srgb.png", 0.01),
    ] {
        let plate = plate(&format!("04-colour-profile/{name}"), (64, 64)).expect("a plate");
        is_color(name, pixels(&plate), COLOR, bound);
        let compared = compared(&format!("04-colour-profile/{name}")).expect("a picture");
        is_color(name, &compared.picture.pixels, COLOR, bound);
    }
}

/// Half of the scan is missing: refused as anything. Only the end marker is: read as anything, without a change.
#[test]
fn photographs_cut_off_are_refused_and_those_without_an_end_are_read() {
    for half in ["env-half.jpg", "plate-half.jpg", "plate-half.png"] {
        let file = format!("05-cut-off-jpeg/{half}");
        let size = if half.starts_with("env") { (256, 128) } else { (160, 120) };
        refusal(plate(&file, size), "broken or cut off");
        refusal(
            environment(&file).map(drop),
            if size.1 == 120 { "is 160 x 120" } else { "cut off" },
        );
        refusal(compared(&file), "broken or cut off");
    }
    let whole = plate("05-cut-off-jpeg/plate-whole.jpg", (160, 120)).expect("a plate");
    let progressive = plate("05-cut-off-jpeg/plate-progressive-whole.jpg", (160, 120));
    let progressive = progressive.expect("a plate");
    for (name, whole) in [
        ("plate-no-eoi", &whole),
        ("plate-trailer", &whole),
        ("plate-progressive-no-eoi", &progressive),
        ("plate-progressive-trailer", &progressive),
    ] {
        let read = plate(&format!("05-cut-off-jpeg/{name}.jpg"), (160, 120)).expect("a plate");
        assert!(pixels(&read) == pixels(whole), "{name}");
    }
    let whole = environment("05-cut-off-jpeg/env-whole.jpg").expect("a panorama");
    for name in ["env-no-eoi", "env-trailer"] {
        let read = environment(&format!("05-cut-off-jpeg/{name}.jpg")).expect("a panorama");
        assert!(read.texels() == whole.texels(), "{name}");
    }
}

/// Wherever a photograph is cut, what is read of it is the whole; the rest is refused.
#[test]
fn no_cut_of_a_photograph_goes_unnoticed() {
    let names = [
        "05-cut-off-jpeg/plate-whole.jpg",
        "05-cut-off-jpeg/plate-progressive-whole.jpg",
        "14-png-kinds/prog420.jpg",
        "14-png-kinds/gray.jpg",
        "03-jpeg-cmyk-ycck/ycck-adobe.jpg",
    ];
    let folder = Folder::new();
    for name in names {
        let bytes = std::fs::read(case(name)).expect("a file");
        let read = |bytes: &[u8]| {
            let path = folder.write("cut.jpg", bytes);
            let read = Decoded::read(&path, Request::new("--layer"))?;
            let is_rough =
                says(read.remarks.into_iter(), Severity::Warning, "make the picture sharp");
            Ok::<_, raindrops::Error>((read.picture, is_rough))
        };
        let whole = read(&bytes).expect("the whole");
        let step = (bytes.len() / 60).max(1);
        let cuts = (20..bytes.len()).step_by(step).chain(bytes.len() - 8..bytes.len());
        let (mut kept, mut refused) = (0, 0);
        for cut in cuts {
            // Also where a program that repairs files has put an end marker behind the rest.
            let closed = [&bytes[..cut], &[0xff, 0xd9]].concat();
            for bytes in [&bytes[..cut], &closed] {
                match read(bytes) {
                    Ok(read) => {
                        let is_whole = read.0 == whole.0 || read.1;
                        assert!(is_whole, "{name} cut at {cut} is another picture, in silence");
                        kept += 1;
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        println!("{name}: {kept} read, {refused} refused");
        assert!(kept > 0 && refused > 60, "{name}: {kept} read, {refused} refused");
    }
}

#[test]
fn windows_of_open_exr_are_heeded() {
    let at = |plate: &Plate, x: usize, y: usize| pixels(plate)[y * 96 + x];
    for name in ["plate", "overscan", "shifted", "autocrop"] {
        let plate = plate(&format!("06-exr-windows/{name}.exr"), (96, 64)).expect("a plate");
        is_color(name, &[at(&plate, 48, 32)], vec3(0.5, 0.5, 0.2), 1e-5);
    }
    let cropped = plate("06-exr-windows/autocrop.exr", (96, 64)).expect("a plate");
    assert_eq!((at(&cropped, 31, 32), at(&cropped, 48, 15)), (Vec3::ZERO, Vec3::ZERO));
    let said = cropped.remarks().iter().map(|(_, remark)| remark.clone());
    assert!(says(said, Severity::Warning, "missing (black)"));
    for (name, is_cropped) in
        [("depth", false), ("depth-overscan", false), ("depth-autocrop", true)]
    {
        let plate = depth(&format!("06-exr-windows/{name}.exr"), |_| ()).expect("depth");
        let values = &plate.depth().expect("depth").values;
        assert_eq!(values[32 * 96 + 48], 53.0, "{name}");
        assert_eq!(values[15 * 96 + 48], if is_cropped { SKY } else { 53.0 }, "{name}");
    }
}

#[test]
fn the_finished_picture_is_read_of_many_layers() {
    let names = [
        "albedo-first",
        "blender-ao",
        "blender-plain",
        "lower",
        "multipart",
        "stereo",
        "vray",
        "words",
    ];
    for name in names {
        let file = format!("08-layers-of-colour/{name}.exr");
        let panorama = environment(&file).expect("colours");
        is_color(name, panorama.texels(), COLOR, 1e-4);
        is_color(name, &compared(&file).expect("colours").picture.pixels, COLOR, 1e-4);
        let plate = plate(&format!("08-layers-of-colour/plate-{name}.exr"), (64, 64));
        let plate = plate.expect("colours");
        is_color(name, pixels(&plate), COLOR, 1e-4);
        // What was read is said, and said without asking where there was a choice.
        let is_choice = !["blender-plain", "lower", "words"].contains(&name);
        let severity = if is_choice { Severity::Note } else { Severity::Detail };
        assert!(says(panorama.remarks().iter().cloned(), severity, "is read"), "{name}");
        let said = plate.remarks().iter().map(|(_, remark)| remark.clone());
        assert!(says(said, severity, "is read"), "{name}");
    }
    environment("08-layers-of-colour/uint.exr").expect("integers");
    let choice = EnvironmentChoice {
        file: Some(case("08-layers-of-colour/vray.exr")),
        layer: Some("GI".into()),
        ..EnvironmentChoice::default()
    };
    is_color("GI", Environment::open(&choice).expect("a layer").texels(), Vec3::splat(0.05), 1e-3);
    let background = Background {
        color: Some(case("08-layers-of-colour/plate-vray.exr")),
        color_layer: Some("gi".into()),
        ..Background::default()
    };
    let plate = Plate::open(&background, 64, 64).expect("a layer");
    is_color("GI", pixels(&plate), Vec3::splat(0.05), 1e-3);
    let png = Request::new("--layer").layer(Some("GI"));
    refusal(
        Decoded::read(&case("14-png-kinds/gray8.png"), png),
        "has no layers, but --layer names one",
    );
}

#[test]
fn luminance_is_grey_and_chroma_is_refused() {
    let grey = plate("12-exr-luminance-chroma/plate-y.exr", (96, 64)).expect("a plate");
    assert!(pixels(&grey)[0].x == pixels(&grey)[0].y && (pixels(&grey)[0].x - 0.392).abs() < 1e-3);
    refusal(plate("12-exr-luminance-chroma/plate-yc.exr", (96, 64)), "luminance and chroma");
    refusal(environment("12-exr-luminance-chroma/env-yc.exr").map(drop), "luminance and chroma");
}

#[test]
fn an_overflowed_sun_is_as_bright_as_it_could_be_stored() {
    let right = environment("13-inf-sun/clamped.exr").expect("a panorama");
    let overflowed = environment("13-inf-sun/inf.exr").expect("a panorama");
    assert!(overflowed.texels() == right.texels());
    assert_eq!(overflowed.mended().overflowed, 37);
    let said = overflowed.mended().to_string();
    assert_eq!(said, "texels mended: 37 infinite (set to 65504)");
    let plate = plate("13-inf-sun/inf.exr", (256, 128)).expect("a plate");
    assert!(pixels(&plate) == right.texels());
    let said = plate.remarks().iter().map(|(_, remark)| remark.clone());
    assert!(says(said, Severity::Warning, "37 infinite (set to 65504)"));
    // What is compared stays as it is: an infinity is an error of whoever drew it.
    let compared = compared("13-inf-sun/inf.exr").expect("a picture");
    assert!(compared.picture.pixels.iter().any(|pixel| pixel.x == f32::INFINITY));
}

/// The sun overflows before its colour is converted, which would make NaN of it.
#[test]
fn an_overflowed_sun_of_other_primaries_is_bright() {
    let folder = Folder::new();
    let channels = exr::prelude::SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let value = if at.x() == 1 { f16::INFINITY } else { f16::ONE };
        (value, value, value)
    });
    let mut image = exr::prelude::Image::from_channels((4, 2), channels);
    image.attributes = ImageAttributes::new(IntegerBounds::from_dimensions((4, 2)));
    image.attributes.other.insert("acesImageContainerFlag".into(), AttributeValue::I32(1));
    let path = folder.path("sun.exr");
    image.write().to_file(&path).expect("a file");
    let panorama = Environment::load(&path).expect("a panorama");
    assert!((panorama.texels()[1] / 65_504.0 - Vec3::ONE).abs().max_element() < 1e-3);
    assert_eq!(panorama.mended().overflowed, 2);
}

/// (20 | 200, 120, 60) in sRGB, left and right.
#[test]
fn kinds_of_png_and_jpeg_are_read() {
    for entry in case("14-png-kinds").read_dir().expect("a folder") {
        let path = entry.expect("a file").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let has_other = ["README", "eight.jpg", "trailing.png", "prog420.jpg", "exif6.jpg"];
        if has_other.contains(&&*name) || name.starts_with("gray") {
            continue;
        }
        let read = Decoded::read(&path, Request::new("--layer")).expect("a picture");
        let (width, height) = (read.picture.width as usize, read.picture.height as usize);
        let right = read.picture.pixels[height / 2 * width + width * 9 / 10];
        let bound = if name.ends_with("jpg") { 0.12 } else { 0.01 };
        assert!(off(&[right], vec3(0.578, 0.188, 0.045)) < bound, "{name}: {right}");
        let is_clear = name.starts_with("rgba") || name == "palette-trns.png";
        let note = says(read.remarks.into_iter(), Severity::Note, "transparency is left out");
        assert_eq!(note, is_clear, "{name}");
    }
}

/// A camera's Adobe RGB without a profile: Exif's interoperability index says it.
#[test]
fn adobe_rgb_of_cameras_is_converted() {
    // Rec. 709 (0.8, 0.3, 0.1) in Adobe RGB: linear 0.6576, 0.3, 0.1082 by their chromaticities; power 2.19921875.
    let stored =
        [0.657_6_f64, 0.3, 0.108_2].map(|v| (255.0 * v.powf(1.0 / 2.199_218_75)).round() as u8);
    let mut jpeg = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 100);
    image::RgbImage::from_pixel(16, 8, image::Rgb(stored))
        .write_with_encoder(encoder)
        .expect("a file");
    // Big-endian TIFF: IFD0 points to the Exif IFD, which points to the interoperability IFD, whose entry 1 is "R03".
    let mut exif = b"Exif\0\0MM\0*\0\0\0\x08".to_vec();
    let pointer = |tag: u16, to: u32| {
        let mut entry = vec![0, 1];
        entry.extend(tag.to_be_bytes());
        entry.extend([0, 4, 0, 0, 0, 1]);
        entry.extend(to.to_be_bytes());
        entry.extend([0; 4]);
        entry
    };
    exif.extend(pointer(0x8769, 26));
    exif.extend(pointer(0xa005, 44));
    exif.extend([0, 1, 0, 1, 0, 2, 0, 0, 0, 4, b'R', b'0', b'3', 0, 0, 0, 0, 0]);
    let mut marked = jpeg[..2].to_vec();
    marked.extend([0xff, 0xe1]);
    marked.extend((exif.len() as u16 + 2).to_be_bytes());
    marked.extend(exif);
    marked.extend(&jpeg[2..]);
    let panorama = Environment::from_bytes("camera", &marked).expect("a panorama");
    is_color("Adobe RGB", panorama.texels(), COLOR, 0.03);
    let panorama = Environment::from_bytes("sRGB", &jpeg).expect("a panorama");
    assert!(off(panorama.texels(), COLOR) > 0.1, "not converted without the mark");
}

/// A PNG by code points (cICP): Display P3, and Rec. 2020 in PQ, where 203 cd/m² is 1. Stored values were computed in
/// numpy by the standards' formulas.
#[test]
fn code_points_of_png_are_applied() {
    let folder = Folder::new();
    let png = |stored: [u16; 3], points: [u8; 4]| {
        let path = folder.path("points.png");
        let image = image::ImageBuffer::from_pixel(4, 2, image::Rgb(stored));
        image.save(&path).expect("a file");
        let mut bytes = std::fs::read(&path).expect("a file");
        // Behind the header, which ends with its sum.
        let chunk = [&b"cICP"[..], &points].concat();
        let sum = crate::broken::crc(&chunk).to_be_bytes();
        bytes.splice(33..33, [&4u32.to_be_bytes()[..], &chunk, &sum].concat());
        Environment::from_bytes("points", &bytes).expect("a panorama")
    };
    let p3 = png([56_383, 39_211, 25_604], [12, 13, 0, 1]);
    is_color("P3", p3.texels(), COLOR, 1e-3);
    let pq = png([34_658, 30_743, 24_951], [9, 16, 0, 1]);
    is_color("PQ", pq.texels(), COLOR, 2e-3);
    let unknown = png([34_658, 30_743, 24_951], [22, 17, 0, 1]);
    assert!(says(unknown.remarks().iter().cloned(), Severity::Warning, "cICP 22, 17"));
}

/// A PNG that the program writes says that it is sRGB, and is read back as it was.
#[test]
fn pictures_that_are_written_say_what_they_are() {
    let folder = Folder::new();
    let path = folder.path("written.png");
    let values: Vec<u8> = (0..=255).flat_map(|value| [value, 255 - value, 7]).collect();
    raindrops::picture::write_png(&path, 16, 16, &values).expect("a file");
    let bytes = std::fs::read(&path).expect("a file");
    assert!(bytes.windows(5).any(|chunk| chunk == b"sRGB\x01"), "no sRGB chunk");
    let read = Decoded::read(&path, Request::new("--layer")).expect("a picture");
    assert!(read.remarks.iter().any(|remark| remark.text == "its colours are sRGB"));
    assert_eq!(read.picture.srgb(), values);
}

/// A scene keeps its choices of layers, and refuses those that choose nothing.
#[test]
fn layers_are_keys_of_a_scene() {
    let text = "[environment]\nfile = \"a.exr\"\nlayer = \"AO\"\n[background]\ncolor = \"b.exr\"\ncolor_layer = \"C\"\n\
                depth = \"c.exr\"\ndepth_layer = \"Depth\"\ndepth_invalid = nan\n";
    let scene = Scene::parse(text, "scene.toml").expect("a scene");
    assert_eq!(scene.environment.layer.as_deref(), Some("AO"));
    assert!(scene.background.depth_invalid.is_some_and(f64::is_nan));
    let folder = Folder::new();
    scene.save(&folder.path("saved.toml")).expect("a file");
    let saved = Scene::load(&folder.path("saved.toml")).expect("a scene");
    assert_eq!(saved.background.color_layer.as_deref(), Some("C"));
    assert_eq!(saved.background.depth_layer.as_deref(), Some("Depth"));
    for (text, expected) in [
        ("[environment]\nlayer = \"AO\"", "layer is given, but no file"),
        ("[background]\ncolor_layer = \"AO\"", "color_layer is given, but no color"),
        ("[background]\ndepth_layer = \"AO\"", "depth_layer is given, but no depth"),
        ("[background]\ndepth_invalid = 0", "depth_invalid is given, but no depth"),
    ] {
        let said = Scene::parse(text, "scene.toml").expect_err("refused").to_string();
        assert!(said.contains(expected) && said.contains("scene.toml:"), "{said}");
    }
}
