//! What a scene file may hold, as a JSON Schema: from the types in this folder, their comments, defaults and ranges.
//!
//! Keywords of its own: `x-unit`; `x-advice`, which ends the message about a value out of range; `x-infinite` and `x-nan` for
//! numbers that may be `inf` or `nan`, which no other number may; and `x-default`. A key whose default is no fixed value has no
//! `default` in the schema: `x-default` says in words what holds where it is left out.

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

/// Takes out what TOML has not. TOML has no null: a key that may be null for serde may be left out instead. Defaults of a whole
/// table go, as its keys have their own. The lines of a comment become one text.
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
