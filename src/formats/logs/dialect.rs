//! How a table of text is written: where its rows begin, what separates fields, which sign the decimals have, and where its names
//! stand.
//!
//! Rows are the judges: the separator and the decimal sign are those by which most fields of the first lines are numbers, in rows
//! of one length. The names stand in the last line before them that has as many fields and is none of numbers; a line of units
//! may stand between.

use super::fields::{Row, number_of};
use super::names::{Named, factor, known_time, time_unit};

/// Rows that are looked at: enough to outvote some bad ones.
const ROWS: usize = 60;
/// Separators, the most usual first. A space stands for any number of blanks and tabs.
const DELIMITERS: [u8; 5] = [b',', b';', b'\t', b'|', b' '];

/// How the rows are written, and what stands before them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialect {
    pub delimiter: u8,
    pub decimal_comma: bool,
    /// Fields of a row.
    pub fields: usize,
    /// Lines before the first row.
    pub skipped: usize,
    /// Line of the names, from 1; `None` where there are only numbers.
    pub header: Option<usize>,
    pub names: Vec<String>,
    /// Units of a line below the names, one for each; empty without one.
    pub units: Vec<String>,
}

impl Dialect {
    /// Whether a line is one of values: neither empty nor a remark.
    pub fn is_row(&self, line: &[u8]) -> bool {
        !line.trim_ascii().is_empty() && !is_comment(line)
    }

    /// Splits a line, with its end or without.
    pub fn split(&self, line: &[u8], row: &mut Row) {
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if self.delimiter == b' ' {
            row.split_quoted(&single_blanks(line), self.delimiter);
        } else {
            row.split_quoted(line, self.delimiter);
        }
    }
}

/// One line of the beginning, without its end.
struct Line<'a> {
    text: &'a [u8],
    /// From 0.
    at: usize,
}

impl Line<'_> {
    fn is_comment(&self) -> bool {
        is_comment(self.text)
    }

    /// What a comment says.
    fn comment(&self) -> &[u8] {
        let text = self.text.trim_ascii_start();
        let start = text
            .iter()
            .position(|b| !matches!(b, b'#' | b'%' | b'/'))
            .unwrap_or(text.len());
        &text[start..]
    }
}

/// Whether a line is a remark and no row.
pub(super) fn is_comment(line: &[u8]) -> bool {
    matches!(line.first(), Some(b'#' | b'%')) || line.starts_with(b"//")
}

/// The dialect of a text whose beginning is `head`. `None` where nothing stands in it.
pub(super) fn detect(head: &[u8]) -> Option<Dialect> {
    let lines: Vec<Line> = head
        .split(|&b| b == b'\n')
        .enumerate()
        .map(|(at, text)| Line {
            text: text.strip_suffix(b"\r").unwrap_or(text),
            at,
        })
        .map(|line| Line {
            text: if line.at == 0 {
                line.text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line.text)
            } else {
                line.text
            },
            ..line
        })
        .filter(|line| !line.text.trim_ascii().is_empty())
        .collect();
    let rows: Vec<&Line> = lines.iter().filter(|l| !l.is_comment()).collect();
    if lines.is_empty() {
        return None;
    }
    let style = Style::from_rows(&rows);
    let Some((first, style)) = style.and_then(|style| Some((style.first(&rows)?, style))) else {
        return Some(without_rows(&lines, &rows));
    };
    Some(with_rows(&lines, first, style))
}

/// A separator, a decimal sign, and how many fields the rows have by them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Style {
    delimiter: u8,
    decimal_comma: bool,
    fields: usize,
    /// Numbers in a row, by far the most rows have as many.
    numbers: usize,
}

impl Style {
    /// The one by which most is numbers.
    fn from_rows(rows: &[&Line]) -> Option<Self> {
        let sample = &rows[rows.len().saturating_sub(ROWS)..];
        let candidates = DELIMITERS.iter().flat_map(|&d| [(d, false), (d, true)]);
        let mut best: Option<(f64, Self)> = None;
        for (delimiter, decimal_comma) in candidates {
            let Some((score, style)) = Self::judged(sample, delimiter, decimal_comma) else {
                continue;
            };
            if best.is_none_or(|(most, _)| score > most + 1e-12) {
                best = Some((score, style));
            }
        }
        best.map(|(_, style)| style)
    }

    /// Share of fields that are numbers in the rows of the usual length; nothing where most lines are no such rows.
    fn judged(sample: &[&Line], delimiter: u8, decimal_comma: bool) -> Option<(f64, Self)> {
        let counts: Vec<(usize, usize)> = sample.iter().map(|l| count(l.text, delimiter, decimal_comma)).collect();
        let filled: Vec<&(usize, usize)> = counts.iter().filter(|(_, numbers)| *numbers > 0).collect();
        let (fields, numbers) = **filled
            .iter()
            .max_by_key(|one| filled.iter().filter(|other| *other == *one).count())?;
        let alike = filled.iter().filter(|(f, _)| *f == fields).count();
        let share = numbers as f64 / fields as f64 * alike as f64 / sample.len() as f64;
        // One column may be all that a file beside a log has; more are better wherever the rest is equal.
        let breadth = 1.0 - 0.5 / fields as f64;
        let style = Self {
            delimiter,
            decimal_comma,
            fields,
            numbers,
        };
        (share > 0.0).then_some((share * breadth, style))
    }

