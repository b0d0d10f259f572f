//! CSV: a row of names, then a row for each particle.

use csv::{ReaderBuilder, Trim};

use super::table::{Table, is_used};

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
    if first.is_empty() || std::str::from_utf8(first).is_err() {
        return Err("it is no PLY, NPY, NPZ or CSV file".into());
    }
    let delimiter =
        [b';', b'\t'].into_iter().find(|mark| first.contains(mark) && !first.contains(&b','));
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter.unwrap_or(b','))
        .trim(Trim::All)
        .comment(None)
        .from_reader(bytes);
    let names = reader.headers().map_err(|error| error.to_string())?.clone();
    let used: Vec<usize> = (0..names.len()).filter(|at| is_used(&names[*at])).collect();
    let mut columns = vec![Vec::new(); used.len()];
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| error.to_string())? {
        let line = record.position().map_or(0, csv::Position::line);
        for (column, at) in columns.iter_mut().zip(&used) {
            let text = &record[*at];
            let value = text
                .parse()
                .map_err(|_| format!("line {line}: {} = '{text}' is no number", &names[*at]))?;
            column.push(value);
        }
    }
    let mut table = Table::default();
    for (column, at) in columns.into_iter().zip(used) {
        table.add(&names[at], column)?;
    }
    if table.is_empty() {
        let names: Vec<&str> = names.iter().take(8).collect();
        return Err(format!(
            "its first line names no columns of particles (x, y, z): {}",
            names.join(", ")
        ));
    }
    Ok(table)
}
