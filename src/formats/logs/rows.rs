//! Rows of numbers: the lines of a block become columns.

use super::dialect::{Dialect, is_comment};
use super::fields::{Row, number_of};
use super::places::Places;
use super::report::Tally;
use memchr::{memchr, memchr2};

/// What a row has to look like.
pub(super) struct RowShape {
    delimiter: u8,
    decimal_comma: bool,
    fields: usize,
    time: Option<usize>,
    /// Field of every value that is kept.
    values: Vec<usize>,
    /// How many of them, from the first, must be numbers.
    required: usize,
    /// Per field: whether it is read.
    is_read: Vec<bool>,
}

impl RowShape {
    pub fn new(dialect: &Dialect, places: &Places) -> Self {
        Self {
            decimal_comma: dialect.decimal_comma,
            required: places.all().count() - places.channels.len(),
            ..Self::of_fields(dialect.delimiter, dialect.fields, places.time, places.all().collect())
        }
    }

    pub(super) fn of_fields(delimiter: u8, fields: usize, time: Option<usize>, values: Vec<usize>) -> Self {
        let is_read = (0..fields).map(|f| time == Some(f) || values.contains(&f)).collect();
        Self {
            delimiter,
            decimal_comma: false,
            fields,
            time,
            required: values.len(),
            values,
            is_read,
        }
    }
}

/// The rows of one block. Lines and rows are counted from the block's start.
#[derive(Default)]
pub(super) struct Part {
    /// Length of the block.
    pub bytes: usize,
    /// Lines of the block, comments and empty ones too.
    pub line_count: u64,
    /// Rows of the block, good or bad.
    pub rows: usize,
    /// Line and number of every good row.
    pub lines: Vec<u32>,
    pub numbers: Vec<u32>,
    pub time: Vec<f64>,
    /// One column per value of the shape.
    pub columns: Vec<Vec<f64>>,
    pub garbage: Tally,
    pub missing_time: Tally,
}

impl Part {
    /// Empty, with the room that it had.
    fn clear(&mut self, columns: usize) {
        (self.line_count, self.rows) = (0, 0);
        self.lines.clear();
        self.numbers.clear();
        self.time.clear();
        self.columns.resize_with(columns, Vec::new);
        self.columns.iter_mut().for_each(Vec::clear);
        (self.garbage, self.missing_time) = (Tally::default(), Tally::default());
    }

    fn push(&mut self, values: impl Iterator<Item = f64>) {
        self.lines.push(self.line_count as u32);
        self.numbers.push(self.rows as u32);
        self.columns.iter_mut().zip(values).for_each(|(column, v)| column.push(v));
    }
}

impl RowShape {
    /// Overwrites `part` with the rows of `text`, which is brought into the form that is read fastest.
    pub fn parse(&self, text: &mut Vec<u8>, part: &mut Part) {
        part.clear(self.values.len());
        part.bytes = text.len();
        if self.delimiter == b' ' {
            blanks_to_one(text);
        }
        // Where commas separate nothing, they are all of decimals.
        if self.decimal_comma && self.delimiter != b',' {
            text.iter_mut().filter(|b| **b == b',').for_each(|b| *b = b'.');
        }
        let text: &[u8] = text;
        let quoted = memchr(b'"', text).is_some();
        let (mut row, mut values) = (Row::default(), vec![0.0; self.values.len()]);
        let mut fields = vec![0.0; self.fields];
        let mut start = 0;
        while start < text.len() {
            part.line_count += 1;
            if !quoted && let Some(length) = self.plain_row(&text[start..], &mut fields) {
                start += length;
                part.rows += 1;
                part.time.extend(self.time.map(|at| fields[at]));
                part.push(self.values.iter().map(|&at| fields[at]));
                continue;
            }
            let end = memchr(b'\n', &text[start..]).map_or(text.len(), |at| start + at);
            let line = text[start..end].strip_suffix(b"\r").unwrap_or(&text[start..end]);
            start = end + 1;
            if line.is_empty() || is_comment(line) {
                continue;
            }
            if quoted && memchr(b'"', line).is_some() {
                row.split_quoted(line, self.delimiter);
            } else {
                row.split(line, self.delimiter);
            }
            part.rows += 1;
            self.take(&row, &mut values, part);
        }
    }

    /// Reads the line at the beginning of `text` in one go, every number up to where it ends by itself, and returns the line's
    /// length with its end. `None` for any line that is not the right number of fields with plain numbers where they are read: it
    /// is looked at field by field.
    fn plain_row(&self, text: &[u8], fields: &mut [f64]) -> Option<usize> {
        if matches!(text[0], b'#' | b'\r' | b'\n') {
            return None;
        }
        let mut at = 0;
        for (field, number) in fields.iter_mut().enumerate() {
            if field > 0 {
                if text.get(at) != Some(&self.delimiter) {
                    return None;
                }
                at += 1;
            }
            if !self.is_read[field] {
                at += memchr2(self.delimiter, b'\n', &text[at..]).unwrap_or(text.len() - at);
                continue;
            }
            while self.delimiter != b' ' && text.get(at) == Some(&b' ') {
                at += 1;
            }
            let (value, length) = fast_float2::parse_partial::<f64, _>(&text[at..]).ok()?;
            if !value.is_finite() {
                return None;
            }
            *number = value;
            at += length;
        }
        match text[at..] {
            [] => Some(at),
            [b'\n', ..] => Some(at + 1),
            [b'\r', b'\n', ..] => Some(at + 2),
            _ => None,
        }
    }

