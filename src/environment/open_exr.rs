//! OpenEXR to texels, by the `exr` crate: every compression that it reads, any layer with colours.

use std::io::{BufRead, Seek};

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};
use glam::Vec3;

use super::load::{broken, check_size};
use super::{Image, MAX_HEIGHT, MAX_WIDTH};
use crate::picture::{DEEP, is_deep};

/// Most bytes of one block of lines, all channels: 64 channels of float32 in the widest image with
/// the tallest block (256 lines). A header that claims more is refused before the decoder takes
/// the memory.
const MAX_BLOCK_BYTES: u64 = 1 << 30;

/// The channels to read.
enum Channels {
    /// Red, green and blue, by their names in the file.
    Rgb([String; 3]),
    /// Luminance.
    Y,
}

/// Decodes an OpenEXR image.
pub(super) fn decode(mut reader: impl BufRead + Seek) -> Result<Image, String> {
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(broken)?;
    reader.rewind().map_err(broken)?;
    if is_deep(start) {
        return Err(DEEP.into());
    }
    let metadata = MetaData::read_from_buffered(&mut reader, false).map_err(broken)?;
    let (header, channels) = choose(&metadata.headers)?;
    let frame = Frame::new(header)?;
    reader.rewind().map_err(broken)?;
    crate::picture::dwa::check_claims(&mut reader).map_err(broken)?;
    reader.rewind().map_err(broken)?;

    // The first layer with these channels is the one chosen: `choose` looks in the same order.
    // In one thread: the crate's thread pool aborts the process where a decoder panics.
    let pick = exr::prelude::read().no_deep_data().largest_resolution_level();
    let texels = match channels {
        Channels::Rgb([r, g, b]) => {
            pick.specific_channels()
                .required::<f32>(r.as_str())
                .required::<f32>(g.as_str())
                .required::<f32>(b.as_str())
                .collect_pixels(
                    |_, _| frame.blank(),
                    move |texels, at, (r, g, b): (f32, f32, f32)| {
                        frame.set(texels, at, Vec3::new(r, g, b));
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(reader)
                .map_err(broken)?
                .layer_data
                .channel_data
                .pixels
        }
        Channels::Y => {
            pick.specific_channels()
                .required::<f32>("Y")
                .collect_pixels(
                    |_, _| frame.blank(),
                    move |texels, at, (y,): (f32,)| frame.set(texels, at, Vec3::splat(y)),
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(reader)
                .map_err(broken)?
                .layer_data
                .channel_data
                .pixels
        }
    };
    Ok(Image {
        width: frame.width as u32,
        height: frame.height as u32,
        texels,
        missing: frame.missing,
    })
}

/// The layer and channels to read: plain R, G, B in any layer; else a group of channels that ends
/// so (`ViewLayer.Combined.R`); else luminance.
fn choose(headers: &[Header]) -> Result<(&Header, Channels), String> {
    let names = |header: &Header| -> Vec<String> {
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect()
    };
    let rgb = |header: &Header, group: &str| {
        let wanted = ["R", "G", "B"].map(|channel| format!("{group}{channel}"));
        let names = names(header);
        wanted.iter().all(|name| names.contains(name)).then_some(Channels::Rgb(wanted))
    };
    let plain = headers.iter().find_map(|header| Some((header, rgb(header, "")?)));
    let grouped = || {
        headers.iter().find_map(|header| {
            let names = names(header);
            let mut groups = names.iter().filter_map(|name| name.strip_suffix('R'));
            let channels =
                groups.find_map(|group| group.ends_with('.').then(|| rgb(header, group))?)?;
            Some((header, channels))
        })
    };
    let has = |header: &Header, name: &str| names(header).iter().any(|other| other == name);
    let luminance = || headers.iter().find(|header| has(header, "Y"));
    if let Some(found) = plain.or_else(grouped) {
        return Ok(found);
    }
    match luminance() {
        Some(header) if has(header, "RY") || has(header, "BY") => {
            Err("holds luminance and chroma (Y, RY, BY); save it with channels R, G, B".into())
        }
        Some(header) => Ok((header, Channels::Y)),
        None => {
            let found: Vec<String> = headers.iter().flat_map(names).take(6).collect();
            Err(format!(
                "has no channels R, G, B, nor Y; it has {}",
                if found.is_empty() { "none".into() } else { found.join(", ") }
            ))
        }
    }
}

/// Where the data window's pixels lie in the picture, which is the display window.
#[derive(Clone, Copy)]
struct Frame {
    width: usize,
    height: usize,
    /// Upper left pixel of the data window in the picture; may lie outside.
    origin: (i64, i64),
    data: (usize, usize),
    /// Texels of the picture that are outside the data window.
    missing: u64,
}

impl Frame {
    fn new(header: &Header) -> Result<Self, String> {
        let window = header.shared_attributes.display_window;
        let Vec2(width, height) = window.size;
        let Vec2(data_width, data_height) = header.layer_size;
        // The data window may overhang the picture, but it is what memory is taken for.
        if data_width > MAX_WIDTH as usize || data_height > MAX_HEIGHT as usize {
            check_size(data_width as u64, data_height as u64)?;
        }
        check_size(width as u64, height as u64)?;
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

    /// A picture in which the data window is NaN until its pixels are set, so that blocks which
    /// the file lacks are counted, and which is black elsewhere.
    fn blank(&self) -> Vec<Vec3> {
        let mut texels = vec![Vec3::ZERO; self.width * self.height];
        for y in 0..self.data.1 {
            for x in 0..self.data.0 {
                self.set(&mut texels, Vec2(x, y), Vec3::NAN);
            }
        }
        texels
    }

    /// Sets a pixel, given by its place in the data window, if it is inside the picture.
    fn set(&self, texels: &mut [Vec3], at: Vec2<usize>, radiance: Vec3) {
        let (x, y) = (self.origin.0 + at.x() as i64, self.origin.1 + at.y() as i64);
        let inside = |place: i64, limit: usize| (0..limit as i64).contains(&place);
        if inside(x, self.width) && inside(y, self.height) {
            texels[y as usize * self.width + x as usize] = radiance;
        }
    }
}
