//! What is refused: one clear line, quickly, without a panic and without taking memory for it.

use std::time::{Duration, Instant};

use exr::prelude::*;
use glam::Vec3;
use raindrops::environment::Environment;

use crate::common::Random;
use crate::files::{self, Folder, largest_allocation, refusal};

/// Longer than any file here takes, however busy the machine.
const HANGS: Duration = Duration::from_secs(60);

/// Random changes to each file of each format.
const MUTATIONS: usize = 2_000;

/// So many times `RAINDROPS_MUTANTS`, for a longer run.
fn scaled(count: usize) -> usize {
    let times = std::env::var("RAINDROPS_MUTANTS").ok().and_then(|times| times.parse().ok());
    count * times.unwrap_or(1)
}

#[test]
fn a_missing_file_a_folder_and_a_device_are_refused() {
    let folder = Folder::new();
    assert!(refusal(&folder.path("none.exr")).contains("No such file"));
    std::fs::create_dir(folder.path("folder.exr")).expect("a folder");
    assert!(refusal(&folder.path("folder.exr")).contains("is a folder"));
    #[cfg(unix)]
    assert!(refusal(std::path::Path::new("/dev/zero")).contains("is not a regular file"));
}

#[test]
fn what_is_no_image_is_refused() {
    let folder = Folder::new();
    assert!(folder.refusal("empty.exr", b"").contains("is empty"));
    for bytes in [&b"v"[..], b"v/1", b"hello, world\n", b"GIF89a", b"P6 2 1 255\n", &[0; 100]] {
        let line = folder.refusal("text.exr", bytes);
        assert!(line.contains("is not an OpenEXR, Radiance HDR, PNG or JPEG image"), "{line}");
    }
    // No more than the magic bytes.
    for bytes in [&b"v/1\x01"[..], b"#?RADIANCE", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"] {
        assert!(folder.refusal("magic", bytes).contains("is broken or cut off"));
    }
}

#[test]
fn other_shapes_are_refused_with_the_mend() {
    let folder = Folder::new();
    for (width, height, mend) in [(8, 8, "16 x 8"), (1000, 400, "800 x 400"), (1, 2, "4 x 2")] {
        let path = folder.path("shape.png");
        image::RgbImage::new(width, height).save(&path).expect("a file");
        let line = refusal(&path);
        assert!(line.contains(&format!("is {width} x {height}")), "{line}");
        assert!(line.contains("twice as wide as it is high") && line.contains(mend), "{line}");
    }
    assert!(Environment::from_texels("count", 4, 2, vec![Vec3::ONE; 7]).is_err());
    assert!(Environment::from_texels("none", 0, 0, vec![]).is_err());
    assert!(Environment::from_texels("least", 2, 1, vec![Vec3::ONE; 2]).is_ok());
}

#[test]
fn deep_data_are_told() {
    let folder = Folder::new();
    let one = |_: usize, _: usize| 1.0;
    let channels: [files::NamedChannel<f32>; 3] = [("R", &one), ("G", &one), ("B", &one)];
    let mut bytes = files::exr((4, 2), Compression::ZIP16, Blocks::ScanLines, &channels);
    // Bit 11 of the version field: "this file contains deep data".
    bytes[5] |= 0x08;
    let line = folder.refusal("deep.exr", &bytes);
    assert!(line.contains("deep data") && !line.contains("broken"), "{line}");
    let read = raindrops::picture::Picture::from_bytes("deep.exr".as_ref(), &bytes);
    assert!(read.expect_err("a deep picture").to_string().contains("deep data"));
}

#[test]
fn images_that_hold_no_colour_are_refused() {
    let folder = Folder::new();
    let load = |channels: &[files::NamedChannel<f32>]| {
        let zip = Compression::ZIP16;
        folder.refusal("a.exr", &files::exr((4, 2), zip, Blocks::ScanLines, channels))
    };
    let one = |_: usize, _: usize| 1.0;
    let line = load(&[("Z", &one), ("R", &one)]);
    assert!(line.contains("has no channels R, G, B, nor Y; it has R, Z"), "{line}");
    let line = load(&[("Y", &one), ("RY", &one), ("BY", &one)]);
    assert!(line.contains("luminance and chroma"), "{line}");
    let line = load(&[
        ("R", &|_, _| f32::NAN),
        ("G", &|_, _| f32::INFINITY),
        ("B", &|_, _| f32::NEG_INFINITY),
    ]);
    assert!(line.contains("is full of NaN"), "{line}");
}

