//! Small image files of every kind, and what they hold.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Vec2, WritableImage, f16,
};
use glam::{Vec3, vec3};
use raindrops::environment::Environment;

pub const WIDTH: usize = 32;
pub const HEIGHT: usize = 16;

/// The compressions that the `exr` crate can write.
pub const COMPRESSIONS: [Compression; 8] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
];

/// The test picture, half float RGB, in the two that it only reads; OpenEXR 3.5 wrote them.
pub const DWA: [(&str, &[u8]); 2] =
    [("dwaa.exr", include_bytes!("dwaa.exr")), ("dwab.exr", include_bytes!("dwab.exr"))];

/// A smooth high dynamic range picture, 0.05 to 20, different in every channel and place.
pub fn radiance(x: usize, y: usize) -> Vec3 {
    let (u, v) = (x as f32 / WIDTH as f32, y as f32 / HEIGHT as f32);
    let bright = 1.0 + 19.0 * (1.0 - v).powi(2);
    vec3(0.05 + 0.95 * u, 0.1 + 0.4 * v, 0.3 + 0.2 * (6.3 * u).sin()) * bright
}

/// A type of sample that EXR stores.
pub trait Sample: Sized {
    fn flat(samples: Vec<Self>) -> FlatSamples;
}

impl Sample for f16 {
    fn flat(samples: Vec<Self>) -> FlatSamples {
        FlatSamples::F16(samples)
    }
}

impl Sample for f32 {
    fn flat(samples: Vec<Self>) -> FlatSamples {
        FlatSamples::F32(samples)
    }
}

impl Sample for u32 {
    fn flat(samples: Vec<Self>) -> FlatSamples {
        FlatSamples::U32(samples)
    }
}

/// A channel's name and its samples, a function of column and row.
pub type NamedChannel<'a, S> = (&'a str, &'a dyn Fn(usize, usize) -> S);

/// An EXR file in memory with these channels.
pub fn exr<S: Sample>(
    size: (usize, usize),
    compression: Compression,
    blocks: Blocks,
    channels: &[NamedChannel<S>],
) -> Vec<u8> {
    let list = channels
        .iter()
        .map(|(name, sample)| {
            let samples: Vec<S> =
                (0..size.0 * size.1).map(|at| sample(at % size.0, at / size.0)).collect();
            AnyChannel::new(*name, S::flat(samples))
        })
        .collect();
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let attributes = LayerAttributes::named("test");
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("EXR in memory");
    bytes.into_inner()
}

/// The test picture as EXR, half float RGB.
pub fn exr_half(compression: Compression) -> Vec<u8> {
    exr(
        (WIDTH, HEIGHT),
        compression,
        Blocks::ScanLines,
        &[
            ("R", &|x, y| f16::from_f32(radiance(x, y).x)),
            ("G", &|x, y| f16::from_f32(radiance(x, y).y)),
            ("B", &|x, y| f16::from_f32(radiance(x, y).z)),
        ],
    )
}

/// The test picture as EXR, float RGB.
pub fn exr_float(compression: Compression, blocks: Blocks) -> Vec<u8> {
    exr(
        (WIDTH, HEIGHT),
        compression,
        blocks,
        &[
            ("R", &|x, y| radiance(x, y).x),
            ("G", &|x, y| radiance(x, y).y),
            ("B", &|x, y| radiance(x, y).z),
        ],
    )
}

/// The test picture as Radiance HDR, run-length coded.
pub fn hdr() -> Vec<u8> {
    let pixels: Vec<_> = (0..WIDTH * HEIGHT)
        .map(|at| image::Rgb(radiance(at % WIDTH, at / WIDTH).to_array()))
        .collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, WIDTH, HEIGHT)
        .expect("HDR in memory");
    bytes
}

/// An 8-bit picture of display colours in PNG or JPEG.
pub fn display(format: image::ImageFormat) -> Vec<u8> {
    let picture = image::RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        image::Rgb([(x * 8) as u8, (y * 16) as u8, 128])
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("an image in memory");
    bytes.into_inner()
}

/// A JPEG with the EXIF data of a camera that was held in another way: 3 is upside down, 6 to the left.
pub fn turned(orientation: u8) -> Vec<u8> {
    let mut bytes = display(image::ImageFormat::Jpeg);
    let tiff = [
        &b"Exif\0\0II*\0\x08\0\0\0"[..],
        &[1, 0, 0x12, 1, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0, 0, 0, 0, 0],
    ]
    .concat();
    let marker = [0xff, 0xe1, 0, (tiff.len() + 2) as u8];
    bytes.splice(2..2, marker.into_iter().chain(tiff));
    bytes
}

/// One file of every format and way of coding.
pub fn all() -> Vec<(String, Vec<u8>)> {
    let tiles = Blocks::Tiles(Vec2(8, 8));
    let mut files: Vec<_> =
        COMPRESSIONS.map(|way| (format!("{way:?}.exr"), exr_half(way))).into_iter().collect();
    files.extend(DWA.map(|(name, bytes)| (name.into(), bytes.to_vec())));
    files.push(("tiles.exr".into(), exr_float(Compression::ZIP16, tiles)));
    files.push(("radiance.hdr".into(), hdr()));
    files.push(("display.png".into(), display(image::ImageFormat::Png)));
    files.push(("display.jpg".into(), display(image::ImageFormat::Jpeg)));
    files
}

/// A folder for files, removed when dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    }

    pub fn load(&self, name: &str, bytes: &[u8]) -> raindrops::Result<Environment> {
        Environment::load(&self.write(name, bytes))
    }

    /// The message of a refusal; panics if the file loads.
    pub fn refusal(&self, name: &str, bytes: &[u8]) -> String {
        refusal(&self.write(name, bytes))
    }
}

/// The message of a refusal, one line that names the file; panics if the file loads.
pub fn refusal(path: &Path) -> String {
    match Environment::load(path) {
        Ok(_) => panic!("{} loads, though it should not", path.display()),
        Err(error) => {
            assert!(matches!(error, raindrops::Error::Environment { .. }), "{error:?}");
            let line = error.to_string();
            assert!(!line.contains('\n') && line.len() < 400, "not one short line: {line}");
            assert!(line.contains(&path.display().to_string()), "names no file: {line}");
            line
        }
    }
}

/// The real environments that scripts/setup.sh fetches; none where the tester has said that there are none.
pub fn real_environments() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "exr"))
        .collect();
    files.sort();
    let without = std::env::var_os("RAINDROPS_TEST_WITHOUT_PHOTOGRAPHS").is_some();
    assert!(!files.is_empty() || without, "scripts/setup.sh fetches assets/environments");
    files
}

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

/// Runs `work` and returns its result with the largest single allocation that it made, in bytes.
pub fn largest_allocation<T>(work: impl FnOnce() -> T) -> (T, usize) {
    LARGEST.set(0);
    let result = work();
    (result, LARGEST.get())
}

struct Watched;

#[global_allocator]
static WATCHED: Watched = Watched;

fn note(size: usize) {
    // Fails only while a thread is torn down, when nobody asks any more.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
}

// SAFETY: all is passed on to the system's allocator; `note` does not allocate.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promises are the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        // SAFETY: as above.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}
