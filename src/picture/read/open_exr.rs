//! OpenEXR by the `exr` crate: some channels of one part, placed by the display window.
//!
//! Blocks are decoded one after the other, and of each only the channels that are read: a file of sixty passes takes no
//! more memory than one of three. In one thread: the crate's thread pool aborts the process where a decoder panics.

use std::io::Cursor;

use exr::block::UncompressedBlock;
use exr::block::lines::LineRef;
use exr::block::reader::ChunksReader as _;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use glam::Vec3;

use super::color::{self, Primaries};
use super::layers::{self, Choice};
use super::{Decoded, broken, check_claim, dwa};
use crate::remark::Remark;

/// The first bytes of every OpenEXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Most bytes of one block of lines, all channels: 64 channels of float32 in the widest environment with the tallest
/// block (256 lines). A header that claims more is refused before the decoder takes the memory.
const MAX_BLOCK_BYTES: u64 = 1 << 30;

/// Refuses a width and height before memory is taken for them.
pub(crate) type Check<'a> = &'a dyn Fn(usize, usize) -> Result<(), String>;

/// Channels of a file, each of `width * height` values row by row from the top.
pub(crate) struct Planes {
    pub width: usize,
    pub height: usize,
    pub values: Vec<Vec<f32>>,
    /// Pixels of the display window that the data window leaves out.
    pub missing: u64,
    pub remarks: Vec<Remark>,
    primaries: Option<Primaries>,
}

/// Which channels to read, by the file's headers.
type Choose<'a> = &'a dyn Fn(&[Header]) -> Result<Choice, String>;

/// Decodes colour: linear Rec. 709, black where the data window has nothing. `layer` chooses a layer, which `key` names
/// in messages.
pub(super) fn decode(
    bytes: &[u8],
    check: Check<'_>,
    layer: Option<&str>,
    key: &str,
) -> Result<Decoded, String> {
    let choose = |headers: &[Header]| layers::color(headers, layer, key);
    let planes = planes(bytes, check, &choose, 0.0)?;
    let Planes { width, height, values, missing, remarks, primaries } = planes;
    let pixels = match &values[..] {
        [r, g, b] => r.iter().zip(g).zip(b).map(|((r, g), b)| Vec3::new(*r, *g, *b)).collect(),
        _ => values[0].iter().map(|y| Vec3::splat(*y)).collect(),
    };
    let is_grey = values.len() == 1;
    let decoded = Decoded { missing, remarks, ..Decoded::radiance(width, height, pixels) };
    match primaries {
        Some(primaries) if !is_grey => decoded.of_primaries(primaries),
        _ => Ok(decoded),
    }
}

/// Decodes the chosen channels; pixels that the data window leaves out have the value `outside`, those of blocks that
/// the file lacks are NaN.
pub(super) fn planes(
    bytes: &[u8],
    check: Check<'_>,
    choose: Choose<'_>,
    outside: f32,
) -> Result<Planes, String> {
    // A bit of the version says that a part is deep. The decoder reads none of the others then either.
    if bytes.get(5).is_some_and(|flags| flags & 0x08 != 0) {
        return Err("holds deep data (several samples a pixel), which is not read; flatten it to one sample a pixel".into());
    }
    let file = || Cursor::new(bytes);
    // Without the crate's checks first: of a size that is refused anyway they say something else.
    let meta = MetaData::read_from_buffered(file(), false).map_err(unreadable)?;
    let choice = choose(&meta.headers)?;
    let frame = Frame::new(&meta.headers[choice.part], check)?;
    check_claim(frame.data.0, frame.data.1, bytes)?;
    let reader = exr::block::read(file(), false).map_err(unreadable)?;
    let header = &reader.headers()[choice.part];
    let mut remarks = remarks(header, &choice);
    let primaries = primaries(header, &mut remarks);
    let blank = frame.blank(outside);
    let mut values = vec![blank; choice.channels.len()];
    let chunks = reader
        .filter_chunks(false, |_, _, block| block.layer == choice.part && block.level == Vec2(0, 0))
        .map_err(broken)?;
    let meta: MetaData = chunks.meta_data().clone();
    let header = &meta.headers[choice.part];
    for chunk in chunks {
        let chunk = chunk.map_err(broken)?;
        if chunk.layer_index != choice.part {
            return Err(broken("a block is of another part"));
        }
        dwa::check_claim(header, &chunk)?;
        let block = UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(broken)?;
        for line in block.lines(&header.channels) {
            let read = choice.channels.iter().position(|number| *number == line.location.channel);
            if let Some(plane) = read.map(|number| &mut values[number]) {
                let kind = header.channels.list[line.location.channel].sample_type;
                frame.place(plane, line, kind)?;
            }
        }
    }
    let Frame { width, height, missing, .. } = frame;
    Ok(Planes { width, height, values, missing, remarks, primaries })
}

