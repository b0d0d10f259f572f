//! Whether all of a JPEG's pixels are there.
//!
//! Decoders fill what was cut off with grey and call it well. So the scans are walked here: each block's codes are read
//! and thrown away (ITU T.81, annexes F and G), and all must be there before the data end. A progressive file is whole
//! when the scans also bring every coefficient to its last bit; one without its end marker that stops between two scans
//! shows every pixel, but not as it was.

use std::borrow::Cow;

use super::broken;
use crate::remark::Remark;

const START: u8 = 0xd8;
const END: u8 = 0xd9;
const SCAN: u8 = 0xda;
const HUFFMAN: u8 = 0xc4;
const RESTARTS: u8 = 0xdd;
const BASELINE: u8 = 0xc0;
const PROGRESSIVE: u8 = 0xc2;

/// The file with an end marker behind its last scan, and what it lacks although it has one: some programs never send the
/// last bits, and others close what was cut off.
///
/// # Errors
/// Pixels are missing, in words. Kinds that are not walked (arithmetic codes, lossless) are left to the decoder.
pub(super) fn whole(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, Option<Remark>), String> {
    let mut walk = Walk::new(bytes);
    let end = loop {
        let Some((marker, segment)) = walk.segment()? else { break walk.at };
        match marker {
            END => {
                let rough = walk.frame.as_ref().and_then(Frame::missing);
                return Ok((Cow::Borrowed(bytes), rough.map(Remark::warning)));
            }
            HUFFMAN => walk.define_tables(segment)?,
            RESTARTS => walk.restarts = usize::from(be16(segment, 0).ok_or_else(damaged)?),
            BASELINE | 0xc1 | PROGRESSIVE => {
                walk.frame = Some(Frame::parse(segment, marker == PROGRESSIVE)?)
            }
            0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                return Ok((Cow::Borrowed(bytes), None));
            }
            SCAN => walk.scan(segment)?,
            _ => {}
        }
    };
    let frame = walk.frame.as_ref().ok_or_else(|| broken("it ends before its picture"))?;
    if let Some(missing) = frame.missing() {
        return Err(broken(missing));
    }
    Ok((Cow::Owned([&bytes[..end], &[0xff, END]].concat()), None))
}

fn damaged() -> String {
    broken("a segment of it is not whole")
}

fn be16(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

/// A colour channel.
struct Component {
    id: u8,
    /// Blocks of one unit of an interleaved scan.
    across: usize,
    down: usize,
    /// Blocks of the whole channel.
    width: usize,
    height: usize,
    /// The last bit of each coefficient that a scan has brought; none: not yet any.
    bits: [Option<u8>; 64],
    /// Which coefficients of each block are not 0, blocks that only fill up the last units included.
    nonzero: Vec<u64>,
    /// Blocks in a row of `nonzero`.
    stride: usize,
}

struct Frame {
    is_progressive: bool,
    components: Vec<Component>,
    /// Units of an interleaved scan.
    units: (usize, usize),
}

impl Frame {
    fn parse(segment: &[u8], is_progressive: bool) -> Result<Self, String> {
        let size = be16(segment, 1).zip(be16(segment, 3)).zip(segment.get(5));
        let ((height, width), count) = size.ok_or_else(damaged)?;
        let (width, height) = (usize::from(width), usize::from(height));
        let parts = segment.get(6..6 + 3 * usize::from(*count)).ok_or_else(damaged)?;
        let factors = |part: &[u8]| (usize::from(part[1] >> 4), usize::from(part[1] & 15));
        let parts: Vec<(u8, (usize, usize))> =
            parts.chunks_exact(3).map(|part| (part[0], factors(part))).collect();
        let most_across = parts.iter().map(|(_, factor)| factor.0).max().unwrap_or(0);
        let most_down = parts.iter().map(|(_, factor)| factor.1).max().unwrap_or(0);
        if width == 0 || height == 0 || parts.iter().any(|(_, (x, y))| *x == 0 || *y == 0) {
            return Err(damaged());
        }
        let units = (width.div_ceil(8 * most_across), height.div_ceil(8 * most_down));
        let component = |(id, (across, down)): (u8, (usize, usize))| Component {
            id,
            across,
            down,
            width: (width * across).div_ceil(8 * most_across),
            height: (height * down).div_ceil(8 * most_down),
            bits: [None; 64],
            nonzero: Vec::new(),
            stride: units.0 * across,
        };
        let components = parts.into_iter().map(component).collect();
        Ok(Self { is_progressive, components, units })
    }

    /// What has not come, in words.
    fn missing(&self) -> Option<&'static str> {
        let bits = || self.components.iter().flat_map(|component| component.bits);
        if self.components.iter().any(|component| component.bits[0].is_none()) {
            return Some("a whole colour channel is missing");
        }
        let is_rough = self.is_progressive && bits().any(|bit| bit != Some(0));
        is_rough.then_some("scans that make the picture sharp are missing")
    }
}

