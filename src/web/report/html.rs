//! Writing HTML: whatever comes from documents is escaped on its way in.

use crate::documents::EvaluatedFigure;
use crate::web::figures::{Figure, FigureError};
use serde_json::Value;

/// A page that grows, and the headings of its parts.
#[derive(Debug, Default)]
pub(super) struct Html(pub String, Vec<String>);

/// What stands in a table, as HTML.
pub(super) struct Cell(pub String);

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self(escaped(&text))
    }
}

/// `text` as it may stand in HTML.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(c),
        }
    }
    out
}

/// What stands in a report as text.
pub(super) trait Shown {
    fn shown(&self) -> String;
}

impl Shown for str {
    fn shown(&self) -> String {
        self.to_string()
    }
}

impl Shown for String {
    fn shown(&self) -> String {
        self.clone()
    }
}

impl Shown for f64 {
    fn shown(&self) -> String {
        number(*self)
    }
}

impl Shown for usize {
    fn shown(&self) -> String {
        self.to_string()
    }
}

impl Shown for u64 {
    fn shown(&self) -> String {
        self.to_string()
    }
}

impl<T: Shown> Shown for Option<T> {
    fn shown(&self) -> String {
        self.as_ref().map_or("–".into(), Shown::shown)
    }
}

impl Shown for EvaluatedFigure {
    fn shown(&self) -> String {
        match self {
            Self::Value(value) => value.shown(),
            Self::NotEvaluated(_) => "not evaluated".into(),
        }
    }
}

/// Strings as they are, whole numbers in full, others to four digits, a dash for nothing.
pub(super) fn text<T: Shown + ?Sized>(value: &T) -> String {
    value.shown()
}

/// Four significant digits.
pub(super) fn number(v: f64) -> String {
    if !v.is_finite() {
        return "–".into();
    }
    if v == 0.0 {
        return "0".into();
    }
    let size = v.abs().log10().floor() as i32;
    let written = match (-4..6).contains(&size) {
        true => format!("{v:.*}", (3 - size).max(0) as usize),
        false => powers_of_ten(&format!("{v:.3e}")),
    };
    written.replace('-', "−")
}

/// `2.920e6` → `2.920·10⁶`.
fn powers_of_ten(written: &str) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        _ => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c.to_digit(10).unwrap_or(0) as usize],
    };
    match written.split_once('e') {
        Some((digits, power)) => format!("{digits}·10{}", power.chars().map(raised).collect::<String>()),
        None => written.into(),
    }
}

/// `stribeck_friction` → `stribeck friction`. Names of fields are spelt as in America, reports as in Britain.
pub(super) fn words<T: Shown + ?Sized>(value: &T) -> String {
    text(value)
        .replace('_', " ")
        .replace("center of mass box", "box for the centre of mass")
        .replace("center of mass", "centre of mass")
        .replace("load dependent", "load-dependent")
}

/// With a capital in front, as a heading has it.
pub(super) fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters
        .next()
        .map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Names as people list them.
pub(super) fn listed(names: &[String]) -> String {
    names.join(", ")
}

impl Html {
    pub fn heading(&mut self, level: u8, words: &str) {
        let mut place = String::new();
        if level == 2 {
            self.1.push(words.to_string());
            place = format!(" id=\"part-{}\"", self.1.len());
        }
        self.0.push_str(&format!("<h{level}{place}>{}</h{level}>\n", escaped(words)));
    }

    /// Links to the parts, in their order.
    pub fn contents(&self) -> String {
        let part = |(i, words): (usize, &String)| format!("<li><a href=\"#part-{}\">{}</a></li>", i + 1, escaped(words));
        let parts: String = self.1.iter().enumerate().map(part).collect();
        format!("<nav aria-label=\"Contents\"><ol>{parts}</ol></nav>\n")
    }

    /// Terms with their explanations.
    pub fn definitions<'a>(&mut self, list: impl Iterator<Item = (&'a str, &'a str)>) {
        let one = |(name, words): (&str, &str)| format!("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(words));
        self.0
            .push_str(&format!("<dl>\n{}</dl>\n", list.map(one).collect::<String>()));
    }

    pub fn paragraph(&mut self, class: &str, words: &str) {
        self.0.push_str(&format!("<p class=\"{class}\">{}</p>\n", escaped(words)));
    }

