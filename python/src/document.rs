//! A dict as a TOML document, so that scenes of Python are read by the one reader that scene files have.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use toml::{Table, Value};

/// A dict as a table; `place` is the key that it is the value of.
pub fn table(dict: &Bound<'_, PyDict>, place: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, item) in dict {
        let Ok(key) = key.extract::<String>() else {
            return Err(PyTypeError::new_err(format!("scene: a key is {key}, which is no text")));
        };
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        table.insert(key, value(&item, &place)?);
    }
    Ok(table)
}

/// A value as one of TOML.
pub fn value(item: &Bound<'_, PyAny>, place: &str) -> PyResult<Value> {
    if item.is_none() {
        return Err(PyTypeError::new_err(format!("scene: {place} is None; leave the key out")));
    }
    if let Ok(dict) = item.cast::<PyDict>() {
        return Ok(Value::Table(table(dict, place)?));
    }
    if item.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(item.extract()?));
    }
    if item.is_instance_of::<PyString>() {
        return Ok(Value::String(item.extract()?));
    }
    if item.is_instance_of::<PyInt>() {
        let number = item.extract().map_err(|_| {
            PyValueError::new_err(format!("scene: {place} = {item} does not fit into 64 bits"))
        })?;
        return Ok(Value::Integer(number));
    }
    if item.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(item.extract()?));
    }
    // Scalars and arrays of NumPy, tensors.
    if let Ok(plain) = item.call_method0("tolist")
        && !plain.is(item)
    {
        return value(&plain, place);
    }
    if let Ok(path) = item.call_method0("__fspath__") {
        return value(&path, place);
    }
    if let Ok(items) = item.try_iter() {
        let items = items.enumerate().map(|(n, item)| value(&item?, &format!("{place}[{n}]")));
        return items.collect::<PyResult<_>>().map(Value::Array);
    }
    let kind = item.get_type().name()?;
    Err(PyTypeError::new_err(format!("scene: {place} is a {kind}, which no scene has")))
}

/// Sets a key with its tables, such as `rain.rate`; the problem in words.
pub fn set(document: &mut Table, key: &str, value: Value) -> Result<(), String> {
    let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = document;
    for name in tables.split('.').filter(|name| !name.is_empty()) {
        let entry = table.entry(name).or_insert_with(|| Value::Table(Table::new()));
        table = entry.as_table_mut().ok_or_else(|| format!("{key}: {name} is no table"))?;
    }
    table.insert(last.into(), value);
    Ok(())
}

/// What stands in a line of a document that nobody sees: `[rain] rate = -1.0`.
pub fn line(text: &str, number: usize) -> String {
    let lines: Vec<&str> = text.lines().take(number).collect();
    let Some((last, before)) = lines.split_last() else { return String::new() };
    let is_header = |line: &&&str| line.starts_with('[') && line.ends_with(']');
    match before.iter().rev().find(is_header) {
        Some(header) if !is_header(&last) => format!("{header} {last}"),
        _ => (*last).into(),
    }
}
