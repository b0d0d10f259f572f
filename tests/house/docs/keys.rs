//! The tables of keys in `docs/scene.md`, and `assets/scene.schema.json`: as the program's schema has them.
//!
//! `RAINDROPS_WRITE_KEYS=1 cargo test --test house keys` writes both.

use std::fs;

use raindrops::scene::{Scene, schema};
use serde_json::Value;

use super::root;

/// Writes the file if that is asked for, else compares.
fn hold(path: &str, text: &str) {
    let path = root().join(path);
    if std::env::var_os("RAINDROPS_WRITE_KEYS").is_some() {
        fs::write(&path, text).expect("written");
    }
    let kept = fs::read_to_string(&path).expect("the file");
    assert!(
        kept == text,
        "{} is not the schema's: RAINDROPS_WRITE_KEYS=1 writes it",
        path.display()
    );
}

fn resolved<'a>(schema: &'a Value, part: &'a Value) -> &'a Value {
    let place = part.get("$ref").and_then(Value::as_str);
    place.map_or(part, |place| schema.pointer(place.trim_start_matches('#')).expect("a definition"))
}

/// The keys of a table, or of the scene itself, with what is said of each.
fn keys<'a>(schema: &'a Value, table: &str) -> Vec<(String, &'a Value)> {
    let of = |part: &'a Value| part["properties"].as_object().into_iter().flatten();
    if table.is_empty() {
        let plain =
            |part: &&Value| !matches!(part["type"].as_str(), None | Some("array" | "object"));
        return of(schema)
            .filter(|(_, part)| plain(part))
            .map(|(key, part)| (key.clone(), part))
            .collect();
    }
    let mut part = schema;
    for name in table.split('.') {
        part = resolved(schema, &part["properties"][name]);
        // A key for one table or several leads to the one.
        part = part.get("anyOf").map_or(part, |either| resolved(schema, &either[0]));
        part = part.get("items").map_or(part, |item| resolved(schema, item));
    }
    of(part).map(|(key, part)| (format!("{table}.{key}"), part)).collect()
}