/// Words for what the crate says of a header: it reads no channels of a lower resolution, such as chroma.
fn unreadable(error: exr::error::Error) -> String {
    match error.to_string() {
        said if said.contains("subsampling") => {
            "has channels of a lower resolution, as luminance and chroma (Y, RY, BY) \
             have; save it with channels R, G, B of one resolution"
                .into()
        }
        said => broken(said),
    }
}

/// What is worth saying of a choice and of attributes that change what pixels mean.
fn remarks(header: &Header, choice: &Choice) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let read = format!("{} is read", choice.name);
    if choice.others.is_empty() {
        remarks.push(Remark::detail(read));
    } else {
        remarks.push(Remark::note(format!("{read}; there are also {}", choice.others.join(", "))));
    }
    let aspect = f64::from(header.shared_attributes.pixel_aspect);
    if (aspect - 1.0).abs() > 0.01 {
        remarks.push(super::pixel_aspect(aspect));
    }
    remarks
}

/// The primaries that a file states; none if it states none, which is Rec. 709. What is stated by a name that is not
/// known is a warning.
fn primaries(header: &Header, remarks: &mut Vec<Remark>) -> Option<Primaries> {
    if let Some(stated) = header.shared_attributes.chromaticities {
        let each = [stated.red, stated.green, stated.blue, stated.white].map(|Vec2(x, y)| [x, y]);
        return Some(Primaries::from_array(std::array::from_fn(|n| f64::from(each[n / 2][n % 2]))));
    }
    let others = [&header.shared_attributes.other, &header.own_attributes.other];
    let value =
        |name: &str| others.iter().flat_map(|all| all.iter()).find(|(key, _)| **key == *name);
    if let Some((_, AttributeValue::I32(1))) = value("acesImageContainerFlag") {
        return Some(color::ACES_AP0);
    }
    let stated = ["colorInteropID", "oiio:ColorSpace"].into_iter().find_map(value);
    let Some((key, AttributeValue::Text(name))) = stated else { return None };
    match name.to_string().to_lowercase().trim_end_matches("_scene") {
        "acescg" | "lin_ap1" => Some(color::ACES_AP1),
        "aces2065-1" | "lin_ap0" => Some(color::ACES_AP0),
        "lin_rec2020" => Some(color::REC2020),
        "lin_p3d65" => Some(color::P3_D65),
        "lin_adobergb" => Some(color::ADOBE_RGB),
        "lin_ciexyzd65" => Some(color::XYZ),
        "linear" | "scene_linear" | "lin_srgb" | "lin_rec709" | "data" | "unknown" => None,
        _ => {
            remarks.push(Remark::warning(format!(
                "its colour space '{name}' ({key}) is not known; its colours are taken for linear Rec. 709"
            )));
            None
        }
    }
}

