//! Numbers and names as people read them, in sentences and tables.

/// `digits` significant digits, without trailing zeros, with a power of ten where there would be many zeros.
///
/// ```
/// use dynident_io::formats::significant;
/// assert_eq!(significant(-0.196_4, 2), "−0.2");
/// assert_eq!(significant(2.5e-7, 2), "2.5·10⁻⁷");
/// ```
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let places = digits.max(1) - 1;
    // Rounded first: 9.96 to two digits is 10, of another size.
    let written = format!("{value:.places$e}");
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if !(-4..6).contains(&exponent) {
        return format!("{}·10{}", without_zeros(mantissa), superscript(exponent)).replace('-', "−");
    }
    let decimals = (places as i32 - exponent).max(0) as usize;
    let rounded: f64 = written.parse().unwrap_or(value);
    without_zeros(&format!("{rounded:.decimals$}")).replace('-', "−")
}

/// `value ± deviation` to the second digit of the deviation; the value alone where it was given and has none.
///
/// ```
/// assert_eq!(dynident_io::formats::measured(5.996_31, 0.005_71), "5.9963 ± 0.0057");
/// ```
pub fn measured(value: f64, deviation: f64) -> String {
    if deviation == 0.0 {
        return significant(value, 3);
    }
    let decimals = 1 - deviation.log10().floor() as i32;
    if !(deviation > 0.0 && deviation.is_finite()) || decimals > 8 || value.abs() >= 1e6 {
        return format!("{} ± {}", significant(value, 3), significant(deviation, 2));
    }
    let decimals = decimals.max(0) as usize;
    format!("{value:.decimals$} ± {deviation:.decimals$}").replace('-', "−")
}

/// Units as they are written: `kg m^2` becomes `kg·m²`, the unit of pure numbers nothing.
pub fn unit(text: &str) -> String {
    if text == "1" {
        return String::new();
    }
    text.replace(' ', "·").replace("^2", "²").replace("^3", "³")
}

/// Names as people list them: `A1, A2 and A3`.
pub fn listed<T: AsRef<str>>(names: &[T], last: &str) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.split_last() {
        None => String::new(),
        Some((only, [])) => (*only).to_string(),
        Some((end, rest)) => format!("{} {last} {end}", rest.join(", ")),
    }
}

fn without_zeros(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

fn superscript(exponent: i32) -> String {
    let digit = |c: char| match c.to_digit(10) {
        Some(d) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize],
        None => '⁻',
    };
    exponent.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_digits() {
        let cases = [
            (0.0, "0"),
            (9.96, "10"),
            (0.195, "0.2"),
            (1234.0, "1200"),
            (1.0e6, "1·10⁶"),
            (-3.0e-5, "−3·10⁻⁵"),
        ];
        for (value, shown) in cases {
            assert_eq!(significant(value, 2), shown, "{value}");
        }
        assert_eq!(significant(f64::NAN, 3), "–");
    }

    #[test]
    fn deviations_set_the_digits() {
        assert_eq!(measured(-3.127, 0.3), "−3.13 ± 0.30");
        assert_eq!(measured(2.0, 0.0), "2");
        assert_eq!(measured(123.4, 37.0), "123 ± 37");
    }

    #[test]
    fn lists_end_with_a_word() {
        assert_eq!(listed(&["A1"], "and"), "A1");
        assert_eq!(listed(&["A1", "A2", "A3"], "and"), "A1, A2 and A3");
        assert_eq!(listed::<&str>(&[], "or"), "");
        assert_eq!((unit("kg m^2"), unit("1")), ("kg·m²".to_string(), String::new()));
    }
}
