//! NPY: structured, or three columns, which are positions. NPZ: one array a name.

use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar, TypeStr};
use zip::ZipArchive;

use super::MOST;
use super::table::{Table, is_used};
use crate::thousands::thousands;

/// A number in an item.
struct Field {
    name: String,
    /// Bytes from the item's begin.
    at: usize,
    kind: TypeStr,
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let mut table = Table::default();
    add_array(&mut table, "", bytes)?;
    Ok(table)
}

pub(super) fn read_archive(bytes: &[u8]) -> Result<Table, String> {
    let failed = |error: zip::result::ZipError| error.to_string();
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(failed)?;
    let mut table = Table::default();
    for number in 0..archive.len() {
        let file = archive.by_index(number).map_err(failed)?;
        let file_name = file.name().map_err(failed)?.into_owned();
        let Some(name) = file_name.strip_suffix(".npy") else { continue };
        add_array(&mut table, name, file).map_err(|problem| format!("{name}: {problem}"))?;
    }
    Ok(table)
}

/// Longest header: one of particles has a line of some hundred characters.
const MOST_HEADER: u32 = 1 << 14;

fn header_of(from: &mut impl Read) -> Result<NpyHeader, String> {
    let failed = |error: std::io::Error| error.to_string();
    let mut head = [0; 12];
    from.read_exact(&mut head).map_err(failed)?;
    let length = match head[6] {
        1 => u16::from_le_bytes([head[8], head[9]]).into(),
        _ => u32::from_le_bytes([head[8], head[9], head[10], head[11]]),
    };
    if length > MOST_HEADER {
        return Err(format!("its header claims {} bytes", thousands(length.into())));
    }
    let mut from = (&head[..]).chain(from);
    // Where sums are checked, a shape beyond 64 bits is a panic there.
    catch_unwind(AssertUnwindSafe(|| NpyHeader::from_reader(&mut from)))
        .map_err(|_| "its header is of no array that could be".to_owned())?
        .map_err(failed)
}

/// Adds the columns of an array. Memory is taken for what is read, not for what the header claims.
fn add_array(table: &mut Table, name: &str, mut from: impl Read) -> Result<(), String> {
    let header = header_of(&mut from)?;
    let (dtype, shape) = (header.dtype(), header.shape());
    let item = dtype.num_bytes().ok_or("its items have no fixed size")?;
    let mut fields = Vec::new();
    flatten(&mut fields, name, 0, &dtype)?;
    let is_plain = matches!(dtype, DType::Plain(_));
    if is_plain && !name.is_empty() && !is_used(name) && !is_used(&format!("{name}x")) {
        return Ok(());
    }
    let (count, across) = match *shape {
        [count] | [count, 1] => (count, 1),
        [count, 3] if is_plain => (count, 3),
        _ => return Err(format!("its shape is {shape:?}, neither (n,) nor (n, 3)")),
    };
    if count > MOST {
        return Err(format!("it claims {} particles, over {}", thousands(count), thousands(MOST)));
    }
    let size = (count * across).checked_mul(item as u64).ok_or("its items are too large")?;
    let mut bytes = Vec::new();
    from.take(size).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 != size {
        let [claimed, there] = [size, bytes.len() as u64].map(thousands);
        return Err(format!("its header claims {claimed} bytes, and {there} follow"));
    }
    if across == 1 {
        for field in fields.iter().filter(|field| is_used(&field.name)) {
            let items = bytes.chunks_exact(item).map(|item| number(&item[field.at..], &field.kind));
            table.add(&field.name, items.collect::<Result<_, _>>()?)?;
        }
        return Ok(());
    }
    let DType::Plain(kind) = &dtype else { return Ok(()) };
    for axis in 0..across {
        let column = format!("{name}{}", ["x", "y", "z"][axis as usize]);
        let place = |row: u64| match header.order() {
            Order::C => row * across + axis,
            Order::Fortran => axis * count + row,
        };
        let values = (0..count).map(|row| number(&bytes[place(row) as usize * item..], kind));
        table.add(&column, values.collect::<Result<_, _>>()?)?;
    }
    Ok(())
}

/// The numbers of an item one after the other; of a vector by the names of its axes.
fn flatten(fields: &mut Vec<Field>, name: &str, at: usize, dtype: &DType) -> Result<(), String> {
    match dtype {
        DType::Plain(kind) => fields.push(Field { name: name.into(), at, kind: kind.clone() }),
        DType::Array(3, inner) if matches!(**inner, DType::Plain(_)) => {
            let size = inner.num_bytes().ok_or("its items have no fixed size")?;
            for (number, axis) in ["x", "y", "z"].iter().enumerate() {
                flatten(fields, &format!("{name}{axis}"), at + number * size, inner)?;
            }
        }
        // Other arrays hold nothing that particles need.
        DType::Array(..) => {}
        DType::Record(all) => {
            let mut at = at;
            for field in all {
                flatten(fields, &field.name, at, &field.dtype)?;
                at += field.dtype.num_bytes().ok_or("its items have no fixed size")?;
            }
        }
    }
    Ok(())
}

/// The number that some bytes begin with.
fn number(bytes: &[u8], kind: &TypeStr) -> Result<f64, String> {
    let size = kind.size_field() as usize;
    let mut own = [0; 8];
    let bytes = bytes.get(..size).filter(|_| size <= 8).ok_or_else(|| no_number(kind))?;
    own[..size].copy_from_slice(bytes);
    if kind.endianness() == Endianness::Big {
        own[..size].reverse();
    }
    let bits = u64::from_le_bytes(own);
    Ok(match (kind.type_char(), size) {
        (TypeChar::Float, 2) => half::f16::from_bits(bits as u16).to_f64(),
        (TypeChar::Float, 4) => f32::from_bits(bits as u32).into(),
        (TypeChar::Float, 8) => f64::from_bits(bits),
        (TypeChar::Uint, 1 | 2 | 4 | 8) => bits as f64,
        (TypeChar::Int, 1) => f64::from(bits as i8),
        (TypeChar::Int, 2) => f64::from(bits as i16),
        (TypeChar::Int, 4) => f64::from(bits as i32),
        (TypeChar::Int, 8) => bits as i64 as f64,
        _ => return Err(no_number(kind)),
    })
}

fn no_number(kind: &TypeStr) -> String {
    format!("its type {kind} is no number of up to 64 bits")
}
