//! Texts whose fields are lists: `"[0.1, -0.2, 0.3]"` below `actual_q`, as pandas, NumPy and JSON write them.
//!
//! Lists are taken apart before anything else looks at the text: a list of three below `actual_q` becomes `actual_q[0]`,
//! `actual_q[1]`, `actual_q[2]`. Lines stay lines.

use super::dialect::is_comment;
use std::io::{self, BufRead, Read};

/// Separators between fields, the most usual first.
const DELIMITERS: [u8; 4] = [b',', b';', b'\t', b'|'];
/// Names of a header that are looked at.
const MOST_FIELDS: usize = crate::model::INPUT_LIMITS.log_columns;

/// How many numbers the fields of a row are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lists {
    delimiter: u8,
    /// Line of the names, from 0.
    header: usize,
    /// Of every field: length of its list, `None` where it is no list.
    lengths: Vec<Option<usize>>,
}

impl Lists {
    /// `None` where no row of the beginning of a text has a list.
    pub fn detect(head: &[u8]) -> Option<Self> {
        memchr::memchr(b'[', head)?;
        let lines: Vec<&[u8]> = head.split(|b| *b == b'\n').map(without_end).collect();
        let header = lines.iter().position(|l| !l.trim_ascii().is_empty() && !is_comment(l))?;
        let row = lines[header + 1..]
            .iter()
            .find(|l| !l.trim_ascii().is_empty() && !is_comment(l))?;
        DELIMITERS.into_iter().find_map(|delimiter| {
            let names = split(lines[header], delimiter);
            let fields = split(row, delimiter);
            let lengths: Vec<Option<usize>> = fields.iter().map(|f| Some(list(f)?.len())).collect();
            let is_one = names.iter().all(|n| list(n).is_none())
                && names.len() == fields.len()
                && names.len() <= MOST_FIELDS
                && lengths.iter().any(Option::is_some);
            // Names such as `position[A1]` are no lists: the row is.
            is_one.then_some(Self {
                delimiter,
                header,
                lengths,
            })
        })
    }

    /// The text with a field for every number.
    pub fn apart<R: BufRead>(self, bytes: R) -> Apart<R> {
        Apart {
            lists: self,
            bytes,
            line: 0,
            ready: Vec::new(),
            at: 0,
        }
    }

    fn line(&self, number: usize, line: &[u8], out: &mut Vec<u8>) {
        let fields = if number < self.header || line.trim_ascii().is_empty() || is_comment(line) {
            out.extend_from_slice(line);
            return;
        } else {
            split(line, self.delimiter)
        };
        for (k, field) in fields.iter().enumerate() {
            if k > 0 {
                out.push(self.delimiter);
            }
            let length = self.lengths.get(k).copied().flatten();
            match (number == self.header, length) {
                (true, Some(length)) => {
                    let name = String::from_utf8_lossy(field);
                    let name = name.trim().trim_matches('"').to_string();
                    let names: Vec<String> = (0..length).map(|i| format!("{name}[{i}]")).collect();
                    out.extend(names.join(&String::from(self.delimiter as char)).bytes());
                }
                (false, Some(_)) => match list(field) {
                    Some(items) => out.extend(items.join(&self.delimiter)),
                    None => out.extend_from_slice(field),
                },
                _ => out.extend_from_slice(field),
            }
        }
    }
}

/// A text that is taken apart as it is read.
pub(super) struct Apart<R> {
    lists: Lists,
    bytes: R,
    line: usize,
    ready: Vec<u8>,
    at: usize,
}

/// Longest line that is taken apart (bytes).
const LONGEST_LINE: u64 = 1 << 20;

impl<R: BufRead> Read for Apart<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.at == self.ready.len() {
            let mut line = Vec::new();
            let mut limited = (&mut self.bytes).take(LONGEST_LINE);
            if limited.read_until(b'\n', &mut line)? == 0 {
                return Ok(0);
            }
            (self.at, self.ready) = (0, Vec::with_capacity(line.len()));
            let ended = line.ends_with(b"\n");
            self.lists.line(self.line, without_end(&line), &mut self.ready);
            if ended {
                self.ready.push(b'\n');
                self.line += 1;
            }
            // An empty answer would be the end.
            if self.ready.is_empty() {
                self.ready.push(b' ');
            }
        }
        let count = out.len().min(self.ready.len() - self.at);
        out[..count].copy_from_slice(&self.ready[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}

fn without_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Fields of a line; separators within quotation marks or brackets separate nothing.
fn split(line: &[u8], delimiter: u8) -> Vec<&[u8]> {
    let (mut fields, mut start, mut depth, mut quoted) = (Vec::new(), 0, 0usize, false);
    for (at, &byte) in line.iter().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            _ if byte == delimiter && !quoted && depth == 0 => {
                fields.push(&line[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    fields.push(&line[start..]);
    fields
}

/// The items of a list of numbers; `None` where the field is none.
fn list(field: &[u8]) -> Option<Vec<&[u8]>> {
    let field = field.trim_ascii();
    let field = field
        .strip_prefix(b"\"")
        .and_then(|f| f.strip_suffix(b"\""))
        .unwrap_or(field)
        .trim_ascii();
    let inner = field.strip_prefix(b"[")?.strip_suffix(b"]")?;
    let is_between = |b: &u8| matches!(b, b',' | b';') || b.is_ascii_whitespace();
    let items: Vec<&[u8]> = inner.split(is_between).filter(|i| !i.is_empty()).collect();
    let is_number = |i: &&[u8]| std::str::from_utf8(i).is_ok_and(|t| t.parse::<f64>().is_ok());
    (!items.is_empty() && items.iter().all(is_number)).then_some(items)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(text: &str) -> Option<String> {
        let mut out = String::new();
        Lists::detect(text.as_bytes())?
            .apart(text.as_bytes())
            .read_to_string(&mut out)
            .unwrap();
        Some(out)
    }

    #[test]
    fn lists_become_fields_in_every_way_they_are_written() {
        let plain = "t,q[0],q[1],m\n0.0,1,-2e-3,7\n0.1,3,4,7\n";
        for text in [
            "t,q,m\n0.0,\"[1, -2e-3]\",7\n0.1,\"[3, 4]\",7\n",
            "t,q,m\n0.0,[1 -2e-3],7\n0.1,[ 3  4],7\n",
            "t,\"q\",m\r\n0.0,\"[1,-2e-3]\",7\r\n0.1,\"[3,4]\",7\r\n",
        ] {
            assert_eq!(apart(text).as_deref(), Some(plain), "{text}");
        }
        assert_eq!(apart("t;q\n0;[1, 2]\n").as_deref(), Some("t;q[0];q[1]\n0;1;2\n"));
        assert_eq!(
            apart("# a [1, 2]\nt,q\n0,\"[1, 2]\"").as_deref(),
            Some("# a [1, 2]\nt,q[0],q[1]\n0,1,2")
        );
        // A row with another length has another number of fields: it is counted as garbage later.
        assert_eq!(
            apart("t,q\n0,\"[1, 2]\"\n1,\"[1]\"\n2,x\n").as_deref(),
            Some("t,q[0],q[1]\n0,1,2\n1,1\n2,x\n")
        );
    }

    #[test]
    fn brackets_of_names_and_units_are_no_lists() {
        for text in [
            "t [s],q [rad]\n0,1\n",
            "position[A1],position[A2]\n0.0,1.0\n",
            "t,q\n0,[a]\n",
            "[1, 2]\n",
            "",
        ] {
            assert_eq!(apart(text), None, "{text}");
        }
    }
}