/// Where the data window's pixels lie in the picture, which is the display window.
struct Frame {
    width: usize,
    height: usize,
    /// Upper left pixel of the data window in the picture; may lie outside.
    origin: (i64, i64),
    data: (usize, usize),
    /// Pixels of the picture that are outside the data window.
    missing: u64,
}

impl Frame {
    fn new(header: &Header, check: Check<'_>) -> Result<Self, String> {
        let window = header.shared_attributes.display_window;
        let Vec2(width, height) = window.size;
        let Vec2(data_width, data_height) = header.layer_size;
        check(width, height)?;
        let lines = match header.blocks {
            exr::meta::BlockDescription::ScanLines => header.compression.scan_lines_per_block(),
            exr::meta::BlockDescription::Tiles(tiles) => tiles.tile_size.height(),
        };
        let block = lines.min(data_height) as u64
            * data_width as u64
            * header.channels.bytes_per_pixel as u64;
        if block > MAX_BLOCK_BYTES {
            return Err(format!(
                "has {} channels, so many that a block of lines takes {} MiB; save only R, G, B",
                header.channels.list.len(),
                block >> 20
            ));
        }
        let Vec2(x, y) = header.own_attributes.layer_position;
        let origin = (
            i64::from(x) - i64::from(window.position.x()),
            i64::from(y) - i64::from(window.position.y()),
        );
        let overlap = |start: i64, length: usize, limit: usize| {
            (start + length as i64).min(limit as i64) - start.max(0)
        };
        let across = overlap(origin.0, data_width, width).max(0) as u64;
        let down = overlap(origin.1, data_height, height).max(0) as u64;
        if across == 0 || down == 0 {
            return Err("has no pixel inside its display window".into());
        }
        let missing = width as u64 * height as u64 - across * down;
        Ok(Self { width, height, origin, data: (data_width, data_height), missing })
    }

    /// Columns of the picture that a run of pixels of the data window covers, and its row; none outside.
    fn run(&self, at: Vec2<usize>, count: usize) -> Option<(usize, std::ops::Range<i64>)> {
        let row = self.origin.1 + at.y() as i64;
        let from = self.origin.0 + at.x() as i64;
        let columns = from.max(0)..(from + count as i64).min(self.width as i64);
        let is_inside = (0..self.height as i64).contains(&row) && !columns.is_empty();
        is_inside.then_some((row as usize, columns))
    }

    /// A plane that is NaN in the data window, and `outside` elsewhere.
    fn blank(&self, outside: f32) -> Vec<f32> {
        let mut plane = vec![outside; self.width * self.height];
        for y in 0..self.data.1 {
            if let Some((row, columns)) = self.run(Vec2(0, y), self.data.0) {
                let row = &mut plane[row * self.width..][..self.width];
                row[columns.start as usize..columns.end as usize].fill(f32::NAN);
            }
        }
        plane
    }

    /// Puts a line of samples into its place, what of it is in the picture.
    fn place(&self, plane: &mut [f32], line: LineRef<'_>, kind: SampleType) -> Result<(), String> {
        let at = line.location.position;
        let Some((row, columns)) = self.run(at, line.location.sample_count) else { return Ok(()) };
        let skipped = (columns.start - (self.origin.0 + at.x() as i64)) as usize;
        let row = &mut plane[row * self.width..][..self.width];
        let row = &mut row[columns.start as usize..columns.end as usize];
        let mut fill = |values: &mut dyn Iterator<Item = exr::error::Result<f32>>| {
            for (pixel, value) in row.iter_mut().zip(values.skip(skipped)) {
                *pixel = value.map_err(broken)?;
            }
            Ok(())
        };
        match kind {
            SampleType::F16 => fill(&mut line.read_samples::<f16>().map(|v| v.map(f16::to_f32))),
            SampleType::F32 => fill(&mut line.read_samples::<f32>()),
            SampleType::U32 => fill(&mut line.read_samples::<u32>().map(|v| v.map(|v| v as f32))),
        }
    }
}