/// Overwrites the bytes `skip` after each place where `marker` is; there must be one.
fn patch(bytes: &mut [u8], marker: &[u8], skip: usize, value: &[u8]) {
    let places: Vec<usize> =
        (0..bytes.len() - marker.len()).filter(|at| bytes[*at..].starts_with(marker)).collect();
    assert!(!places.is_empty());
    for place in places {
        let start = place + marker.len() + skip;
        bytes[start..start + value.len()].copy_from_slice(value);
    }
}

/// The CRC-32 of PNG.
pub fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

#[test]
fn huge_claims_are_refused_before_memory_is_taken() {
    let folder = Folder::new();
    let mut claims = Vec::new();
    for (width, height) in [(16_386_u32, 8_193_u32), (200_000, 100_000), (900_000_000, 450_000_000)]
    {
        for compression in files::COMPRESSIONS {
            let mut bytes = files::exr_half(compression);
            let mut window = (width - 1).to_le_bytes().to_vec();
            window.extend_from_slice(&(height - 1).to_le_bytes());
            // Name, type, length, least corner; then the greatest corner.
            patch(&mut bytes, b"dataWindow\0box2i\0", 12, &window);
            patch(&mut bytes, b"displayWindow\0box2i\0", 12, &window);
            claims.push((format!("{width} {compression:?}.exr"), bytes));
        }
        let hdr = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n\x02\x02");
        claims.push((format!("{width}.hdr"), hdr.into_bytes()));
        let mut png = files::display(image::ImageFormat::Png);
        patch(&mut png, b"IHDR", 0, &[width.to_be_bytes(), height.to_be_bytes()].concat());
        let sum = crc(&png[12..29]);
        patch(&mut png, b"IHDR", 13, &sum.to_be_bytes());
        claims.push((format!("{width}.png"), png));
    }
    let mut jpeg = files::display(image::ImageFormat::Jpeg);
    patch(&mut jpeg, b"\xff\xc0", 3, &[0x7f, 0xff, 0xff, 0xfe]);
    claims.push(("claim.jpg".into(), jpeg));

    for (name, bytes) in claims {
        let start = Instant::now();
        let (line, largest) = largest_allocation(|| folder.refusal(&name, &bytes));
        assert!(line.contains("over the limit of 16384 x 8192"), "{line}");
        assert!(largest < 1 << 20, "{name}: {largest} bytes at once");
        assert!(start.elapsed() < HANGS, "{name}: {:?}", start.elapsed());
    }
}

/// The counters of a DWA block, each claiming what would take all memory.
#[test]
fn huge_claims_of_a_dwa_block_are_refused() {
    for (name, sound) in files::DWA {
        // Version 2 begins a block, after its line and length.
        let start = (300..sound.len()).find(|at| sound[*at..].starts_with(&2u64.to_le_bytes()));
        let start = start.expect("a block");
        for counter in 1..10 {
            let mut bytes = sound.to_vec();
            bytes[start + 8 * counter..][..8].copy_from_slice(&(1u64 << 52).to_le_bytes());
            let (refused, largest) = largest_allocation(|| Environment::from_bytes(name, &bytes));
            assert!(refused.is_err() && largest < 1 << 20, "{name}, {counter}: {largest} bytes");
        }
    }
}

#[test]
fn files_cut_off_anywhere_are_refused() {
    let folder = Folder::new();
    for (name, bytes) in files::all() {
        // The last chunk of a PNG, and the marker at the end of a JPEG, say only that they are the last.
        let ends = [("png", 12), ("jpg", 2)];
        let end = ends.iter().find(|(format, _)| name.ends_with(format)).map_or(0, |(_, end)| *end);
        let needed = bytes.len() - end;
        for length in 0..needed {
            assert!(Environment::from_bytes(&name, &bytes[..length]).is_err(), "{name}: {length}");
        }
        for length in [needed / 3, needed - 1] {
            folder.refusal(&name, &bytes[..length]);
        }
        folder.load(&name, &bytes).expect("the whole file");
    }
}

