//! PLY, ascii and binary of both orders: the first element that has positions.

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::table::{Table, has_positions, is_used};

/// The numbers of an element, in the order of its properties. Lists are left out: elements that have one are not read.
#[derive(Default)]
struct Row(Vec<f64>);

/// A row of elements that are not read.
struct Nothing;

macro_rules! pushes {
    ($($setter:ident: $type:ty),*) => {$(
        fn $setter(&mut self, _: &str, value: $type) -> PropertyAccessResult {
            self.0.push(value.into());
            PropertyAccessResult::Set
        }
    )*};
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self(Vec::with_capacity(8))
    }

    pushes!(set_char: i8, set_uchar: u8, set_short: i16, set_ushort: u16, set_int: i32, set_uint: u32, set_float: f32,
        set_double: f64);
}

impl PropertyAccess for Nothing {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let failed = |error: ply_rs_bw::parser::ParseError| {
        let text = error.to_string();
        // What its grammar expected instead says nothing to who wrote the file.
        let row = text
            .split_once("Couldn't parse element line")
            .and_then(|(_, rest)| rest.split('\'').nth(1));
        match (error.line(), row) {
            (Some(line), Some(row)) => {
                format!("line {line}: '{}' is no row of finite numbers", row.trim())
            }
            _ => text,
        }
    };
    let (rows, others) = (Parser::<Row>::new(), Parser::<Nothing>::new());
    let mut reader = Reader::new(bytes);
    let header = rows.read_header(&mut reader).map_err(failed)?;
    for element in header.elements.values() {
        let names: Vec<&String> = element.properties.keys().collect();
        // Nothing is stored of such a one, however many there are said to be.
        if names.is_empty() {
            continue;
        }
        if !has_positions(names.iter().map(|name| &***name)) {
            others.read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
            continue;
        }
        let lists = element
            .properties
            .values()
            .find(|property| matches!(property.data_type, PropertyType::List(..)));
        if let Some(list) = lists {
            return Err(format!(
                "the property {} of its element {} is a list; write one number a particle",
                list.name, element.name
            ));
        }
        let mut columns = vec![Vec::new(); names.len()];
        for row in rows.read_payload_for_element(&mut reader, element, &header).map_err(failed)? {
            columns.iter_mut().zip(row.0).for_each(|(column, value)| column.push(value));
        }
        let mut table = Table::default();
        for (name, column) in names.into_iter().zip(columns).filter(|(name, _)| is_used(name)) {
            table.add(name, column)?;
        }
        return Ok(table);
    }
    let names: Vec<&str> = header.elements.keys().map(|name| &**name).collect();
    Err(format!("none of its elements has positions (x y z): {}", names.join(", ")))
}
