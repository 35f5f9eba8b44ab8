//! Numbers and words that readers are known to stumble over, shared by all kinds of documents.

use super::dice::Dice;

/// Numbers at the edges of what a double, a whole number or a plausible quantity can be.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "64",
    "1000",
    "1e308",
    "-1e308",
    "1.7976931348623157e308",
    "1e-308",
    "5e-324",
    "-5e-324",
    "1e150",
    "-1e150",
    "1e-150",
    "1e-16",
    "1e16",
    "1e12",
    "1e9",
    "1e-9",
    "1e5",
    "-1e5",
    "9007199254740993",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "-9223372036854775808",
    "123456789012345678901234567890",
    "0.1e-400",
    "3.1416",
    "1.57079",
    "-3.14",
    "6.2832",
    "0.5",
    "0.99999999999999989",
];
/// What programs write where a number should be.
const NO_NUMBERS: &[&str] = &[
    "NaN",
    "nan",
    "-nan",
    "Infinity",
    "-Infinity",
    "inf",
    "1e999",
    "-1e999",
    "0x10",
    "1.",
    "+1",
    ".5",
    "01",
    "1_000",
    "1,5",
    "--1",
    "1e",
    "",
];
/// Names and texts that break formats which do not escape them.
const WORDS: &[&str] = &[
    "",
    " ",
    "\n",
    "a\nb",
    "\r\n",
    "\t",
    "\0",
    "\u{1}\u{1f}",
    "\"",
    "'",
    "\\",
    "\\u0000",
    "<b>",
    "</name>",
    "&amp;",
    "&",
    "]]>",
    "<!--",
    "a,b",
    "a;b",
    "../../etc/passwd",
    "/",
    "~",
    "~1",
    "é",
    "ß",
    "関節",
    "\u{202e}abc",
    "\u{feff}",
    "🦾",
    "a\u{300}",
    "NaN",
    "null",
    "true",
    "0",
    "base_link",
    "planar_two_link",
    "time",
    "q1",
    "tau1",
    "%s%n",
    "{}",
    "${x}",
    "$(find x)",
    "__proto__",
];

pub fn number(dice: &mut Dice) -> String {
    dice.pick(NUMBERS).to_string()
}

pub fn no_number(dice: &mut Dice) -> String {
    dice.pick(NO_NUMBERS).to_string()
}

pub fn word(dice: &mut Dice) -> String {
    match dice.below(12) {
        0 => dice.pick(WORDS).repeat(1 + dice.below(300)),
        1 => "x".repeat(10 + dice.below(5000)),
        _ => dice.pick(WORDS).to_string(),
    }
}

/// A number near `value`, or the same of another size or sign.
pub fn changed(value: f64, dice: &mut Dice) -> f64 {
    match dice.below(10) {
        0 => -value,
        1 => 0.0,
        2 => value + 1.0,
        3 => value - 1.0,
        4 => value * (1.0 + 1e-9),
        5 => value.round(),
        6 => (value * 1e4).round() / 1e4,
        7 => value.to_degrees(),
        8 => value * 10f64.powf(dice.between(-12.0, 12.0)),
        _ => value * 10f64.powf(dice.between(-2.0, 2.0)),
    }
}

/// Another token in the place of the number `token`.
pub fn another(token: &str, dice: &mut Dice) -> String {
    match (token.parse::<f64>(), dice.below(10)) {
        (Ok(value), 0..=5) => shortest(changed(value, dice)),
        (_, 0..=7) => number(dice),
        (_, 8) => no_number(dice),
        _ => word(dice),
    }
}

/// The shortest text that reads as `value`; exponents where they are shorter.
pub fn shortest(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 3 { plain } else { exponent }
}