    /// `heads` that begin with `#` are of numbers, which stand to the right.
    pub fn table<C: Into<Cell>>(&mut self, caption: &str, heads: &[&str], rows: impl Iterator<Item = Vec<C>>) {
        let class = |k: usize| {
            if heads.get(k).is_some_and(|h| h.starts_with('#')) {
                " class=\"n\""
            } else {
                ""
            }
        };
        let cells = |tag: &str, row: Vec<Cell>| {
            let one = |(k, Cell(cell)): (usize, Cell)| format!("<{tag}{}>{cell}</{tag}>", class(k));
            row.into_iter().enumerate().map(one).collect::<String>()
        };
        let names = heads
            .iter()
            .map(|h| Cell::from(h.trim_start_matches('#').to_string()))
            .collect();
        // On a narrow screen a wide table scrolls: it has a name, and the keyboard reaches it.
        let label = match caption {
            "" => heads.iter().map(|h| h.trim_start_matches('#')).collect::<Vec<_>>().join(", "),
            said => said.to_string(),
        };
        let shown = if caption.is_empty() {
            String::new()
        } else {
            // In a part of its own, which stays in sight where the table scrolls.
            format!("<caption><span>{}</span></caption>", escaped(caption))
        };
        self.0.push_str(&format!(
            "<div class=\"wide\" role=\"group\" tabindex=\"0\" aria-label=\"{}\"><table>{shown}<thead><tr>{}</tr></thead><tbody>\n",
            escaped(&label),
            cells("th", names)
        ));
        for row in rows {
            let row = row.into_iter().map(Into::into).collect();
            self.0.push_str(&format!("<tr>{}</tr>\n", cells("td", row)));
        }
        self.0.push_str("</tbody></table></div>\n");
    }

    /// A picture with its caption; in its place the reason where it cannot be drawn.
    pub fn figure(&mut self, figure: &Figure, caption: &str) {
        match figure.svg() {
            Ok(svg) => {
                let scaled = with_view_box(&svg, figure.size);
                let label = escaped(caption);
                self.0.push_str(&format!(
                    "<figure role=\"img\" tabindex=\"0\" aria-label=\"{label}\">{scaled}<figcaption>{label}</figcaption></figure>\n"
                ));
            }
            Err(FigureError(reason)) => self.paragraph("soft", &format!("{caption}: not drawn, {reason}")),
        }
    }

    pub fn document(&mut self, value: &Value) {
        self.0.push_str(&format!("<pre>{}</pre>\n", escaped(&laid_out(value, 0))));
    }
}

/// Characters of a printed line.
const LINE: usize = 96;

/// JSON with what fits on a line, and every list of numbers, on one line: matrices look like matrices, and a robot takes a page
/// and not five.
fn laid_out(value: &Value, depth: usize) -> String {
    let line = on_one_line(value);
    if depth + line.len() <= LINE {
        return line;
    }
    let (inner, outer) = (" ".repeat(depth + 1), " ".repeat(depth));
    let nested = |v: &Value| v.is_object() || v.is_array();
    match value {
        Value::Object(fields) => {
            let line =
                |(name, v): (&String, &Value)| format!("{inner}{}: {}", Value::from(name.as_str()), laid_out(v, depth + 1));
            format!("{{\n{}\n{outer}}}", fields.iter().map(line).collect::<Vec<_>>().join(",\n"))
        }
        Value::Array(list) if list.iter().any(nested) => {
            let line = |v: &Value| format!("{inner}{}", laid_out(v, depth + 1));
            format!("[\n{}\n{outer}]", list.iter().map(line).collect::<Vec<_>>().join(",\n"))
        }
        _ => line,
    }
}

fn on_one_line(value: &Value) -> String {
    match value {
        Value::Object(fields) => {
            let field = |(name, v): (&String, &Value)| format!("{}: {}", Value::from(name.as_str()), on_one_line(v));
            format!("{{{}}}", fields.iter().map(field).collect::<Vec<_>>().join(", "))
        }
        Value::Array(list) => format!("[{}]", list.iter().map(on_one_line).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// Pictures have pixels; a page scales them.
fn with_view_box(svg: &str, (width, height): (u32, u32)) -> String {
    let sized = format!("<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
    svg.replacen(&sized, &format!("<svg viewBox=\"0 0 {width} {height}\""), 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn documents_are_laid_out_without_a_change() {
        let row = json!([1.5, -2e-7, 0.123_456_789, 0.123_456_789]);
        let value = json!({"a": [row, row, row, [3, 4]], "b": {"c": [], "d": {}, "e": "x\"y", "g": null}, "f": [vec![0.123_456_789; 20]]});
        let text = laid_out(&value, 0);
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
        assert!(
            text.contains("\n  [1.5, -2e-7, 0.123456789, 0.123456789],\n  [3, 4]"),
            "{text}"
        );
        assert!(
            text.contains("\n \"b\": {\"c\": [], \"d\": {}, \"e\": \"x\\\"y\", \"g\": null}"),
            "{text}"
        );
        assert_eq!(text.lines().filter(|line| line.len() > LINE + 10).count(), 1, "{text}");
    }

    #[test]
    fn numbers_keep_four_digits() {
        for (value, shown) in [
            (0.0, "0"),
            (1234.5678, "1235"),
            (-0.0012345, "−0.001234"),
            (2.0e-9, "2.000·10⁻⁹"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(number(value), shown);
        }
    }
}