    /// Appends one row, or counts it as garbage.
    fn take(&self, row: &Row, values: &mut [f64], part: &mut Part) {
        let line = part.line_count;
        if row.len() != self.fields {
            let fields = self.fields;
            part.garbage.add(line, || format!("{} fields instead of {fields}", row.len()));
            return;
        }
        for (i, (value, &at)) in values.iter_mut().zip(&self.values).enumerate() {
            match number_of(row.field(at), self.decimal_comma) {
                Some(v) => *value = v,
                None if i >= self.required => *value = f64::NAN,
                None => {
                    part.garbage
                        .add(line, || format!("`{}` in column {}", shown(row.field(at)), at + 1));
                    return;
                }
            }
        }
        if let Some(at) = self.time {
            match number_of(row.field(at), self.decimal_comma) {
                Some(t) => part.time.push(t),
                None => {
                    part.missing_time.add(line, || format!("`{}`", shown(row.field(at))));
                    return;
                }
            }
        }
        part.push(values.iter().copied());
    }
}

/// Every run of blanks and tabs becomes one space, those at the ends of lines none.
fn blanks_to_one(text: &mut Vec<u8>) {
    let (mut to, mut pending, mut at_start) = (0, false, true);
    for from in 0..text.len() {
        match text[from] {
            b' ' | b'\t' => pending = !at_start,
            b'\n' | b'\r' => {
                text[to] = text[from];
                (to, pending, at_start) = (to + 1, false, text[from] == b'\n');
            }
            other => {
                if pending {
                    text[to] = b' ';
                    to += 1;
                }
                text[to] = other;
                (to, pending, at_start) = (to + 1, false, false);
            }
        }
    }
    text.truncate(to);
}

/// A field as messages show it, which may be megabytes long.
fn shown(field: &[u8]) -> String {
    const LONGEST: usize = 60;
    let text = String::from_utf8_lossy(&field[..field.len().min(LONGEST)]);
    format!("{text}{}", if field.len() > LONGEST { "…" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Part of `text`, read in one go where that can be, or all of it field by field.
    fn part(text: &str, delimiter: u8, closely: bool) -> Part {
        let shape = RowShape::of_fields(delimiter, 4, Some(0), vec![3, 1]);
        // A quotation mark anywhere, here in a comment behind the rows, sends every line the long way.
        let text = if closely {
            format!("{text}\n# \"")
        } else {
            format!("{text}\n# ")
        };
        let mut part = Part::default();
        shape.parse(&mut text.into_bytes(), &mut part);
        part
    }

    #[test]
    fn prop_rows_read_in_one_go_are_those_read_field_by_field() {
        let fields = [
            "1",
            "-2.5",
            "+3e-4",
            " 7",
            "8 ",
            "",
            "x",
            "nan",
            "1e999",
            "0.1234567890123456789",
            "5.",
            "-.5",
            "#",
            "\r",
            "1.5x",
        ];
        let mut state = 7usize;
        let mut next = |below: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        for delimiter in [",", ";", "\t", " "] {
            let mut text = String::new();
            for _ in 0..4000 {
                let count = if next(10) == 0 { next(7) } else { 4 };
                let plain = next(3) > 0;
                let line: Vec<&str> = (0..count)
                    .map(|_| fields[next(if plain { 3 } else { fields.len() })])
                    .collect();
                text += &(line.join(delimiter) + ["\n", "\r\n"][next(2)]);
            }
            let text = text.trim_end_matches('\n');
            let (fast, slow) = (
                part(text, delimiter.as_bytes()[0], false),
                part(text, delimiter.as_bytes()[0], true),
            );
            assert!(fast.lines.len() > 1000 && fast.garbage.count > 100, "both kinds occur");
            assert_eq!((fast.line_count, fast.rows), (slow.line_count, slow.rows));
            assert_eq!(
                (&fast.lines, &fast.numbers, &fast.time),
                (&slow.lines, &slow.numbers, &slow.time)
            );
            assert_eq!(fast.columns, slow.columns);
            for (fast, slow) in [(&fast.garbage, &slow.garbage), (&fast.missing_time, &slow.missing_time)] {
                assert_eq!((fast.count, &fast.lines, &fast.first), (slow.count, &slow.lines, &slow.first));
            }
        }
    }
}
