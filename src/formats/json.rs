//! JSON text to a value, with an answer to what programs write instead of numbers.
//!
//! `NaN`, `Infinity` and numbers beyond the range of f64 are not JSON, and a parser stops at the first of them. Programs that
//! compute write them all the same, so they are looked for first: each becomes a finding that names its field, and reading goes
//! on.

use crate::model::{FieldProblem, INPUT_LIMITS};
use serde_json::Value;
use std::collections::HashSet;

/// Findings listed at most: a list of a million wrong numbers is one mistake, and the answer stays readable.
pub(crate) const MOST_FINDINGS: usize = 100;

/// A document, and what was wrong with its numbers and names already.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed {
    /// The document, with null in the place of what is no number.
    pub value: Value,
    /// Numbers that are not finite, each with its pointer.
    pub problems: Vec<FieldProblem>,
}

/// Text that is no JSON document at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{detail}")]
pub struct Malformed {
    /// What is wrong, with line and column.
    pub detail: String,
    /// What to do about it, where it is known.
    pub hint: Option<String>,
}

/// # Errors
/// Not UTF-8, empty, cut off, not JSON, or nested more than 100 levels deep; with line and column.
pub fn parse(bytes: &[u8]) -> Result<Parsed, Malformed> {
    let malformed = |detail: String, hint: Option<&str>| Malformed {
        detail,
        hint: hint.map(str::to_string),
    };
    let text = std::str::from_utf8(bytes).map_err(|e| {
        malformed(
            format!("the document is not UTF-8 text (at byte {})", e.valid_up_to()),
            Some("save it as UTF-8"),
        )
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(malformed("the document is empty".into(), Some("send a JSON object")));
    }
    let mut scan = Scan::new(text);
    scan.run();
    if scan.too_deep {
        return Err(malformed(
            format!("the document is nested more than {} levels deep", INPUT_LIMITS.json_depth),
            None,
        ));
    }
    let value = serde_json::from_slice(&scan.cleaned).map_err(|e| match e.is_eof() {
        true => malformed(
            format!("the document ends too early: {e}"),
            Some("it looks cut off: send all of it"),
        ),
        false => malformed(format!("the document is not JSON: {e}"), None),
    })?;
    Ok(Parsed {
        value,
        problems: scan.problems,
    })
}

/// Where in the document the scan stands.
enum Level {
    Object {
        names: HashSet<String>,
        name: String,
        expects_name: bool,
    },
    Array {
        index: usize,
    },
}

/// One pass over the text, no more of a parser than is needed to know the place of a bare word.
struct Scan<'a> {
    text: &'a str,
    /// The text with bad numbers replaced by zeros of the same length, so that lines and columns stay.
    cleaned: Vec<u8>,
    problems: Vec<FieldProblem>,
    levels: Vec<Level>,
    too_deep: bool,
}

