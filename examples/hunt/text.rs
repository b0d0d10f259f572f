//! A scene as the text of a scene file that names only what differs from the default, so that a small scene is a short file.

use raindrops::scene::{RainSettings, Scene};
use toml::{Table, Value};

/// The text that `Scene::parse` reads as this scene.
pub fn of(scene: &Scene) -> String {
    let mut scene = scene.clone();
    if scene.rain.is_none() && scene.drops.is_empty() {
        // Left out, rain would be the default one.
        scene.rain = Some(RainSettings { count: 0, ..RainSettings::default() });
    }
    let mut table = table_of(&scene);
    let mut usual = table_of(&Scene::default());
    // Rain and drops have defaults that depend on each other.
    usual.remove("rain");
    without(&mut table, &usual);
    toml::to_string(&table).expect("a table is TOML")
}

fn table_of(scene: &Scene) -> Table {
    Table::try_from(scene).expect("a scene is TOML")
}

/// Leaves out what is as in `usual`.
fn without(table: &mut Table, usual: &Table) {
    table.retain(|key, value| match (value, usual.get(key)) {
        (Value::Table(inner), Some(Value::Table(usual))) => {
            without(inner, usual);
            !inner.is_empty()
        }
        (value, Some(usual)) => value != usual,
        (_, None) => true,
    });
}