    /// The first line that is such a row.
    fn first(&self, rows: &[&Line]) -> Option<usize> {
        let least = self.numbers.div_ceil(2);
        let is_row = |l: &&&Line| {
            let (fields, numbers) = count(l.text, self.delimiter, self.decimal_comma);
            fields == self.fields && numbers >= least
        };
        rows.iter().find(is_row).map(|l| l.at)
    }
}

/// Fields of a line, and those of them that are numbers.
fn count(line: &[u8], delimiter: u8, decimal_comma: bool) -> (usize, usize) {
    let fields = split(line, delimiter);
    let numbers = fields.iter().filter(|f| is_number(f, decimal_comma)).count();
    (fields.len(), numbers)
}

/// Numbers, and what programs write in their place.
fn is_number(field: &[u8], decimal_comma: bool) -> bool {
    let field = field.trim_ascii();
    number_of(field, decimal_comma).is_some()
        || matches!(
            field.to_ascii_lowercase().as_slice(),
            b"nan" | b"inf" | b"-inf" | b"+inf" | b"-nan"
        )
}

fn split(line: &[u8], delimiter: u8) -> Vec<Vec<u8>> {
    let mut row = Row::default();
    let line = if delimiter == b' ' {
        single_blanks(line)
    } else {
        line.to_vec()
    };
    row.split_quoted(&line, delimiter);
    (0..row.len()).map(|at| row.field(at).to_vec()).collect()
}

/// The line with one space for every run of blanks, and none at its ends.
fn single_blanks(line: &[u8]) -> Vec<u8> {
    let words = line.split(|b| matches!(b, b' ' | b'\t')).filter(|w| !w.is_empty());
    words.collect::<Vec<_>>().join(&b' ')
}

fn texts(fields: Vec<Vec<u8>>) -> Vec<String> {
    let text = |f: &Vec<u8>| {
        String::from_utf8_lossy(f.trim_ascii())
            .trim_start_matches('\u{feff}')
            .to_string()
    };
    fields.iter().map(text).collect()
}

/// Names that fit rows of `fields` fields: as many, or one fewer or more where the odd one is that of numbered rows or of a
/// separator at the end.
fn fitted(mut names: Vec<String>, fields: usize, row: &[u8], delimiter: u8) -> Option<Vec<String>> {
    if names.len() == fields + 1 && names.last().is_some_and(String::is_empty) {
        names.pop();
    } else if names.len() + 1 == fields && fields > 2 {
        let trailing = split(row, delimiter).last().is_some_and(|f| f.trim_ascii().is_empty());
        let at = if trailing { names.len() } else { 0 };
        names.insert(at, String::new());
    }
    (names.len() == fields).then_some(names)
}

/// Whether most of the names are names.
fn are_names(names: &[String]) -> bool {
    let filled: Vec<&String> = names.iter().filter(|n| !n.is_empty()).collect();
    let numbers = filled
        .iter()
        .filter(|n| is_number(n.as_bytes(), false) || is_number(n.as_bytes(), true))
        .count();
    2 * numbers < filled.len()
}

/// Units alone, in brackets or without.
fn are_units(names: &[String]) -> bool {
    let bare = |n: &String| n.trim_matches(['[', ']', '(', ')', ' ']).to_string();
    let known = |n: &String| n.is_empty() || n == "-" || factor(&bare(n)).is_some() || time_unit(&bare(n)).is_some();
    names.iter().any(|n| !n.is_empty()) && names.iter().all(known)
}