impl<'a> Scan<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            cleaned: text.as_bytes().to_vec(),
            problems: Vec::new(),
            levels: Vec::new(),
            too_deep: false,
        }
    }

    fn run(&mut self) {
        let bytes = self.text.as_bytes();
        let mut at = 0;
        while at < bytes.len() && !self.too_deep {
            at = match bytes[at] {
                b'"' => self.string(at),
                b'{' => self.open(
                    Level::Object {
                        names: HashSet::new(),
                        name: String::new(),
                        expects_name: true,
                    },
                    at,
                ),
                b'[' => self.open(Level::Array { index: 0 }, at),
                b'}' | b']' => {
                    self.levels.pop();
                    at + 1
                }
                b',' => self.next_item(at),
                b'+' | b'-' | b'.' | b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' => self.word(at),
                _ => at + 1,
            };
        }
    }

    fn open(&mut self, level: Level, at: usize) -> usize {
        self.levels.push(level);
        self.too_deep = self.levels.len() > INPUT_LIMITS.json_depth;
        at + 1
    }

    fn next_item(&mut self, at: usize) -> usize {
        match self.levels.last_mut() {
            Some(Level::Object { expects_name, .. }) => *expects_name = true,
            Some(Level::Array { index }) => *index += 1,
            None => {}
        }
        at + 1
    }

    /// Goes over a string; where a name is due, it is one.
    fn string(&mut self, start: usize) -> usize {
        let bytes = self.text.as_bytes();
        let mut end = start + 1;
        while end < bytes.len() && bytes[end] != b'"' {
            end += if bytes[end] == b'\\' { 2 } else { 1 };
        }
        let end = (end + 1).min(bytes.len());
        if let Some(Level::Object {
            names,
            name,
            expects_name,
        }) = self.levels.last_mut()
            && *expects_name
            && let Ok(found) = serde_json::from_slice::<String>(&bytes[start..end])
        {
            *expects_name = false;
            *name = found;
            if !names.insert(name.clone()) && self.problems.len() <= MOST_FINDINGS {
                let pointer = self.pointer();
                self.problems
                    .push(FieldProblem::new(pointer, "appears twice").with_hint("keep one of them"));
            }
        }
        end
    }

    fn word(&mut self, start: usize) -> usize {
        let bytes = self.text.as_bytes();
        let rest = &bytes[start..];
        let length = rest
            .iter()
            .position(|b| !(b.is_ascii_alphanumeric() || b"+-.".contains(b)))
            .unwrap_or(rest.len());
        let end = start + length;
        let word = &self.text[start..end];
        // Rust reads `nan`, `inf`, `infinity` in any case, as well as all JSON numbers; those that overflow become infinite.
        if word.parse::<f64>().is_ok_and(|v| !v.is_finite()) {
            let digits = word.bytes().any(|b| b.is_ascii_digit());
            let detail = format!("is {}, not a finite number", if digits { "too large" } else { word });
            if self.problems.len() <= MOST_FINDINGS {
                self.problems.push(FieldProblem::new(self.pointer(), detail));
            }
            self.cleaned[start] = b'0';
            self.cleaned[start + 1..end].fill(b' ');
        }
        end
    }

    fn pointer(&self) -> String {
        let part = |level: &Level| match level {
            Level::Object { name, .. } => format!("/{}", escaped(name)),
            Level::Array { index } => format!("/{index}"),
        };
        self.levels.iter().map(part).collect()
    }
}

/// A name as a part of a JSON pointer.
pub(crate) fn escaped(name: &str) -> String {
    shortened(name).replace('~', "~0").replace('/', "~1")
}

/// Names a client made up can be megabytes long.
pub(crate) fn shortened(text: &str) -> String {
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_that_are_none_are_named_and_reading_goes_on() {
        let parsed = parse(br#"{"a": [1, NaN, -Infinity], "b/c": {"d": 1e999, "text": "NaN, [{ \" Infinity"}}"#).unwrap();
        assert_eq!(
            parsed.value,
            json!({"a": [1, 0, 0], "b/c": {"d": 0, "text": "NaN, [{ \" Infinity"}})
        );
        let found: Vec<_> = parsed.problems.iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "/a/1: is NaN, not a finite number",
                "/a/2: is -Infinity, not a finite number",
                "/b~1c/d: is too large, not a finite number",
            ]
        );
    }

    #[test]
    fn a_field_given_twice_is_named() {
        let parsed = parse(br#"[{"x": 1}, {"x": 1, "y": {"x": 2}, "x": 3}]"#).unwrap();
        assert_eq!(parsed.problems.len(), 1);
        assert_eq!(parsed.problems[0].pointer, "/1/x");
    }

    #[test]
    fn text_that_is_no_document_is_refused_with_the_reason() {
        let reason = |bytes: &[u8]| parse(bytes).unwrap_err().detail;
        assert!(reason(b"  \n").contains("is empty"));
        assert!(reason(br#"{"a": [1, 2"#).contains("ends too early"));
        assert!(reason(br#"{"a": "unfinished \"#).contains("ends too early"));
        assert!(reason(b"{'a': 1}").contains("not JSON"));
        assert!(reason(b"\xff\xfe{}").contains("not UTF-8"));
        assert!(reason("[".repeat(1_000_000).as_bytes()).contains("nested"));
    }

    #[test]
    fn every_f64_survives_writing_and_reading() {
        for bits in [
            0x3fb999999999999au64,
            0x0000000000000001,
            0x7fefffffffffffff,
            0x3ff0000000000001,
            0x8000000000000000,
        ] {
            let v = f64::from_bits(bits);
            let text = serde_json::to_vec(&v).unwrap();
            assert_eq!(parse(&text).unwrap().value.as_f64().unwrap().to_bits(), bits);
        }
    }
}