fn text(value: &Value) -> String {
    match value {
        Value::Array(items) => items.iter().map(text).collect::<Vec<_>>().join(" "),
        Value::String(word) => format!("`{word}`"),
        Value::Number(number) if number.as_u64() > Some(9999) => {
            let digits = number.to_string();
            let parts = digits.as_bytes().rchunks(3).rev();
            parts.map(String::from_utf8_lossy).collect::<Vec<_>>().join(",")
        }
        Value::Number(number) => {
            number.to_string().trim_end_matches(".0").replace(".0e", "e").to_string()
        }
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

/// What a key may be: its names, or its range and unit.
fn limits(schema: &Value, part: &Value) -> String {
    let kind = resolved(schema, part);
    let part = kind.get("anyOf").map_or(part, |_| kind);
    let names = kind.get("oneOf").or(kind.get("enum")).and_then(Value::as_array);
    if let Some(names) = names {
        let names = names.iter().flat_map(|name| {
            let each = name.get("enum").and_then(Value::as_array).cloned();
            each.unwrap_or_else(|| vec![name.get("const").unwrap_or(name).clone()])
        });
        return names.map(|name| text(&name)).collect::<Vec<_>>().join(", ");
    }
    // A key for a number or a list of them has the number's limits.
    let one = part.get("anyOf").map_or(part, |either| &either[0]);
    let of = part.get("items").unwrap_or(one);
    let limit = |name: &str| of.get(name).map(text);
    let most = limit("maximum").or(limit("exclusiveMaximum").map(|most| format!("under {most}")));
    let mut words = match (limit("minimum"), limit("exclusiveMinimum"), most) {
        (Some(least), _, Some(most)) => format!("{least} to {most}"),
        (_, Some(over), Some(most)) if most.starts_with("under") => format!("over {over}, {most}"),
        (_, Some(over), Some(most)) => format!("over {over}, up to {most}"),
        (_, Some(over), None) => format!("over {over}"),
        (Some(least), _, None) => format!("at least {least}"),
        (None, None, Some(most)) => format!("up to {most}"),
        (None, None, None) => String::new(),
    };
    if let Some(unit) = of.get("x-unit").and_then(Value::as_str) {
        words = format!("{words} {unit}");
    }
    if of.get("x-infinite").is_some() {
        words.push_str(", may be `inf`");
    }
    if of.get("x-nan").is_some() {
        words.push_str(" or `nan`");
    }
    words.trim_start_matches([' ', ',']).to_string()
}

fn row(schema: &Value, key: &str, part: &Value) -> String {
    let told = part.get("x-default").and_then(Value::as_str);
    let default = told.map_or_else(|| text(&part["default"]), String::from);
    let meaning = part["description"].as_str().unwrap_or_else(|| panic!("{key} has no meaning"));
    format!("| `{key}` | {default} | {} | {meaning} |\n", limits(schema, part))
}

/// After a line `<!-- keys: … -->` there is a table of all keys of the tables that it names, or of the keys.
#[test]
fn the_tables_of_keys_are_the_schemas() {
    let schema = schema();
    let document = fs::read_to_string(root().join("docs/scene.md")).expect("the page");
    let (mut written, mut listed) = (String::new(), Vec::new());
    let mut in_table = false;
    for line in document.lines() {
        in_table &= line.starts_with('|');
        if in_table {
            continue;
        }
        written.push_str(line);
        written.push('\n');
        let Some(names) = line.strip_prefix("<!-- keys:").and_then(|rest| rest.strip_suffix("-->"))
        else {
            continue;
        };
        in_table = true;
        written.push_str("| key | default | range and unit | meaning |\n|---|---|---|---|\n");
        for name in names.split_whitespace() {
            let (table, one) = match name.strip_suffix(".*") {
                Some(table) => (table, None),
                None => name.split_once('.').map_or((name, None), |(of, _)| (of, Some(name))),
            };
            let table = if table == "scene" { "" } else { table };
            for (key, part) in keys(&schema, table) {
                if one.is_none_or(|one| one == key) {
                    written.push_str(&row(&schema, &key, part));
                    listed.push(key);
                }
            }
        }
    }
    hold("docs/scene.md", &written);
    let tables = schema["properties"].as_object().expect("tables");
    let of_tables = tables.keys().flat_map(|table| keys(&schema, table));
    let mut all: Vec<String> =
        keys(&schema, "").into_iter().chain(of_tables).map(|(key, _)| key).collect();
    // What the tables in a list hold stands in tables of its own.
    listed.retain(|key| key.matches('.').count() < 2);
    all.retain(|key| !document.contains(&format!("<!-- keys: {key}.* -->")));
    all.sort();
    listed.sort();
    assert_eq!(listed, all, "left: docs/scene.md; right: the schema, each key once");
}

#[test]
fn the_kept_schema_is_the_programs() {
    let text = serde_json::to_string_pretty(&schema()).expect("JSON");
    hold("assets/scene.schema.json", &format!("{text}\n"));
}

/// TOML as JSON; infinity, which JSON has not, as a large number.
fn as_json(value: &toml::Value) -> Value {
    match value {
        toml::Value::Float(number) if !number.is_finite() => Value::from(1e300),
        toml::Value::Table(table) => {
            table.iter().map(|(key, value)| (key.clone(), as_json(value))).collect()
        }
        toml::Value::Array(items) => items.iter().map(as_json).collect(),
        other => serde_json::to_value(other).expect("JSON"),
    }
}

/// By a reader that knows nothing of this program: what it takes and refuses is what [`Scene::parse`] does.
#[test]
fn editors_check_scenes_as_the_program_does() {
    let validator = jsonschema::validator_for(&schema()).expect("a schema");
    let takes = |text: &str| {
        let table: toml::Table = text.parse().expect("TOML");
        validator.is_valid(&as_json(&table.into()))
    };
    let mut scenes = 0;
    for entry in fs::read_dir(root().join("assets/scenes")).expect("scenes") {
        let path = entry.expect("a file").path();
        let text = fs::read_to_string(&path).expect("a scene");
        assert!(
            text.starts_with("#:schema ../scene.schema.json\n"),
            "{}: its first line",
            path.display()
        );
        assert!(takes(&text), "{}", path.display());
        scenes += 1;
    }
    assert!(scenes > 8, "{scenes} scenes");
    for text in [
        "metres = 0.0",
        "[camera]\nvertical_fov = 176",
        "[camera]\nposition = [0, 1]",
        "[camera]\nzoom = 2",
        "[image]\nwidth = 0",
        "[model]\npreset = \"best\"",
        "[model]\nerror = 0",
        "[model]\nsamples = 257",
        "[water]\nindex = [1.3, 1.3, 0.9]",
        "[rain]\nrate = 3000",
        "[rain]\nmu = -1",
        "[rain]\ncount = 2000000000",
        "[[rain]]\n[[rain]]\nradius = 0",
        "[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = 21",
        "[[drop]]\nradius = 1",
        "[[film.camera]]\nat = 0",
        "[tone_map]\nexposure = 0",
        "[particles]\nfile = \"a.ply\"\nfps = 0",
    ] {
        assert!(!takes(text), "an editor takes {text}");
        assert!(Scene::parse(text, "it").is_err(), "the program takes {text}");
    }
    for text in [
        "",
        "[camera]\nfocus = inf",
        "[rain]\nrate = 5\nextent = inf",
        "[water]\nindex = 1.5",
        "[[rain]]\n[[rain]]",
    ] {
        assert!(takes(text), "an editor refuses {text}");
        Scene::parse(text, "it").expect("a scene");
    }
}
