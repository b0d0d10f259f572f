//! Texts of planted faults that a number can choose when the program runs.

/// Whether a text can stand between parentheses: its brackets close, it does not go on from what stands before it,
/// and no comma is outside of its brackets.
pub fn may_be_expression(text: &str) -> bool {
    let mut open = Vec::new();
    for letter in text.chars() {
        match letter {
            '(' | '[' | '{' => open.push(letter),
            ')' | ']' | '}' => {
                let pair = [open.pop().unwrap_or(' '), letter];
                if ![['(', ')'], ['[', ']'], ['{', '}']].contains(&pair) {
                    return false;
                }
            }
            ',' if open.is_empty() => return false,
            _ => {}
        }
    }
    open.is_empty() && !text.trim_start().starts_with('.')
}

#[test]
fn what_cannot_be_chosen_is_told() {
    let cases =
        [(".zip(a)", false), ("a, b", false), ("f(a, b)", true), ("(a]", false), ("a)", false)];
    for (text, is) in cases {
        assert_eq!(may_be_expression(text), is, "{text}");
    }
}