/// Lengths and values of Huffman codes.
#[derive(Clone, Default)]
struct Table {
    counts: [u8; 16],
    values: Vec<u8>,
}

/// What a scan brings: coefficients from one to another, down to a bit.
#[derive(Clone, Copy)]
struct Band {
    from: usize,
    to: usize,
    is_first: bool,
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    frame: Option<Frame>,
    /// Tables for DC, then for AC coefficients.
    tables: [[Table; 4]; 2],
    /// Units between two restart markers; 0: there are none.
    restarts: usize,
}

impl<'a> Walk<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, frame: None, tables: Default::default(), restarts: 0 }
    }

    /// The next marker and what goes with it; none where the file ends before one.
    fn segment(&mut self) -> Result<Option<(u8, &'a [u8])>, String> {
        loop {
            // Whatever stands between segments is stepped over, as decoders do it.
            let Some(skipped) = self.bytes[self.at..].iter().position(|byte| *byte == 0xff) else {
                return Ok(None);
            };
            let start = self.at + skipped;
            let Some(marker) = self.bytes.get(start + 1).copied() else { return Ok(None) };
            match marker {
                0xff => self.at = start + 1,
                0x00 | 0x01 | 0xd0..=0xd7 | START => self.at = start + 2,
                END => return Ok(Some((END, &[]))),
                _ => {
                    let length = be16(self.bytes, start + 2).map_or(0, usize::from);
                    let segment = self.bytes.get(start + 4..start + 2 + length);
                    let Some(segment) = segment.filter(|_| length >= 2) else {
                        return Err(damaged());
                    };
                    self.at = start + 2 + length;
                    return Ok(Some((marker, segment)));
                }
            }
        }
    }

    fn define_tables(&mut self, mut segment: &[u8]) -> Result<(), String> {
        while let Some((head, rest)) = segment.split_first() {
            let counts: [u8; 16] =
                rest.get(..16).ok_or_else(damaged)?.try_into().map_err(|_| damaged())?;
            let total = counts.iter().map(|count| usize::from(*count)).sum::<usize>();
            let values = rest.get(16..16 + total).ok_or_else(damaged)?.to_vec();
            let tables = self.tables.get_mut(usize::from(head >> 4)).ok_or_else(damaged)?;
            *tables.get_mut(usize::from(head & 15)).ok_or_else(damaged)? = Table { counts, values };
            segment = &rest[16 + total..];
        }
        Ok(())
    }

    /// Walks through a scan.
    fn scan(&mut self, head: &[u8]) -> Result<(), String> {
        let Self { bytes, at, frame, tables, restarts } = self;
        let frame = frame.as_mut().ok_or_else(damaged)?;
        let count = usize::from(*head.first().ok_or_else(damaged)?);
        let [from, to, bits] = head.get(1 + 2 * count..4 + 2 * count).ok_or_else(damaged)? else {
            return Err(damaged());
        };
        let (high, low) = (bits >> 4, bits & 15);
        let (from, to) = (usize::from(*from), usize::from(*to));
        let band = match frame.is_progressive {
            true => Band { from, to, is_first: high == 0 },
            false => Band { from: 0, to: 63, is_first: true },
        };
        if band.from > band.to || band.to > 63 {
            return Err(damaged());
        }
        let mut parts = Vec::new();
        for part in head[1..1 + 2 * count].chunks_exact(2) {
            let found = frame.components.iter().position(|component| component.id == part[0]);
            let number = found.ok_or_else(damaged)?;
            let table = |kind: usize, number: u8| tables[kind].get(usize::from(number));
            let both = table(0, part[1] >> 4).zip(table(1, part[1] & 15));
            parts.push((number, both.ok_or_else(damaged)?));
        }
        let is_single = parts.len() == 1;
        let (across, down) = match parts[..] {
            [] => return Err(damaged()),
            [(number, _)] => (frame.components[number].width, frame.components[number].height),
            _ => frame.units,
        };
        let mut codes = Codes { bytes: &bytes[*at..], at: 0, bits: 0, left: 0 };
        let (mut zero_blocks, total) = (0, across * down);
        for unit in 0..total {
            if *restarts > 0 && unit > 0 && unit % *restarts == 0 {
                zero_blocks = 0;
                codes.restart().ok_or_else(|| cut(unit, total))?;
            }
            for (number, (dc, ac)) in &parts {
                let component = &mut frame.components[*number];
                let (x, y) = (unit % across, unit / across);
                let (columns, rows) =
                    if is_single { (1, 1) } else { (component.across, component.down) };
                for block in 0..columns * rows {
                    let (x, y) = (x * columns + block % columns, y * rows + block / columns);
                    let index = y * component.stride + x;
                    // Only as the file brings blocks, whatever size it claims.
                    if frame.is_progressive && component.nonzero.len() <= index {
                        component.nonzero.resize(index + 1, 0);
                    }
                    let walked = if frame.is_progressive {
                        codes.band(band, dc, ac, &mut component.nonzero[index], &mut zero_blocks)
                    } else {
                        codes.block(dc, ac)
                    };
                    walked.ok_or_else(|| cut(unit, total))?;
                }
            }
        }
        *at += codes.at;
        for (number, _) in parts {
            let low = if frame.is_progressive { low } else { 0 };
            frame.components[number].bits[band.from..=band.to].fill(Some(low));
        }
        Ok(())
    }
}

