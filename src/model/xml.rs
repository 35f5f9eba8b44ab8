//! XML as robot files have it, made ready for a strict parser, and held to the limits on its size.
//!
//! Files in the wild have a comment before the XML declaration, or prefixes that nobody declared (`drake:acceleration`). Both are
//! mended here. One pass without recursion counts levels, elements and attributes before any tree is built.

use super::notes::Notes;
use super::{FieldProblem, INPUT_LIMITS, ModelError};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeSet;
use std::ops::Range;

/// The text of a robot file, ready to be parsed.
pub struct XmlText {
    text: String,
    /// Where every line starts.
    lines: Vec<usize>,
    /// Declarations that were put in, in bytes of `text`.
    inserted: Range<usize>,
    /// Field of the document that holds the file: `/urdf` or `/mjcf`.
    pub field: &'static str,
}

impl XmlText {
    /// # Errors
    /// Too deep, too many elements or attributes, a document type with declarations of its own.
    pub fn new(xml: &str, field: &'static str, notes: &mut Notes) -> Result<Self, ModelError> {
        let xml = xml.trim_start_matches('\u{feff}');
        let scan = Scan::from_text(xml, field)?;
        for prefix in scan.unbound() {
            notes.push(format!(
                "the file does not declare the XML prefix `{prefix}`: it is read as if it did"
            ));
        }
        let text = scan.mended(xml);
        let from = scan.root.unwrap_or(0);
        let inserted = from..from + text.len().saturating_sub(xml.len());
        let lines = std::iter::once(0)
            .chain(memchr::memchr_iter(b'\n', text.as_bytes()).map(|at| at + 1))
            .collect();
        Ok(Self {
            text,
            lines,
            inserted,
            field,
        })
    }

    /// # Errors
    /// Not well-formed, with line and column.
    pub fn parse(&self) -> Result<Document<'_>, ModelError> {
        let options = ParsingOptions {
            allow_dtd: false,
            nodes_limit: u32::MAX,
            ..Default::default()
        };
        Document::parse_with_options(&self.text, options).map_err(|e| {
            single(
                self.field,
                format!("is not readable XML: {e}"),
                "check that the file is complete and well-formed",
            )
        })
    }

    /// Line of a node in the file, from 1.
    pub fn line(&self, node: Node) -> usize {
        self.lines.partition_point(|&start| start <= node.range().start)
    }
}

impl XmlText {
    /// Place of a byte of the parsed text in the file as it was given, a byte-order mark left out.
    pub fn in_file(&self, at: usize) -> usize {
        match at < self.inserted.start {
            true => at,
            false => at.max(self.inserted.end) - self.inserted.len(),
        }
    }

    /// The text that is parsed.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

/// One problem as an error.
pub(super) fn single(pointer: &str, detail: impl Into<String>, hint: impl Into<String>) -> ModelError {
    ModelError(vec![FieldProblem::new(pointer, detail).with_hint(hint)])
}

/// What one pass over the text finds.
#[derive(Default)]
struct Scan {
    elements: usize,
    used: BTreeSet<String>,
    declared: BTreeSet<String>,
    /// Where declarations can be put into the root's tag.
    root: Option<usize>,
    /// Declarations at the wrong place and document types.
    blanked: Vec<Range<usize>>,
}

impl Scan {
    fn from_text(xml: &str, field: &'static str) -> Result<Self, ModelError> {
        let mut reader = Reader::from_str(xml);
        reader.config_mut().check_end_names = false;
        let (mut scan, mut depth) = (Self::default(), 0usize);
        let refuse = |detail: String| single(field, detail, "give the file of one robot");
        loop {
            let from = reader.buffer_position() as usize;
            // What is not well-formed is said by the parser, with line and column.
            let Ok(event) = reader.read_event() else { break };
            let to = reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => {
                    depth += 1;
                    if depth > INPUT_LIMITS.xml_depth {
                        let detail = format!("has elements nested more than {} levels deep", INPUT_LIMITS.xml_depth);
                        return Err(refuse(detail));
                    }
                    scan.element(&tag, from).map_err(refuse)?;
                }
                Event::Empty(tag) => scan.element(&tag, from).map_err(refuse)?,
                Event::End(_) => depth = depth.saturating_sub(1),
                Event::Decl(_) if from > 0 => scan.blanked.push(from..to),
                Event::DocType(text) => {
                    if text.contains(&b'[') {
                        return Err(single(
                            field,
                            "has a document type with declarations of its own, which are not read",
                            "take the <!DOCTYPE …> away",
                        ));
                    }
                    scan.blanked.push(from..to);
                }
                Event::Eof => break,
                _ => {}
            }
        }
        Ok(scan)
    }

