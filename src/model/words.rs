//! Numbers in messages.

/// Longest text of a double with an exponent.
const LONGEST_NUMBER: usize = 24;

/// The shortest text that reads as `value`: written out, or with an exponent where that would be hundreds of digits. What is no
/// finite number is said in words.
pub fn shortest(value: f64) -> String {
    if !value.is_finite() {
        return endless(value).into();
    }
    let text = value.to_string();
    if text.len() > LONGEST_NUMBER {
        format!("{value:e}")
    } else {
        text
    }
}

/// `value` with an exponent and so many decimals.
pub fn scientific(value: f64, places: usize) -> String {
    match value.is_finite() {
        true => format!("{value:.places$e}"),
        false => endless(value).into(),
    }
}

fn endless(value: f64) -> &'static str {
    match value {
        v if v.is_nan() => "not a number",
        v if v > 0.0 => "more than 1e308",
        _ => "less than -1e308",
    }
}

/// A message without endless numbers: what somebody has written as 1e300 is not said back as three hundred digits. All that goes
/// into a problem, a choice or an error passes through here.
pub fn readable(text: impl Into<String>) -> String {
    let text = text.into();
    let is_digit = |c: char| c.is_ascii_digit() || c == '.';
    let endless = |word: &str| word.len() > LONGEST_NUMBER && word.bytes().any(|b| b.is_ascii_digit());
    if !text.split(|c| !is_digit(c)).any(endless) {
        return text;
    }
    let mut short = String::new();
    let mut rest = text.as_str();
    while let Some(first) = rest.find(is_digit) {
        let (before, from) = rest.split_at(first);
        let (word, after) = from.split_at(from.find(|c| !is_digit(c)).unwrap_or(from.len()));
        short.push_str(before);
        match word.parse::<f64>().ok().filter(|v| endless(word) && v.is_finite()) {
            Some(value) => short.push_str(&shortest(value)),
            None => short.push_str(word),
        }
        rest = after;
    }
    short + rest
}

/// A number of things: `1 value`, `2 values`.
pub fn counted(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// `value` with so many decimals; with an exponent where more than nine digits would stand before them.
pub fn decimals(value: f64, places: usize) -> String {
    match value.abs() {
        size if size < 1e9 => format!("{value:.places$}"),
        size if size.is_finite() => format!("{value:.3e}"),
        _ => endless(value).into(),
    }
}

/// `value` to three significant digits, six decimals at most.
pub fn three_digits(value: f64) -> String {
    let size = value.abs().log10().floor();
    let places = if size.is_finite() { (2.0 - size).clamp(0.0, 6.0) } else { 0.0 };
    decimals(value, places as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_are_kept_at_every_size() {
        let written = [1234.5, 30.84, -4.1, 0.02171, 0.0, 1e-9].map(three_digits);
        assert_eq!(written, ["1234", "30.8", "-4.10", "0.0217", "0", "0.000000"]);
    }

    #[test]
    fn numbers_read_back_and_are_never_hundreds_of_digits() {
        for value in [0.0, -0.1, 1.5e-3, 123_456.789, 1e308, f64::MAX, 5e-324, -1.0 / 3.0] {
            let text = shortest(value);
            assert!(text.len() <= LONGEST_NUMBER, "{text}");
            assert_eq!(text.parse(), Ok(value));
            assert!(decimals(value, 3).len() <= LONGEST_NUMBER);
        }
        assert_eq!(decimals(12.345_6, 2), "12.35");
        assert_eq!(decimals(1.5e300, 0), "1.500e300");
        assert_eq!(decimals(f64::INFINITY, 0), "more than 1e308");
        assert_eq!(shortest(f64::NAN), "not a number");
    }

    #[test]
    fn messages_say_long_numbers_shortly_and_all_else_as_it_is() {
        let text = format!("is [{}, -{}] rad, below 2.5: `a1.urdf`", 1e300, 5e-324);
        assert_eq!(readable(text), "is [1e300, -5e-324] rad, below 2.5: `a1.urdf`");
        let plain = "joint `A1`, line 12: is 3.141592653589793 ... 1e-9, 1.2.3";
        assert_eq!(readable(plain), plain);
        let name = "a".repeat(200);
        assert_eq!(readable(name.clone()), name);
    }
}
