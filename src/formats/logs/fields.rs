//! One line, field by field.

use csv::{ByteRecord, ReaderBuilder};
use memchr::memchr_iter;

/// One line and where its fields end. Kept from line to line, so that nothing is allocated for any of them.
#[derive(Default)]
pub(super) struct Row {
    text: Vec<u8>,
    ends: Vec<usize>,
    quoted: ByteRecord,
    is_quoted: bool,
}

impl Row {
    pub fn split(&mut self, line: &[u8], delimiter: u8) {
        self.is_quoted = false;
        self.text.clear();
        self.text.extend_from_slice(line);
        self.ends.clear();
        self.ends.extend(memchr_iter(delimiter, line));
        self.ends.push(line.len());
    }

    /// A line with quotation marks goes the long way. Rows of numbers have no line ends within a field, so a mark without its
    /// partner spoils its own line and no other.
    pub fn split_quoted(&mut self, line: &[u8], delimiter: u8) {
        self.is_quoted = true;
        let tight = without_blanks_before_quotes(line, delimiter);
        let line = tight.as_slice();
        let mut reader = ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(line);
        if !reader.read_byte_record(&mut self.quoted).unwrap_or(false) {
            self.quoted.clear();
        }
    }

    pub fn len(&self) -> usize {
        if self.is_quoted { self.quoted.len() } else { self.ends.len() }
    }

    pub fn field(&self, at: usize) -> &[u8] {
        if self.is_quoted {
            return &self.quoted[at];
        }
        let start = if at == 0 { 0 } else { self.ends[at - 1] + 1 };
        &self.text[start..self.ends[at]]
    }
}

/// The line with every quotation mark right behind its separator, where alone it is one for the parser.
fn without_blanks_before_quotes(line: &[u8], delimiter: u8) -> Vec<u8> {
    let mut tight: Vec<u8> = Vec::with_capacity(line.len());
    for &byte in line {
        if byte == b'"' && delimiter != b' ' {
            let end = tight.trim_ascii_end().len();
            if end == 0 || tight[end - 1] == delimiter {
                tight.truncate(end);
            }
        }
        tight.push(byte);
    }
    tight
}

/// A finite number, or nothing.
pub(super) fn number(field: &[u8]) -> Option<f64> {
    fast_float2::parse(field.trim_ascii()).ok().filter(|v: &f64| v.is_finite())
}

/// A finite number whose decimals may follow a comma.
pub(super) fn number_of(field: &[u8], decimal_comma: bool) -> Option<f64> {
    let field = field.trim_ascii();
    let commas = memchr_iter(b',', field).count();
    if !decimal_comma || commas == 0 {
        return number(field);
    }
    // `1,` is the end of a list, `1.000,5` no number that a recorder writes.
    if commas > 1 || field.ends_with(b",") || field.contains(&b'.') {
        return None;
    }
    let pointed: Vec<u8> = field.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
    number(&pointed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_numbers_are_the_doubles_that_the_standard_library_reads() {
        // A generator of digits, short and long, with and without exponent.
        let mut state = 1u64;
        for k in 0..20_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let mut text = format!("{}.{:0width$}", (state >> 50) as i64 - 8000, state >> 20, width = 9 + k % 9);
            if k % 3 == 0 {
                text += &format!("e{}", (state >> 40) as i64 % 300 - 150);
            }
            let expected: f64 = text.parse().unwrap();
            assert_eq!(number(text.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{text}");
        }
        for text in ["", "-", ".", "nan", "inf", "1e999", "1.2.3", "12a", "+-1", "0x10", "1,5"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
        assert_eq!(number(b" +1.5\r"), Some(1.5));
    }
}
