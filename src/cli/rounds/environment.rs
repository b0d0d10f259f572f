//! `--a ENV=VALUE,…`: environment variables from the command line.

/// Variables and their values.
pub type Variables = Vec<(String, String)>;

/// The variables that name driver files, which must be there: the loader says no more than that it found
/// no device.
const DRIVER_FILES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

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
        if DRIVER_FILES.contains(&name) {
            // The platform separates the paths: by `;` on Windows, whose paths have colons.
            let missing = std::env::split_paths(value).find(|file| !file.exists());
            if let Some(file) = missing.filter(|_| !value.is_empty()) {
                return Err(format!("{name}: there is no file '{}'", file.display()));
            }
        }
        if variables.iter().any(|(other, _)| other == name) {
            return Err(format!("{name} is given twice"));
        }
        variables.push((name.into(), value.into()));
    }
    Ok(variables)
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

    #[test]
    fn spaces_and_quotes() {
        let of = |text: &str| {
            let variables = parse(text).expect(text);
            variables.iter().map(|(name, value)| format!("{name}|{value}")).collect::<Vec<_>>()
        };
        assert_eq!(of("A=1,B=2"), ["A|1", "B|2"]);
        assert_eq!(of(" A=x y , B= "), ["A|x y", "B|"]);
        assert_eq!(of(r#"A="x, y ",B='"'"#), ["A|x, y ", "B|\""]);
        assert_eq!(of(r"A=x\,y,B=\ "), ["A|x,y", "B| "]);
        assert_eq!(of("A=b=c"), ["A|b=c"]);
        assert!(of("").is_empty());
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
        ];
        for (text, words) in cases {
            let problem = parse(text).expect_err(text);
            assert!(problem.contains(words), "{text}: {problem}");
        }
    }
}
