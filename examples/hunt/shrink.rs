//! A failing scene made smaller as long as it fails in the same way: fewer drops, keys at their default, a smaller picture.

use std::collections::BTreeSet;

use toml::{Table, Value};

/// Edge of the window that is left of a picture, in pixels.
const WINDOW: u32 = 64;

/// Makes a scene's text smaller. `fails` says whether a text still fails; it is asked `most` times at most. `worst`: the pixel
/// of the whole picture where the error is largest. Returns the smallest text that fails, and how often `fails` was asked.
pub fn shrink(
    text: &str,
    worst: [u32; 2],
    most: u32,
    fails: &mut dyn FnMut(&str) -> bool,
) -> (String, u32) {
    let mut smallest = text.to_string();
    let mut tried = BTreeSet::new();
    let mut asked = 0;
    while let Ok(table) = smallest.parse::<Table>() {
        let mut found = None;
        for smaller in smaller(&table, worst) {
            let Ok(text) = toml::to_string(&smaller) else { continue };
            if asked >= most {
                break;
            }
            if text != smallest && tried.insert(text.clone()) {
                asked += 1;
                if fails(&text) {
                    found = Some(text);
                    break;
                }
            }
        }
        match found {
            Some(text) => smallest = text,
            None => break,
        }
    }
    (smallest, asked)
}

/// Scenes with something less, those with much less first.
fn smaller(table: &Table, worst: [u32; 2]) -> Vec<Table> {
    let mut all = Vec::new();
    all.extend(fewer_drops(table));
    all.extend(window(table, worst));
    // Whole tables, then keys.
    let is_table = |value: &Value| value.is_table() || value.is_array();
    for name in table.keys().filter(|name| is_table(&table[*name])) {
        // What a scene is of, or how large it is, is not a key at its default.
        if !["image", "drop"].contains(&&**name) && !is_only_drops(table, name) {
            all.push(without(table, &[name]));
        }
    }
    for (name, value) in table {
        match value {
            Value::Table(inner) => {
                // Without a window the picture is larger.
                let kept = |key: &str| name == "image" || ["rate", "window"].contains(&key);
                for key in inner.keys().filter(|key| !kept(key)) {
                    all.push(without(table, &[name, key]));
                }
            }
            Value::Array(list) => all.extend(simpler_items(table, name, list)),
            _ => all.push(without(table, &[name])),
        }
    }
    all.extend(halved(table, &["rain", "count"], 50));
    all.extend(smaller_picture(table));
    all
}

/// Whether the scene would show nothing without this table.
fn is_only_drops(table: &Table, name: &str) -> bool {
    name == "rain" && !table.contains_key("drop")
}

fn without(table: &Table, path: &[&str]) -> Table {
    let mut table = table.clone();
    match path {
        [name, key] => {
            if let Some(Value::Table(inner)) = table.get_mut(*name) {
                inner.remove(*key);
            }
        }
        [name] => {
            table.remove(*name);
        }
        _ => {}
    }
    table
}

/// Each half of the list of drops, then each without one of them.
fn fewer_drops(table: &Table) -> Vec<Table> {
    let Some(Value::Array(drops)) = table.get("drop") else { return Vec::new() };
    let with = |drops: Vec<Value>| {
        let mut table = table.clone();
        table.insert("drop".into(), Value::Array(drops));
        table
    };
    let count = drops.len();
    if count < 2 {
        return Vec::new();
    }
    let mut all = vec![with(drops[..count / 2].to_vec()), with(drops[count / 2..].to_vec())];
    if count <= 8 {
        let without = |at: usize| {
            let others = drops.iter().enumerate().filter(|(other, _)| *other != at);
            others.map(|(_, drop)| drop.clone()).collect()
        };
        all.extend((0..count).map(|at| with(without(at))));
    }
    all
}

/// A list of tables, one key less in all of them; and one table less of a list of populations.
fn simpler_items(table: &Table, name: &str, list: &[Value]) -> Vec<Table> {
    let keys: BTreeSet<&String> =
        list.iter().filter_map(Value::as_table).flat_map(Table::keys).collect();
    let mut all = Vec::new();
    for key in keys.into_iter().filter(|key| *key != "center" && *key != "radius") {
        let items = list.iter().map(|item| {
            let mut item = item.clone();
            item.as_table_mut().and_then(|item| item.remove(key));
            item
        });
        let mut table = table.clone();
        table.insert(name.into(), Value::Array(items.collect()));
        all.push(table);
    }
    if name == "rain" && list.len() > 1 {
        for kept in list {
            let mut table = table.clone();
            table.insert(name.into(), Value::Array(vec![kept.clone()]));
            all.push(table);
        }
    }
    all
}

/// A whole number halved, but not under the least.
fn halved(table: &Table, path: &[&str; 2], least: i64) -> Option<Table> {
    let mut table = table.clone();
    let value = table.get_mut(path[0])?.get_mut(path[1])?;
    let half = value.as_integer()? / 2;
    if half < least {
        return None;
    }
    *value = Value::Integer(half);
    Some(table)
}

fn image_size(table: &Table) -> Option<[u32; 2]> {
    let image = table.get("image")?;
    let edge = |key| image.get(key).and_then(Value::as_integer).unwrap_or(1024) as u32;
    Some([edge("width"), edge("height")])
}

/// The pixels around the worst place alone.
fn window(table: &Table, worst: [u32; 2]) -> Option<Table> {
    let size = image_size(table)?;
    let mut window = [Value::Float(0.0), Value::Float(0.0), Value::Float(1.0), Value::Float(1.0)];
    for axis in 0..2 {
        let edge = WINDOW.min(size[axis]);
        let low = worst[axis].saturating_sub(edge / 2).min(size[axis] - edge);
        let part = |at: u32| Value::Float(f64::from(at) / f64::from(size[axis]));
        (window[axis], window[axis + 2]) = (part(low), part(low + edge));
    }
    let mut table = table.clone();
    let camera = table.entry("camera").or_insert_with(|| Value::Table(Table::new()));
    camera.as_table_mut()?.insert("window".into(), Value::Array(window.to_vec()));
    Some(table)
}

/// A picture of half the edge.
fn smaller_picture(table: &Table) -> Option<Table> {
    let [width, height] = image_size(table)?;
    let has_window = table.get("camera").is_some_and(|camera| camera.get("window").is_some());
    if has_window || width.min(height) < 64 {
        return None;
    }
    let mut table = table.clone();
    let image = table.get_mut("image")?.as_table_mut()?;
    image.insert("width".into(), Value::Integer((width / 2).into()));
    image.insert("height".into(), Value::Integer((height / 2).into()));
    Some(table)
}
