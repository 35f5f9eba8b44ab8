//! A log that is text: its beginning says how it is written, the rest is streamed.

use super::dialect::{Dialect, detect};
use super::error::LogError;
use super::lists::Lists;
use super::names::Named;
use super::places::Heading;
use super::reader::broken;
use super::unpack::Bytes;
use crate::model::INPUT_LIMITS;
use std::io::{self, BufRead, BufReader, Cursor, Read};

/// Longest header that is read (bytes).
const LONGEST_HEADER: usize = INPUT_LIMITS.log_header;
/// Lines and bytes of the beginning that say how a file is written.
const LINES: usize = 80;
const BYTES: usize = 2 * LONGEST_HEADER;

/// A text, read as far as its header.
pub(super) struct TextLog<'a> {
    pub dialect: Dialect,
    pub names: Vec<Named>,
    /// The rows.
    pub rows: Box<dyn Read + Send + 'a>,
}

impl<'a> TextLog<'a> {
    pub fn open(file: &str, mut bytes: Bytes<'a>) -> Result<Self, LogError> {
        let (head, broke) = head(&mut bytes);
        if let Some(lists) = Lists::detect(&head).filter(|_| broke.is_none()) {
            let text = lists.apart(Cursor::new(head).chain(bytes));
            return Self::open(file, Box::new(BufReader::new(text)));
        }
        let file = || file.to_string();
        let first_line = memchr::memchr(b'\n', &head).unwrap_or(head.len());
        if first_line > LONGEST_HEADER {
            return Err(LogError::LongHeader {
                file: file(),
                limit: LONGEST_HEADER,
            });
        }
        if let Some(e) = broke {
            return Err(broken(&file(), memchr::memchr_iter(b'\n', &head).count() as u64, &e));
        }
        let whole = bytes.fill_buf().is_ok_and(<[u8]>::is_empty);
        // The last line may go on behind the beginning.
        let end = if whole {
            head.len()
        } else {
            memchr::memrchr(b'\n', &head).map_or(head.len(), |at| at + 1)
        };
        let dialect = detect(&head[..end]).ok_or_else(|| LogError::Empty { file: file() })?;
        if dialect.names.len() > INPUT_LIMITS.log_columns {
            return Err(LogError::TooManyColumns {
                file: file(),
                columns: dialect.names.len(),
                limit: INPUT_LIMITS.log_columns,
            });
        }
        let names = dialect.names.iter().enumerate().map(|(at, name)| {
            let below = dialect.units.get(at).map(|u| u.trim_matches(['[', ']', '(', ')', ' ']));
            let named = Named::new(name, 0);
            match below.filter(|u| !u.is_empty() && named.unit.is_none()) {
                Some(unit) => Named {
                    unit: Some(unit.to_string()),
                    ..named
                },
                None => named,
            }
        });
        let names = names.collect();
        let skipped = memchr::memchr_iter(b'\n', &head).nth(dialect.skipped.wrapping_sub(1));
        let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let from = if dialect.skipped == 0 {
            mark
        } else {
            skipped.map_or(head.len(), |at| at + 1)
        };
        let mut rest = Cursor::new(head);
        rest.set_position(from as u64);
        Ok(Self {
            dialect,
            names,
            rows: Box::new(rest.chain(bytes)),
        })
    }

    pub fn heading<'b>(&'b self, file: &'b str) -> Heading<'b> {
        Heading {
            file,
            names: &self.names,
            line: self.dialect.header.map(|line| line as u64),
            is_numbered: self.dialect.header.is_none(),
        }
    }
}

/// The first lines, as many as say how the file is written, and why there are no more.
fn head(bytes: &mut impl BufRead) -> (Vec<u8>, Option<io::Error>) {
    let mut head = Vec::new();
    for _ in 0..LINES {
        let room = (BYTES + 1).saturating_sub(head.len()) as u64;
        match bytes.by_ref().take(room).read_until(b'\n', &mut head) {
            Ok(0) => break,
            Ok(_) => {}
            Err(e) => return (head, Some(e)),
        }
    }
    (head, None)
}
