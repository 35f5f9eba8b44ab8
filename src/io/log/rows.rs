//! Rows of numbers, a block of the file at a time: while some threads turn one batch of blocks into columns, another reads (and unpacks)
//! the next.

use super::places::Places;
use super::report::Tally;
use csv::{ByteRecord, ReaderBuilder};
use memchr::{memchr, memchr_iter, memrchr};
use rayon::prelude::*;
use std::io::{self, Read};

/// Bytes that one thread parses at a time: a few milliseconds' work, and a batch of them is small beside the columns of a log.
const BLOCK: usize = 1 << 20;
/// Longest line that is read. A file without line ends would fill the memory.
const LONGEST_LINE: usize = 4 * BLOCK;

/// What a row has to look like.
pub(super) struct RowShape {
    pub delimiter: u8,
    pub fields: usize,
    pub time: Option<usize>,
    /// Field of every value that is kept.
    pub values: Vec<usize>,
}

impl RowShape {
    pub fn new(delimiter: u8, fields: usize, places: &Places) -> Self {
        Self {
            delimiter,
            fields,
            time: places.time,
            values: places.all().collect(),
        }
    }
}

/// The rows of one block. Lines and rows are counted from the block's start.
pub(super) struct Part {
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

/// Why reading ended before the file did.
pub(super) enum Broken {
    Io(io::Error),
    LongLine,
}

/// A break, and the lines that were read before it.
pub(super) struct Break {
    pub lines: u64,
    pub reason: Broken,
}

/// Hands the parts of `bytes` to `take`, in their order, until it refuses.
pub(super) fn for_each_part<E>(
    bytes: &mut (impl Read + Send),
    shape: &RowShape,
    mut take: impl FnMut(Part) -> Result<(), E>,
    broken: impl FnOnce(Break) -> E,
) -> Result<(), E> {
    let mut carry = Vec::new();
    let mut batch = Batch::read(bytes, &mut carry);
    loop {
        let parse = || batch.blocks.par_iter().map(|text| shape.parse(text)).collect::<Vec<_>>();
        let read = || match &batch.end {
            End::More => Some(Batch::read(bytes, &mut carry)),
            _ => None,
        };
        let (parts, next) = rayon::join(parse, read);
        parts.into_iter().try_for_each(&mut take)?;
        match (batch.end, next) {
            (End::More, Some(next)) => batch = next,
            (End::Broken(reason, lines), _) => return Err(broken(Break { lines, reason })),
            _ => return Ok(()),
        }
    }
}

/// Whole lines of the file, two blocks for every thread.
struct Batch {
    blocks: Vec<Vec<u8>>,
    end: End,
}

enum End {
    More,
    File,
    /// After so many lines of text that is in no block.
    Broken(Broken, u64),
}

impl Batch {
    fn read(bytes: &mut impl Read, carry: &mut Vec<u8>) -> Self {
        let wanted = 2 * rayon::current_num_threads();
        let mut blocks = Vec::with_capacity(wanted);
        while blocks.len() < wanted {
            match block(bytes, carry) {
                Ok(Some(text)) => blocks.push(text),
                Ok(None) => return Self { blocks, end: End::File },
                Err((reason, lines)) => {
                    return Self {
                        blocks,
                        end: End::Broken(reason, lines),
                    };
                }
            }
        }
        Self { blocks, end: End::More }
    }
}

/// The next block: whole lines, or what is left at the end of the file. `carry` has the beginning of the line that the block before cut.
fn block(bytes: &mut impl Read, carry: &mut Vec<u8>) -> Result<Option<Vec<u8>>, (Broken, u64)> {
    let mut text = Vec::with_capacity(BLOCK + carry.len());
    text.append(carry);
    loop {
        let from = text.len();
        let read = bytes.by_ref().take(BLOCK as u64).read_to_end(&mut text);
        if let Err(e) = read {
            let lines = memchr_iter(b'\n', &text).count() as u64;
            return Err((Broken::Io(e), lines));
        }
        if text.len() == from {
            return Ok((!text.is_empty()).then_some(text));
        }
        if let Some(end) = memrchr(b'\n', &text[from..]) {
            *carry = text.split_off(from + end + 1);
            return Ok(Some(text));
        }
        if text.len() > LONGEST_LINE {
            return Err((Broken::LongLine, 0));
        }
    }
}

impl RowShape {
    fn parse(&self, text: &[u8]) -> Part {
        let guess = text.len() / (8 * self.fields).max(1);
        let mut part = Part {
            line_count: 0,
            rows: 0,
            lines: Vec::with_capacity(guess),
            numbers: Vec::with_capacity(guess),
            time: Vec::with_capacity(if self.time.is_some() { guess } else { 0 }),
            columns: vec![Vec::with_capacity(guess); self.values.len()],
            garbage: Tally::default(),
            missing_time: Tally::default(),
        };
        let quoted = memchr(b'"', text).is_some();
        let (mut row, mut values) = (Row::default(), vec![0.0; self.values.len()]);
        let mut start = 0;
        while start < text.len() {
            let end = memchr(b'\n', &text[start..]).map_or(text.len(), |at| start + at);
            let line = text[start..end].strip_suffix(b"\r").unwrap_or(&text[start..end]);
            start = end + 1;
            part.line_count += 1;
            if line.is_empty() || line[0] == b'#' {
                continue;
            }
            if quoted && memchr(b'"', line).is_some() {
                row.split_quoted(line, self.delimiter);
            } else {
                row.split(line, self.delimiter);
            }
            part.rows += 1;
            self.take(&row, &mut values, &mut part);
        }
        part
    }

