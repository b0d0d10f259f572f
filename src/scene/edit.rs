//! A scene file with some of its keys set otherwise, as `--set key=value` has it: the document is edited before it is
//! read, so that what is wrong with a value is said as of the file's own.

use std::path::Path;

#[cfg(feature = "cli")]
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

use super::Scene;
use crate::files::read_text;
use crate::{Error, Result};

/// Keys whose values are paths: of a scene file from its folder, of an edit from the working folder.
const PATHS: [&str; 5] = [
    "environment.file",
    "background.color",
    "background.depth",
    "particles.file",
    "shelter.height",
];

impl Scene {
    /// The scene of a file, or the default one, with keys set; its particles and its shelter's map are not read yet. Each edit is
    /// `table.key=value`; the value is TOML, numbers with commas between them, or a bare word.
    ///
    /// # Errors
    /// See [`Scene::load`]; [`Error::Scene`] for an edit that is none, or leads to no scene.
    pub fn load_edited(path: Option<&Path>, edits: &[String]) -> Result<Self> {
        // The file is first read alone, so that an error in it names its line.
        let scene = path.map_or_else(|| Ok(Self::default()), Self::load_alone)?;
        if edits.is_empty() {
            return Ok(scene);
        }
        let refuse = |problem: String| Error::Scene { place: "--set".into(), problem };
        let mut document = match path {
            Some(path) => read_text(path)?.parse().map_err(|_| refuse("no scene".into()))?,
            None => Table::new(),
        };
        for edit in edits {
            set(&mut document, edit).map_err(refuse)?;
        }
        let text = toml::to_string(&document).map_err(|error| refuse(error.to_string()))?;
        let edited = Self::parse_in(&text, "--set", path.and_then(Path::parent));
        edited.map_err(|error| match error {
            // The line is of the edited document, which nobody sees.
            Error::Scene { problem, .. } => refuse(format!("{}: {problem}", edits.join(" "))),
            other => other,
        })
    }
}

/// Sets a key of a document.
fn set(document: &mut Table, edit: &str) -> std::result::Result<(), String> {
    let wrong = || format!("'{edit}' is no key=value, such as rain.rate=50");
    let (key, value) = edit.split_once('=').ok_or_else(wrong)?;
    let key = key.trim();
    let mut value = parse(value.trim());
    if let (true, Value::String(file)) = (PATHS.contains(&key), &value) {
        let path = std::path::absolute(file).map_err(|error| format!("{edit}: {error}"))?;
        value = Value::String(path.display().to_string());
    }
    let mut names: Vec<&str> = key.split('.').collect();
    let last = names.pop().filter(|name| !name.is_empty()).ok_or_else(wrong)?;
    let mut table = document;
    for name in names {
        let entry = table.entry(name).or_insert_with(|| Value::Table(Table::new()));
        table = entry.as_table_mut().ok_or_else(|| format!("{edit}: {name} is no table"))?;
    }
    table.insert(last.into(), value);
    Ok(())
}

/// A table of a scene with some of its keys set, each to a text as in [`Scene::load_edited`].
///
/// # Errors
/// What is wrong with a key or its value, in words.
#[cfg(feature = "cli")]
pub(crate) fn with_keys<T: Serialize + DeserializeOwned>(
    table: &T,
    keys: &[(&str, &str)],
) -> std::result::Result<T, String> {
    let mut edited = Table::try_from(table).map_err(|error| error.to_string())?;
    edited.extend(keys.iter().map(|(key, text)| (key.to_string(), parse(text))));
    edited.try_into().map_err(|error: toml::de::Error| super::lines::mend(error.message()))
}

/// TOML, or numbers with commas between them, or a bare word.
fn parse(text: &str) -> Value {
    let value = |text: &str| format!("value = {text}").parse::<Table>().ok()?.remove("value");
    let list = || value(&format!("[{text}]")).filter(|_| text.contains(','));
    value(text).or_else(list).unwrap_or_else(|| Value::String(text.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edited(edits: &[&str]) -> Result<Scene> {
        let edits: Vec<String> = edits.iter().map(|edit| edit.to_string()).collect();
        Scene::load_edited(None, &edits)
    }

    #[test]
    fn values_are_toml_lists_or_words() {
        let scene = edited(&[
            "camera.position=0,2,0",
            "camera.target = [1.0, 2.0, 3.0]",
            "rain.rate=50",
            "rain.sizes=gamma",
            "model.preset=\"fast\"",
            "seed=7",
        ]);
        let scene = scene.expect("a scene");
        assert_eq!(scene.camera.position.to_array(), [0.0, 2.0, 0.0]);
        assert_eq!(scene.camera.target.to_array(), [1.0, 2.0, 3.0]);
        let rain = scene.real_rain().expect("rain by its rate");
        assert_eq!((rain.rate, rain.sizes), (50.0, crate::scene::model::Sizes::Gamma));
        assert_eq!((scene.model.preset, scene.seed), (crate::scene::model::Preset::Fast, 7));
        // The last one holds.
        assert_eq!(edited(&["seed=7", "seed=8"]).expect("a scene").seed, 8);
    }

    #[test]
    fn what_sets_nothing_is_refused() {
        for (edit, expected) in [
            ("rain.rate", "'rain.rate' is no key=value"),
            ("=5", "is no key=value"),
            ("rain.rat=5", "rain.rat=5: unknown field `rat`"),
            ("rain.rate=-1", "rate = -1 is not within"),
            ("rain.rate=much", "rate"),
            ("seed.more=1", "invalid type"),
        ] {
            let said = edited(&[edit]).expect_err("refused").to_string();
            assert!(said.starts_with("--set: ") && said.contains(expected), "{said}");
        }
        let said = edited(&["seed=1", "seed.more=1"]).expect_err("refused").to_string();
        assert!(said.contains("seed.more=1: seed is no table"), "{said}");
    }

    #[test]
    fn paths_of_edits_are_from_the_working_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.toml");
        let text = "[environment]\nfile = \"own.exr\"\n[background]\ncolor = \"plate.exr\"\n";
        crate::files::write_whole(&path, text.as_bytes()).expect("a file");
        let scene = Scene::load_edited(Some(&path), &["environment.file=other.exr".into()]);
        let scene = scene.expect("a scene");
        let here = std::path::absolute("other.exr").expect("a path");
        assert_eq!(scene.environment.file, Some(here));
        assert_eq!(scene.background.color, Some(folder.path().join("plate.exr")));
    }
}
