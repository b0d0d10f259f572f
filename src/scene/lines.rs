//! Where in a scene file the value is that a message is about.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The line, from 1, of what a problem of [`super::Scene::validate`] is about: of the first key of its table that it
/// names; where it names none that the file has, of the table. `None` if the file has no such table: then a default, or
/// what a command puts in its place, is the problem.
pub(super) fn line_of(text: &str, problem: &str) -> Option<usize> {
    let file = DeTable::parse(text).ok()?;
    let (head, rest) = problem.split_once(": ").unwrap_or(("", problem));
    let mut words = head.split(' ');
    let name = words.next(); // "drop 3" is the third of [[drop]]
    let number = words.next().and_then(|word| word.parse::<usize>().ok()).unwrap_or(1);
    let start = match file.get_ref().iter().find(|(key, _)| Some(&**key.get_ref()) == name) {
        Some((_, value)) => in_value(value, number, rest)?,
        None => key_named(file.get_ref(), problem)?,
    };
    Some(text[..start].matches('\n').count() + 1)
}

/// Where the key, or else the table, begins in a table, or in one of a list of them.
fn in_value(value: &Spanned<DeValue<'_>>, number: usize, problem: &str) -> Option<usize> {
    match value.get_ref() {
        DeValue::Table(table) => key_named(table, problem).or(Some(value.span().start)),
        DeValue::Array(list) => in_value(list.get(number.checked_sub(1)?)?, 1, problem),
        _ => Some(value.span().start),
    }
}

/// Where the key begins that a message names first.
fn key_named(table: &DeTable<'_>, problem: &str) -> Option<usize> {
    problem
        .split(|letter: char| !letter.is_alphanumeric() && letter != '_')
        .find_map(|word| table.keys().find(|key| key.get_ref() == word))
        .map(|key| key.span().start)
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    #[test]
    fn what_is_out_of_range_has_its_line() {
        for (line, text) in [
            (2, "seed = 1\ntime = inf"),
            (3, "[camera]\nnear = 1.0\nvertical_fov = 0.0"),
            (2, "\n[image]\nwidth = 100000"),
            (1, "image = { width = 0 }"),
            (1, "tone_map.key = 0.0"),
            (5, "[[rain]]\nradius = 0.1\n[[rain]]\nseed = 2\nradius = -1.0"),
            (
                6,
                "[[drop]]\ncenter = [0.0, 0.0, 0.0]\nradius = 0.1\n[[drop]]\ncenter = [0.0, 0.0, 0.0]\nradius = 0.0",
            ),
            (3, "[rain]\nrate = 25.0\ndiameters = [2.0, 1.0]"),
            (2, "[model]\nerror = 0.1\npreset = \"paper\""),
            (2, "[film]\npace = [{ at = 1.0, rate = 1.0 }, { at = 0.0, rate = 1.0 }]"),
        ] {
            let message = Scene::parse(text, "s.toml").expect_err(text).to_string();
            assert!(message.starts_with(&format!("s.toml:{line}: ")), "{text}: {message}");
        }
    }
}