    /// Appends one row, or counts it as garbage.
    fn take(&self, row: &Row, values: &mut [f64], part: &mut Part) {
        let line = part.line_count;
        if row.len() != self.fields {
            let fields = self.fields;
            part.garbage.add(line, || format!("{} fields instead of {fields}", row.len()));
            return;
        }
        for (value, &at) in values.iter_mut().zip(&self.values) {
            match number(row.field(at)) {
                Some(v) => *value = v,
                None => {
                    let text = String::from_utf8_lossy(row.field(at));
                    part.garbage.add(line, || format!("`{text}` in column {}", at + 1));
                    return;
                }
            }
        }
        if let Some(at) = self.time {
            match number(row.field(at)) {
                Some(t) => part.time.push(t),
                None => {
                    let text = String::from_utf8_lossy(row.field(at));
                    part.missing_time.add(line, || format!("`{text}`"));
                    return;
                }
            }
        }
        part.lines.push(line as u32);
        part.numbers.push(part.rows as u32);
        part.columns
            .iter_mut()
            .zip(values.iter())
            .for_each(|(column, &v)| column.push(v));
    }
}

/// One line and where its fields end. Kept from line to line, so that nothing is allocated for any of them.
#[derive(Default)]
struct Row {
    text: Vec<u8>,
    ends: Vec<usize>,
    quoted: ByteRecord,
    is_quoted: bool,
}

impl Row {
    fn split(&mut self, line: &[u8], delimiter: u8) {
        self.is_quoted = false;
        self.text.clear();
        self.text.extend_from_slice(line);
        self.ends.clear();
        self.ends.extend(memchr_iter(delimiter, line));
        self.ends.push(line.len());
    }

    /// A line with quotation marks goes the long way. Rows of numbers have no line ends within a field, so a mark without its partner
    /// spoils its own line and no other.
    fn split_quoted(&mut self, line: &[u8], delimiter: u8) {
        self.is_quoted = true;
        let mut reader = ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(line);
        if !reader.read_byte_record(&mut self.quoted).unwrap_or(false) {
            self.quoted.clear();
        }
    }

    fn len(&self) -> usize {
        if self.is_quoted { self.quoted.len() } else { self.ends.len() }
    }

    fn field(&self, at: usize) -> &[u8] {
        if self.is_quoted {
            return &self.quoted[at];
        }
        let start = if at == 0 { 0 } else { self.ends[at - 1] + 1 };
        &self.text[start..self.ends[at]]
    }
}

/// A finite number, or nothing.
fn number(field: &[u8]) -> Option<f64> {
    fast_float2::parse(field.trim_ascii()).ok().filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> RowShape {
        RowShape {
            delimiter: b',',
            fields: 3,
            time: Some(0),
            values: vec![1, 2],
        }
    }

    fn read(text: &str) -> (Vec<f64>, Vec<Vec<f64>>, usize) {
        let (mut time, mut columns, mut bad) = (Vec::new(), vec![Vec::new(); 2], 0);
        let take = |part: Part| {
            time.extend(part.time);
            columns.iter_mut().zip(part.columns).for_each(|(c, p)| c.extend(p));
            bad += part.garbage.count;
            Ok::<(), ()>(())
        };
        for_each_part(&mut text.as_bytes(), &shape(), take, |_| ()).unwrap();
        (time, columns, bad)
    }

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

    #[test]
    fn prop_blocks_and_their_seams_lose_nothing() {
        // Five blocks, seams within rows.
        let rows = 5 * BLOCK / 20;
        let mut text = String::new();
        for i in 0..rows {
            text += &format!("{i},{},{}\n", 2 * i, 3 * i + 1);
        }
        let (time, columns, bad) = read(&text);
        assert_eq!((time.len(), bad), (rows, 0));
        assert!(
            (0..rows).all(|i| time[i] == i as f64 && columns[0][i] == 2.0 * i as f64 && columns[1][i] == 3.0 * i as f64 + 1.0)
        );
    }

    #[test]
    fn prop_quotes_comments_and_empty_lines_are_read_as_tables_are() {
        let text = "# a comment\n\n0,\"1\",2\r\n\"3\",\"4\",5\n6,\"7,8\n9,10,11";
        let (time, columns, bad) = read(text);
        assert_eq!(
            (time, columns, bad),
            (vec![0.0, 3.0, 9.0], vec![vec![1.0, 4.0, 10.0], vec![2.0, 5.0, 11.0]], 1)
        );
    }

    #[test]
    fn prop_a_line_without_end_is_refused_before_it_fills_the_memory() {
        let mut endless = io::repeat(b'1');
        let found = for_each_part(&mut endless, &shape(), |_| Ok(()), |b| matches!(b.reason, Broken::LongLine));
        assert_eq!(found, Err(true));
    }
}