fn with_rows(lines: &[Line], first: usize, style: Style) -> Dialect {
    let mut found = Dialect {
        delimiter: style.delimiter,
        decimal_comma: style.decimal_comma,
        fields: style.fields,
        skipped: first,
        header: None,
        names: (1..=style.fields).map(|n| format!("column{n}")).collect(),
        units: Vec::new(),
    };
    let row = lines.iter().find(|l| l.at == first).map_or(&b""[..], |l| l.text);
    // Names may be separated otherwise than rows are: by spaces above tabs, by commas above semicolons.
    let others = DELIMITERS.iter().copied().filter(|d| *d != style.delimiter);
    let delimiters: Vec<u8> = std::iter::once(style.delimiter).chain(others).collect();
    let before = || lines.iter().filter(|l| l.at < first).rev();
    let names_of = |text: &[u8], delimiters: &[u8]| {
        delimiters.iter().find_map(|&d| {
            let names = fitted(texts(split(text, d)), style.fields, row, style.delimiter)?;
            are_names(&names).then_some(names)
        })
    };
    let plain = before().filter(|l| !l.is_comment());
    let commented = before().filter(|l| l.is_comment());
    let all = plain
        .clone()
        .map(|l| (l, l.text, &delimiters[..1]))
        .chain(commented.map(|l| (l, l.comment(), &delimiters[..])))
        .chain(plain.map(|l| (l, l.text, &delimiters[1..])));
    // A bad row may stand between the names and the good ones: the nearest line that names a time is meant, or else the nearest.
    let mut best: Option<(Vec<String>, Option<usize>, bool)> = None;
    for (line, text, delimiters) in all {
        let Some(names) = names_of(text, delimiters) else { continue };
        if best.is_none() && found.units.is_empty() && are_units(&names) {
            found.units = names;
            continue;
        }
        let has_time = known_time(&names.iter().map(|n| Named::new(n, 0)).collect::<Vec<_>>(), 0).is_some();
        if best.is_none() || has_time {
            best = Some((names, Some(line.at + 1), line.is_comment()));
        }
        if has_time {
            break;
        }
    }
    if let Some((names, header, is_comment)) = best {
        let below = header.unwrap_or(first);
        found.skipped = if is_comment || !found.units.is_empty() { first } else { below };
        (found.header, found.names) = (header, names);
        return found;
    }
    found.units.clear();
    // Names of another number than the rows have fields: they are names all the same, and the rows will be found wanting.
    if let Some(line) = before().rfind(|l| !l.is_comment()) {
        let names = texts(split(line.text, style.delimiter));
        if are_names(&names) && names.len() > 1 {
            found.fields = names.len();
            (found.header, found.names, found.skipped) = (Some(line.at + 1), names, line.at + 1);
        }
    }
    found
}

/// A text without rows of numbers: its first line has the names.
fn without_rows(lines: &[Line], rows: &[&Line]) -> Dialect {
    let line = rows.first().copied().unwrap_or(&lines[0]);
    let counted = |d: &u8| line.text.iter().filter(|&b| b == d).count();
    let delimiter = DELIMITERS.into_iter().rev().max_by_key(counted).unwrap_or(b',');
    let names = texts(split(line.text, delimiter));
    Dialect {
        delimiter,
        decimal_comma: false,
        fields: names.len(),
        skipped: line.at + 1,
        header: Some(line.at + 1),
        names,
        units: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Dialect {
        detect(text.as_bytes()).expect("some text")
    }

    #[test]
    fn separators_and_decimal_signs_are_those_that_make_numbers() {
        for (text, delimiter, decimal_comma) in [
            ("t,q\n0.5,1.5\n1.0,2.5\n", b',', false),
            ("t;q\n0,5;1,5\n1,0;2,5\n", b';', true),
            ("t;q\n0.5;1.5\n", b';', false),
            ("t\tq\n0,5\t1,5\n", b'\t', true),
            ("t q\n0.5   1.5\n1.0   -2.5\n", b' ', false),
            ("t q\n0,5 1,5\n", b' ', true),
            ("t, q\n0.5, 1.5\n", b',', false),
            ("t|q\n0.5|1.5\n", b'|', false),
            ("t,q\n1,2\n3,4\n", b',', false),
            ("\"t\",\"q\"\n\"0,5\",\"1,5\"\n", b',', true),
            ("t,q,mode\n0.5,1.5,run\n1.0,2.5,run\n", b',', false),
        ] {
            let d = found(text);
            assert_eq!(
                (d.delimiter, d.decimal_comma, d.header),
                (delimiter, decimal_comma, Some(1)),
                "{text}"
            );
            assert_eq!(&d.names[..2], ["t", "q"], "{text}");
        }
    }

    #[test]
    fn what_stands_before_the_rows_is_skipped() {
        let d = found("Recorded by: M. Huber\nDate;2024-05-01\n\nt;q\n[s];[rad]\n0,0;1,0\n0,1;1,1\n");
        assert_eq!((d.header, d.skipped, d.names.len()), (Some(4), 5, 2));
        assert_eq!(d.units, ["[s]", "[rad]"]);
        let d = found("# made by numpy\n# t q\n0.0 1.0\n0.1 1.1\n");
        assert_eq!((d.header, d.names.clone()), (Some(2), vec!["t".to_string(), "q".to_string()]));
        let d = found("0.0,1.0\n0.1,1.1\n");
        assert_eq!(
            (d.header, d.skipped, d.names.clone()),
            (None, 0, vec!["column1".to_string(), "column2".to_string()])
        );
        // A bad row before the good ones is a row.
        let d = found("t,q\noops\n0.0,1.0\n0.1,1.1\n");
        assert_eq!((d.header, d.skipped), (Some(1), 1));
    }

    #[test]
    fn names_fit_rows_that_are_numbered_or_end_in_a_separator() {
        assert_eq!(found("a,b\n1,0.5,1.5\n2,0.6,1.6\n").names, ["", "a", "b"]);
        assert_eq!(found("a,b\n0.5,1.5,\n0.6,1.6,\n").names, ["a", "b", ""]);
        assert_eq!(found("a,b,\n0.5,1.5\n0.6,1.6\n").names, ["a", "b"]);
    }
}
