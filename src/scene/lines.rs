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
        DeValue::Table(table) => {
            let found = in_nested(table, problem).or_else(|| key_named(table, problem));
            found.or(Some(value.span().start))
        }
        DeValue::Array(list) => in_value(list.get(number.checked_sub(1)?)?, 1, problem),
        _ => Some(value.span().start),
    }
}

/// Where it is in a list of tables within a table: "drop 3: …".
fn in_nested(table: &DeTable<'_>, problem: &str) -> Option<usize> {
    let (head, rest) = problem.split_once(": ")?;
    let (name, number) = head.split_once(' ')?;
    let (_, list) = table.iter().find(|(key, _)| key.get_ref() == name)?;
    in_value(list, number.parse().ok()?, rest)
}

/// Where the key begins that a message names first.
fn key_named(table: &DeTable<'_>, problem: &str) -> Option<usize> {
    problem
        .split(|letter: char| !letter.is_alphanumeric() && letter != '_')
        .find_map(|word| table.keys().find(|key| key.get_ref() == word))
        .map(|key| key.span().start)
}