#[test]
fn a_block_that_the_file_lacks_is_counted() {
    let mut bytes = files::exr_half(Compression::Uncompressed);
    // The table of the blocks' places, a row each, ends where the first block begins.
    let table = (0..bytes.len())
        .find(|at| bytes[*at..].starts_with(&((at + 8 * files::HEIGHT) as u64).to_le_bytes()))
        .expect("a table");
    bytes.copy_within(table..table + 8, table + 8 * 5);
    let environment = Environment::from_bytes("lacking", &bytes).expect("the rest");
    assert_eq!(environment.mended().non_finite, files::WIDTH as u64);
    let (row, above) = (5 * files::WIDTH + 9, 4 * files::WIDTH + 9);
    let error = environment.texels()[row] / environment.texels()[above] - Vec3::ONE;
    assert!(error.abs().max_element() < 0.2, "not like its neighbours");
}

#[test]
fn a_decoder_that_panics_does_not_take_the_program_down() {
    // A long chain of empty runs overflows the HDR decoder's multiplier, where that is checked;
    // elsewhere the file is merely cut off.
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x09\x09\x09\x80".to_vec();
    bytes.extend_from_slice(&[1, 1, 1, 0].repeat(12));
    assert!(Folder::new().refusal("chain.hdr", &bytes).contains("is broken"));
}

fn below(random: &mut Random, limit: usize) -> usize {
    (random.bits() % limit as u64) as usize
}

/// Changes some bytes, half of the time near the start, where the header is.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    let mut below = |limit| below(random, limit);
    for _ in 0..1 + below(4) {
        let reach = if below(2) == 0 { bytes.len() } else { bytes.len().min(400) };
        let at = below(reach.max(1)).min(bytes.len() - 1);
        let run = (1 + below(8)).min(bytes.len() - at);
        match below(6) {
            0 => bytes[at] ^= 1 << below(8),
            1 => bytes[at] = below(256) as u8,
            2 => bytes[at..at + run].fill([0, 1, 0x7f, 0x80, 0xff][below(5)]),
            3 => drop(bytes.drain(at..at + run)),
            4 => {
                let copy = bytes[at..at + run].to_vec();
                bytes.splice(at..at, copy);
            }
            _ => bytes.truncate((bytes.len() - below(bytes.len() / 2 + 1)).max(1)),
        }
        if bytes.is_empty() {
            bytes.push(0);
        }
    }
}

/// Reads mutants of a file that is read; how many are, and how many are refused. What no file may cause fails: a panic, a
/// result that is not sound, a message of several lines, a long time, and one allocation of `most_bytes`.
pub fn mutants<T>(
    name: &str,
    bytes: &[u8],
    seed: u64,
    most_bytes: usize,
    read: impl Fn(&[u8]) -> raindrops::Result<T>,
    is_sound: impl Fn(&T) -> bool,
) -> (usize, usize) {
    assert!(read(bytes).is_ok(), "{name}: the control is refused");
    let mut random = Random(seed);
    let (mut sound, mut refused) = (0, 0);
    let (mut slowest, mut largest) = (Duration::ZERO, 0);
    for number in 0..scaled(MUTATIONS) {
        let mut mutant = bytes.to_vec();
        mutate(&mut random, &mut mutant);
        let start = Instant::now();
        let (outcome, allocated) = largest_allocation(|| read(&mutant));
        (slowest, largest) = (slowest.max(start.elapsed()), largest.max(allocated));
        match outcome {
            Ok(found) => {
                sound += 1;
                assert!(is_sound(&found), "{name}: mutant {number} is read, and not sound");
            }
            Err(error) => {
                refused += 1;
                let error = error.to_string();
                assert!(!error.contains('\n'), "{name}: mutant {number}: {error}");
            }
        }
    }
    println!(
        "{name}: {sound} read, {refused} refused, slowest {slowest:?}, largest allocation {largest} bytes"
    );
    assert!(slowest < HANGS, "{name}: {slowest:?} for one file");
    assert!(largest < most_bytes, "{name}: {largest} bytes at once");
    (sound, refused)
}

#[test]
fn mutants_load_or_are_refused_and_never_panic() {
    let is_sound = |environment: &Environment| {
        let sound = |texel: &Vec3| texel.is_finite() && texel.min_element() >= 0.0;
        environment.width() == 2 * environment.height() && environment.texels().iter().all(sound)
    };
    for (seed, (name, bytes)) in files::all().into_iter().enumerate() {
        let read = |bytes: &[u8]| Environment::from_bytes(&name, bytes);
        let (loaded, refused) = mutants(&name, &bytes, seed as u64, usize::MAX, read, is_sound);
        assert!(refused > MUTATIONS / 10, "{name}: only {refused} refused: mutated too little?");
        assert!(loaded > 0, "{name}: none loaded: mutated too much?");
    }
}
