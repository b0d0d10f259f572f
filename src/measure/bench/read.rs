//! Result files read back, each mistake in one line.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::report::{Report, Round, SCHEMA};
use crate::files::read_text;
use crate::{Error, Result};

/// Reads a result file of `bench --json`: one device's, or with `--device all` a list of several.
///
/// # Errors
/// [`Error::File`] naming the file: if it cannot be read, is empty, ends in the middle, is no result of
/// this program or of another schema, lacks a key, or holds a time that is none.
pub fn read(path: &Path) -> Result<Vec<Report>> {
    let value = read_json(path)?;
    let values = match value {
        Value::Array(values) if values.is_empty() => {
            return Err(Error::read(path, "it is a list without results"));
        }
        Value::Array(values) => values,
        one => vec![one],
    };
    values.into_iter().map(|value| of_value(path, value)).collect()
}

/// One device's result from a file's JSON.
///
/// # Errors
/// Like [`read`].
pub fn of_value(path: &Path, value: Value) -> Result<Report> {
    let mut report: Report = of_schema(path, value, SCHEMA)?;
    check(&report).map_err(|problem| Error::read(path, problem))?;
    // Files of the first version have no rounds: each was one process.
    for row in report.rows.iter_mut().filter(|row| row.rounds.is_empty()) {
        let (start, passes) = (report.start.clone(), row.passes.clone());
        row.rounds.push(Round { start, load: None, median_ms: row.median_ms, passes });
    }
    Ok(report)
}

/// Reads a file's JSON, whatever its schema.
///
/// # Errors
/// Like [`read`].
pub fn read_json(path: &Path) -> Result<Value> {
    let text = read_text(path)?;
    if text.trim_ascii().is_empty() {
        return Err(Error::read(path, "it is empty; write it again by bench --json"));
    }
    serde_json::from_str(&text).map_err(|error| {
        let what = match error.is_eof() {
            true => format!("it ends in the middle, at line {}; write it again", error.line()),
            false => format!("it is no JSON: {error}"),
        };
        Error::read(path, what)
    })
}

/// The value of a file as the type of `schema`.
///
/// # Errors
/// [`Error::File`] if it is of another schema or none, or lacks a key.
pub fn of_schema<T: DeserializeOwned>(path: &Path, value: Value, schema: &str) -> Result<T> {
    match value.get("schema").and_then(Value::as_str) {
        None => {
            let problem = format!("it is no result of raindrops: it names no schema, not {schema}");
            return Err(Error::read(path, problem));
        }
        Some(found) if found != schema => {
            let problem = format!("its schema is {found}; {schema} is needed here");
            return Err(Error::read(path, problem));
        }
        Some(_) => {}
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let place = error.path().to_string();
        // The path is a dot where the error concerns the whole file.
        let place = if place == "." { String::new() } else { format!("{place}: ") };
        Error::read(path, format!("{place}{}", error.into_inner()))
    })
}

/// Times that can be compared.
fn check(report: &Report) -> Result<(), String> {
    if report.rows.is_empty() {
        return Err("it has no rows".into());
    }
    for (number, row) in report.rows.iter().enumerate() {
        let rounds = row.rounds.iter().map(|round| round.median_ms);
        let times = std::iter::once(row.median_ms).chain(rounds);
        for ms in times {
            if !(ms.is_finite() && ms > 0.0) {
                return Err(format!("rows[{number}]: a median of {ms} ms is none"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: &str = r#"{"schema": "raindrops-bench/1",
        "device": {"name": "D", "driver": "V", "driver_info": "1", "api_version": "1.3.0", "type": "CPU"},
        "build": {"version": "0.1.0", "commit": "unknown"},
        "host": {"cpu": "C", "cores": 2, "os": "O"},
        "rows": [{"preset": "paper", "optics": "mask", "primitive": "point", "order": "unsorted",
            "drops": 1, "visible": 1, "width": 4, "height": 4, "tone_map": true,
            "samples_ms": [1.0], "median_ms": 1.0, "p10_ms": 1.0, "p90_ms": 1.0, "fps": 1000.0}]}"#;

    fn tried(text: &str) -> Result<Vec<Report>> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("result.json");
        crate::files::write_whole(&path, text.as_bytes()).expect("a file");
        read(&path)
    }

    /// The keys of the first version are enough.
    #[test]
    fn the_oldest_file_is_read() {
        let reports = tried(SOUND).expect("a result");
        assert_eq!(reports[0].rows[0].median_ms, 1.0);
        assert_eq!(reports[0].rows[0].rounds.len(), 1, "it was one process");
        assert_eq!(tried(&format!("[{SOUND},{SOUND}]")).expect("two").len(), 2);
    }

    #[test]
    fn each_mistake_is_named() {
        let cases = [
            ("", "it is empty"),
            (" \n", "it is empty"),
            (&SOUND[..SOUND.len() - 40], "ends in the middle"),
            ("rubbish", "no JSON"),
            ("[]", "list without results"),
            ("{}", "names no schema"),
            ("3", "names no schema"),
            (r#"{"schema": "raindrops-tradeoff/1"}"#, "raindrops-tradeoff/1; raindrops-bench/1 is"),
            (&SOUND.replace("bench/1", "bench/2"), "raindrops-bench/2"),
            (&SOUND.replace("\"median_ms\": 1.0", "\"median_ms\": \"1\""), "rows[0].median_ms"),
            (&SOUND.replace("\"median_ms\": 1.0", "\"median_ms\": 0.0"), "0 ms is none"),
            (&SOUND.replace("\"drops\": 1,", ""), "missing field `drops`"),
            (r#"{"schema": "raindrops-bench/1"}"#, "result.json: missing field `device`"),
            (&format!("[{SOUND}, 3]"), "names no schema"),
        ];
        for (text, words) in cases {
            let error = tried(text).expect_err(words).to_string();
            assert!(error.contains(words) && error.contains("result.json"), "{error}: {words}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
