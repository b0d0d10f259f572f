//! Messages about a scene file: in which line the value is that one is about, and what readers say, in the words of scenes.

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
    Some(line_at(&text[..start]))
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

/// The line, from 1, of a reader's error, and what it says in the words of scene files.
pub(super) fn of_reader(text: &str, error: &toml::de::Error) -> (usize, String) {
    let before = &text[..error.span().map_or(0, |span| span.start)];
    let problem = match (mend(error.message()), key_before(before)) {
        (problem, Some(key)) if problem.starts_with("invalid ") => format!("{key}: {problem}"),
        (problem, _) => problem,
    };
    (line_at(before), problem)
}

/// The line, from 1, that begins or goes on after a text.
fn line_at(before: &str) -> usize {
    before.matches('\n').count() + 1
}

/// The key whose value begins after `text`, on the same line.
fn key_before(text: &str) -> Option<&str> {
    let line = text.rsplit('\n').next()?;
    let (before, _) = line.rsplit_once('=')?;
    let key = before.rsplit(['{', ',']).next()?.trim();
    (!key.is_empty()).then_some(key)
}

/// Adds the nearest known name to serde's message about an unknown one, if one is near: a slip of the
/// hand changes a third of a name at most.
pub(super) fn mend(message: &str) -> String {
    let line = message.lines().next().unwrap_or(message);
    let mut names = line.split('`').skip(1).step_by(2);
    let Some(unknown) = names.next().filter(|_| line.starts_with("unknown ")) else {
        let types = [
            ("expected f64", "expected a number"),
            ("expected f32", "expected a number"),
            ("expected u32", "expected a whole number"),
            ("expected u64", "expected a whole number"),
            ("expected a boolean", "expected true or false"),
        ];
        return types.iter().fold(line.into(), |line, (name, words)| line.replace(name, words));
    };
    let far = |name: &str| strsim::damerau_levenshtein(name, unknown);
    let most = unknown.len().div_ceil(3);
    match names.min_by_key(|name| far(name)).filter(|name| far(name) <= most) {
        Some(nearest) => format!("{line}; did you mean `{nearest}`?"),
        None => line.into(),
    }
}
