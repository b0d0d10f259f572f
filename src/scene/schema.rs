//! What a scene file may hold, as a JSON Schema: from the types in this folder, their comments, defaults and ranges.
//!
//! Keywords of its own: `x-unit`, `x-advice` for who gives a value out of range, and `x-infinite` and `x-nan` for numbers that
//! may be what all others may not, which TOML has. A key that nothing is said of has no default in the schema; what then holds is said in `x-default`.

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::{Value, json};

use super::Scene;

/// Keywords about one number.
const OF_NUMBERS: [&str; 7] =
    ["minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "x-unit", "x-infinite", "x-nan"];

/// The schema of scene files: JSON Schema 2020-12. Editors complete and check scenes by it.
pub fn schema() -> Value {
    let settings = SchemaSettings::draft2020_12()
        .with_transform(RecursiveTransform(as_toml))
        .with_transform(RecursiveTransform(limits_of_items));
    let mut schema = settings.into_generator().into_root_schema_for::<Scene>();
    schema.insert("title".into(), json!("A scene of raindrops"));
    schema.to_value()
}

/// TOML has no null: what may be left out is left out. A table's defaults are those of its keys, and a comment's lines one
/// text.
fn as_toml(schema: &mut Schema) {
    let is_null = |kind: &Value| *kind == "null" || kind.get("type").is_some_and(|t| t == "null");
    for list in ["type", "anyOf"] {
        let Some(Value::Array(kinds)) = schema.get_mut(list) else { continue };
        kinds.retain(|kind| !is_null(kind));
        let [one] = &kinds[..] else { continue };
        let one = one.clone();
        schema.remove(list);
        match one {
            Value::Object(keys) => keys.into_iter().for_each(|(key, value)| {
                schema.insert(key, value);
            }),
            kind => drop(schema.insert(list.into(), kind)),
        }
    }
    schema.remove("format");
    if schema.get("default").is_some_and(|default| default.is_null() || default.is_object()) {
        schema.remove("default");
    }
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.replace('\n', " ");
    }
}

/// What is said of a list of numbers holds for each of them.
fn limits_of_items(schema: &mut Schema) {
    if schema.get("type").is_none_or(|kind| kind != "array") {
        return;
    }
    for keyword in OF_NUMBERS {
        let Some(value) = schema.remove(keyword) else { continue };
        if let Some(Value::Object(items)) = schema.get_mut("items") {
            items.insert(keyword.into(), value);
        }
    }
}
