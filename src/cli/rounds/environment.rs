//! `--a ENV=VALUE,…`: environment variables from the command line.

use std::path::{Path, PathBuf};

use crate::files::read_text;
use crate::measure::host::VARIABLES;

/// Variables and their values.
pub type Variables = Vec<(String, String)>;

/// The variables that name driver files, which must be there: the loader says no more than that it found
/// no device.
const DRIVER_FILES: [&str; 3] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES"];

/// Parses `NAME=VALUE,NAME=VALUE`. A value with commas, or with spaces at its ends, stands in quotes, single
/// or double; a backslash takes the next character as it is, but on Windows, where it stands in paths. Nothing at all is an
/// environment, too: that of the command itself.
pub fn parse(text: &str) -> Result<Variables, String> {
    let mut variables = Variables::new();
    for item in split(text, !cfg!(windows))? {
        let Some((name, value)) = item.split_once('=') else {
            return Err(format!("'{item}' is not NAME=VALUE"));
        };
        let name = name.trim();
        if name.is_empty() || name.contains(char::is_whitespace) {
            return Err(format!("'{name}' is not the name of a variable"));
        }
        if let Some(meant) = VARIABLES.iter().find(|known| is_a_slip(name, known)) {
            return Err(format!("nothing reads '{name}'; {meant} is meant"));
        }
        if let Some(problem) = unfit_driver_file(name, value) {
            return Err(problem);
        }
        if variables.iter().any(|(other, _)| other == name) {
            return Err(format!("{name} is given twice"));
        }
        variables.push((name.into(), value.into()));
    }
    Ok(variables)
}

/// Whether a name is a known one but for a letter too many, too few, or another.
fn is_a_slip(name: &str, known: &str) -> bool {
    let before = name.bytes().zip(known.bytes()).take_while(|(a, b)| a == b).count();
    let after = name.bytes().rev().zip(known.bytes().rev()).take_while(|(a, b)| a == b).count();
    let (least, most) = (name.len().min(known.len()), name.len().max(known.len()));
    name != known && most - least <= 1 && before + after + 1 >= most
}

/// What is wrong with the first driver file that a variable names, if it is one that names them.
fn unfit_driver_file(name: &str, value: &str) -> Option<String> {
    if !DRIVER_FILES.contains(&name) || value.is_empty() {
        return None;
    }
    // The platform separates the paths: by `;` on Windows, whose paths have colons.
    std::env::split_paths(value).find_map(|file| {
        if !file.exists() {
            return Some(format!("{name}: there is no file '{}'", file.display()));
        }
        let library = missing_library(&file)?;
        let (file, library) = (file.display(), library.display());
        Some(format!("{name}: {file} names a library that is not there, '{library}'"))
    })
}

/// The library that a driver's file names by a path, if it is not there. (One without a folder is looked for by the system.)
fn missing_library(file: &Path) -> Option<PathBuf> {
    let text = read_text(file).ok()?;
    let manifest: serde_json::Value = serde_json::from_str(&text).ok()?;
    let named = Path::new(manifest["ICD"]["library_path"].as_str()?);
    let library = file.parent()?.join(named);
    (named.components().count() > 1 && !library.exists()).then_some(library)
}

/// What is wrong with the driver files that this process's environment names.
pub fn unfit_driver_files() -> Vec<String> {
    let named = DRIVER_FILES.into_iter().filter_map(|name| Some((name, std::env::var(name).ok()?)));
    named.filter_map(|(name, value)| unfit_driver_file(name, &value)).collect()
}

/// The items between commas, quotes taken off; spaces around an item are none of it. `escapes`: a backslash is one.
fn split(text: &str, escapes: bool) -> Result<Vec<String>, String> {
    let (mut items, mut item, mut quote) = (Vec::new(), String::new(), None);
    // How much of the item was quoted, and so is kept although it may be space.
    let mut kept = 0;
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        match (character, quote) {
            ('\\', None | Some('"')) if escapes => {
                item.push(characters.next().ok_or("it ends with a backslash")?);
                kept = item.len();
            }
            (_, Some(open)) if character == open => {
                quote = None;
                kept = item.len();
            }
            ('"' | '\'', None) => quote = Some(character),
            (',', None) => {
                items.push(ended(&mut item, &mut kept));
            }
            (' ', None) if item.is_empty() => {}
            _ => item.push(character),
        }
    }
    if let Some(open) = quote {
        return Err(format!("a {open} is not closed"));
    }
    items.push(ended(&mut item, &mut kept));
    items.retain(|item| !item.is_empty());
    Ok(items)
}

