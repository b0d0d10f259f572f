//! Numbers as people read them: with a comma at each thousand, in every table, plot and message. Files for programs
//! (JSON, CSV) have plain digits.

/// A whole number: 1234567 is `1,234,567`.
pub(crate) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number of things: `1 drop`, `2,000 drops`.
pub(crate) fn counted(number: u64, one: &str) -> String {
    format!("{} {one}{}", thousands(number), if number == 1 { "" } else { "s" })
}

/// A number with digits after the point: 1436.034 with two is `1,436.03`.
pub(crate) fn thousands_of(number: f64, decimals: usize) -> String {
    let plain = format!("{number:.decimals$}");
    let end = plain.find('.').unwrap_or(plain.len());
    let (whole, rest) = plain.split_at(end);
    // A sign, an infinity and what is too large stay as they are.
    whole.parse().map_or(plain.clone(), |whole| thousands(whole) + rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_stands_at_each_thousand() {
        assert_eq!([0, 999, 1000, 1_234_567].map(thousands), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0, 1, 2000].map(|n| counted(n, "drop")), ["0 drops", "1 drop", "2,000 drops"]);
        let two = |number| thousands_of(number, 2);
        assert_eq!(
            [0.0, 999.994, 999.996, 1436.034].map(two),
            ["0.00", "999.99", "1,000.00", "1,436.03"]
        );
        assert_eq!(
            [thousands_of(16384.4, 0), two(f64::INFINITY), two(-0.5)],
            ["16,384", "inf", "-0.50"]
        );
    }
}