    fn element(&mut self, tag: &BytesStart, from: usize) -> Result<(), String> {
        self.elements += 1;
        if self.elements > INPUT_LIMITS.xml_elements {
            return Err(format!("has more than {} elements", INPUT_LIMITS.xml_elements));
        }
        let name = tag.name();
        if self.root.is_none() {
            self.root = Some(from + 1 + name.as_ref().len());
        }
        self.uses(name.as_ref());
        for (count, attribute) in tag.attributes().with_checks(false).flatten().enumerate() {
            if count >= INPUT_LIMITS.xml_attributes {
                return Err(format!(
                    "has an element with more than {} attributes",
                    INPUT_LIMITS.xml_attributes
                ));
            }
            match attribute.key.as_ref().strip_prefix(b"xmlns:") {
                Some(prefix) => {
                    self.declared.insert(String::from_utf8_lossy(prefix).into_owned());
                }
                None => self.uses(attribute.key.as_ref()),
            }
        }
        Ok(())
    }

    fn uses(&mut self, name: &[u8]) {
        let Some(colon) = memchr::memchr(b':', name) else { return };
        let prefix = String::from_utf8_lossy(&name[..colon]);
        if self.used.len() < INPUT_LIMITS.xml_prefixes && !self.used.contains(prefix.as_ref()) {
            self.used.insert(prefix.into_owned());
        }
    }

    fn unbound(&self) -> impl Iterator<Item = &String> {
        let is_name = |p: &&String| !p.is_empty() && *p != "xml" && *p != "xmlns";
        self.used.difference(&self.declared).filter(is_name)
    }

    /// The text with what is in the way made blank, so that lines stay, and missing declarations in the root's tag.
    fn mended(&self, xml: &str) -> String {
        let mut text = String::with_capacity(xml.len());
        let mut at = 0;
        for range in &self.blanked {
            text.push_str(&xml[at..range.start]);
            text.extend(xml[range.clone()].bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }));
            at = range.end;
        }
        text.push_str(&xml[at..]);
        if let Some(root) = self.root {
            let declaration = |p: &String| format!(" xmlns:{p}=\"urn:undeclared:{p}\"");
            text.insert_str(root, &self.unbound().map(declaration).collect::<String>());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(xml: &str) -> Result<(usize, Vec<String>), String> {
        let mut notes = Notes::default();
        let text = XmlText::new(xml, "/urdf", &mut notes).map_err(|e| e.to_string())?;
        let document = text.parse().map_err(|e| e.to_string())?;
        let last = document.descendants().rfind(Node::is_element).expect("has a root");
        Ok((text.line(last), notes.into_list()))
    }

    #[test]
    fn what_files_in_the_wild_have_is_mended() {
        let comment_first =
            "<!-- made by hand: ü -->\n<?xml version=\"1.0\"?>\n<!DOCTYPE robot>\n<robot name=\"a\"><link name=\"b\"/></robot>";
        assert_eq!(parsed(comment_first).unwrap(), (4, vec![]));
        let undeclared = "<?xml version='1.0'?>\n<robot><limit drake:a=\"1\"/><x:y\n z:q='2'/></robot>";
        let (line, notes) = parsed(undeclared).unwrap();
        assert_eq!((line, notes.len()), (2, 3), "{notes:?}");
        let declared = "<robot xmlns:x='u'><x:y/></robot>";
        assert_eq!(parsed(declared).unwrap(), (1, vec![]));
    }

    #[test]
    fn sizes_are_limited_before_a_tree_is_built() {
        let deep = format!("<r>{}{}</r>", "<g>".repeat(100_000), "</g>".repeat(100_000));
        assert!(parsed(&deep).unwrap_err().contains("more than 200 levels"));
        let wide = format!("<r {}/>", (0..100_000).map(|i| format!("a{i}='' ")).collect::<String>());
        assert!(parsed(&wide).unwrap_err().contains("more than 256 attributes"));
        let many = format!("<r>{}</r>", "<g/>".repeat(300_000));
        assert!(parsed(&many).unwrap_err().contains("more than 200000 elements"));
        assert!(parsed("<!DOCTYPE r [<!ENTITY a 'b'>]><r/>").unwrap_err().contains("DOCTYPE"));
    }

    #[test]
    fn what_is_cut_off_is_refused_with_its_place() {
        let text = "<robot>\n<link name=\"é\">\n</robot>";
        assert!(parsed(text).unwrap_err().contains("3:"), "{:?}", parsed(text));
        for end in 0..text.len() {
            if text.is_char_boundary(end) {
                let _ = parsed(&text[..end]);
            }
        }
    }
}