/// The item, without spaces at its end that were not quoted.
fn ended(item: &mut String, kept: &mut usize) -> String {
    let mut whole = std::mem::take(item);
    let end = whole.trim_end().len().max(std::mem::take(kept));
    whole.truncate(end);
    whole
}

#[cfg(test)]
mod tests {
    use super::{parse, split};
    use crate::files::write_whole;

    #[test]
    fn spaces_and_quotes() {
        let of = |text: &str| {
            let variables = parse(text).expect(text);
            variables.iter().map(|(name, value)| format!("{name}|{value}")).collect::<Vec<_>>()
        };
        assert_eq!(of("A=1,B=2"), ["A|1", "B|2"]);
        assert_eq!(of(" A=x y , B =1, C= "), ["A|x y", "B|1", "C|"]);
        assert_eq!(of(r#"A="x, y ",B='"'"#), ["A|x, y ", "B|\""]);
        assert_eq!(of(r"A=x\,y,B=\ "), ["A|x,y", "B| "]);
        assert_eq!(of("A=b=c"), ["A|b=c"]);
        assert!(of("").is_empty());
    }

    #[test]
    fn slips_in_names_of_known_variables_are_told() {
        for (text, meant) in [
            ("VK_DRIVER_FILE=/a", "VK_DRIVER_FILES"),
            ("LP_NUM_TREADS=1", "LP_NUM_THREADS"),
            ("A=1,LP_PERFS=x", "LP_PERF"),
        ] {
            let problem = parse(text).expect_err(text);
            assert!(problem.ends_with(&format!("{meant} is meant")), "{problem}");
        }
        for name in ["RADV_DEBUG", "NIR_DEBUG", "A", "VK_LOADER_DEBUG"] {
            assert!(parse(&format!("{name}=1")).is_ok(), "{name}");
        }
    }

    #[test]
    fn a_drivers_library_must_be_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("icd.json");
        let of = |library: &str| {
            let manifest = serde_json::json!({"ICD": {"library_path": library}});
            write_whole(&file, manifest.to_string().as_bytes()).expect("written");
            parse(&format!("VK_DRIVER_FILES='{}'", file.display()))
        };
        assert!(of("lib/none.so").expect_err("no library").contains("lib/none.so"));
        assert!(of("libvulkan_lvp.so").is_ok(), "the system looks for it");
        assert!(of("./icd.json").is_ok());
    }

    #[test]
    fn a_backslash_of_windows_is_one() {
        let paths = r#"A=C:\a.json;\\host\b, B="C:\with, comma\""#;
        let items = split(paths, false).expect(paths);
        assert_eq!(items, [r"A=C:\a.json;\\host\b", r"B=C:\with, comma\"]);
        assert_eq!(split(r"A=C:\a", true).expect("an escape"), ["A=C:a"]);
    }

    #[test]
    fn mistakes_are_named() {
        let cases = [
            ("A", "'A' is not NAME=VALUE"),
            ("=1", "not the name"),
            ("A B=1", "not the name"),
            ("A='x", "' is not closed"),
            ("A=1,A=2", "A is given twice"),
            ("A=\\", "backslash"),
            ("VK_DRIVER_FILES=/nowhere/a.json", "there is no file '/nowhere/a.json'"),
            ("VK_ADD_DRIVER_FILES=/nowhere/a.json", "there is no file '/nowhere/a.json'"),
        ];
        for (text, words) in cases {
            let problem = parse(text).expect_err(text);
            assert!(problem.contains(words), "{text}: {problem}");
        }
    }
}