fn cut(unit: usize, total: usize) -> String {
    broken(format!("the JPEG's data end after {} % of a scan", 100 * unit / total))
}

/// Bits of a scan.
struct Codes<'a> {
    bytes: &'a [u8],
    at: usize,
    bits: u32,
    left: u32,
}

impl Codes<'_> {
    /// The next bit; none where a marker or the end of the file comes before it.
    fn bit(&mut self) -> Option<u32> {
        if self.left == 0 {
            let byte = *self.bytes.get(self.at)?;
            if byte == 0xff {
                if *self.bytes.get(self.at + 1)? != 0 {
                    return None;
                }
                self.at += 1;
            }
            self.at += 1;
            (self.bits, self.left) = (u32::from(byte), 8);
        }
        self.left -= 1;
        Some(self.bits >> self.left & 1)
    }

    fn bits(&mut self, count: u8) -> Option<u32> {
        (0..count).try_fold(0, |value, _| Some(value << 1 | self.bit()?))
    }

    fn code(&mut self, table: &Table) -> Option<u8> {
        let (mut code, mut first, mut index) = (0, 0, 0);
        for count in table.counts.map(u32::from) {
            code = code << 1 | self.bit()?;
            if code < first + count {
                return table.values.get((index + code - first) as usize).copied();
            }
            index += count;
            first = (first + count) << 1;
        }
        None
    }

    /// Steps over a restart marker.
    fn restart(&mut self) -> Option<()> {
        self.left = 0;
        let found = self
            .bytes
            .get(self.at..)?
            .windows(2)
            .position(|pair| pair[0] == 0xff && pair[1] != 0)?;
        let marker = self.bytes[self.at + found + 1];
        self.at += found + 2;
        (0xd0..=0xd7).contains(&marker).then_some(())
    }

    /// A block of a sequential scan.
    fn block(&mut self, dc: &Table, ac: &Table) -> Option<()> {
        let length = self.code(dc)?;
        self.bits(length)?;
        let mut at = 1;
        while at < 64 {
            let code = self.code(ac)?;
            let (zeros, length) = (usize::from(code >> 4), code & 15);
            if length == 0 && zeros < 15 {
                break;
            }
            at += zeros + 1;
            self.bits(length)?;
        }
        Some(())
    }

    /// A block of a progressive scan; `zero_blocks` more of them have no new coefficients.
    fn band(
        &mut self,
        band: Band,
        dc: &Table,
        ac: &Table,
        nonzero: &mut u64,
        zero_blocks: &mut u32,
    ) -> Option<()> {
        if band.from == 0 {
            let length = if band.is_first { self.code(dc)? } else { 1 };
            return self.bits(length).map(drop);
        }
        let mut at = band.from;
        while at <= band.to && *zero_blocks == 0 {
            let code = self.code(ac)?;
            let (zeros, length) = (code >> 4, code & 15);
            if length == 0 && zeros < 15 {
                *zero_blocks = (1 << zeros) + self.bits(zeros)?;
                break;
            }
            // The new coefficient, or only its sign where earlier scans had others.
            self.bits(length)?;
            at = self.skip(band, at, u32::from(zeros), *nonzero)?;
            if length > 0 && at <= band.to {
                *nonzero |= 1 << at;
            }
            at += 1;
        }
        if *zero_blocks > 0 {
            self.skip(band, at, u32::MAX, *nonzero)?;
            *zero_blocks -= 1;
        }
        Some(())
    }

    /// Steps over so many zeros, and over a bit of each coefficient between them that is not 0: to the place after
    /// them.
    fn skip(&mut self, band: Band, mut at: usize, mut zeros: u32, nonzero: u64) -> Option<usize> {
        while at <= band.to {
            if nonzero >> at & 1 == 1 {
                // A first scan never comes here: no coefficient has a value yet.
                self.bit()?;
            } else if zeros == 0 {
                break;
            } else {
                zeros -= 1;
            }
            at += 1;
        }
        Some(at)
    }
}
