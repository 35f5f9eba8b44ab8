//! Writing XML without errors to handle: into memory.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

pub(super) struct Xml(Writer<Vec<u8>>);

impl Xml {
    pub fn new() -> Self {
        let mut xml = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.put(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        xml
    }

    fn put(&mut self, event: Event) {
        self.0.write_event(event).expect("writing to memory does not fail");
    }

    fn start<'a>(name: &'a str, attributes: &[(&str, &str)]) -> BytesStart<'a> {
        BytesStart::new(name).with_attributes(attributes.iter().copied())
    }

    pub fn open(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.put(Event::Start(Self::start(name, attributes)));
    }

    pub fn close(&mut self, name: &str) {
        self.put(Event::End(BytesEnd::new(name)));
    }

    pub fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.put(Event::Empty(Self::start(name, attributes)));
    }

    /// An element with text.
    pub fn text(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.open(name, attributes);
        self.put(Event::Text(BytesText::new(text)));
        self.close(name);
    }

    /// Lines of one comment; nothing for none.
    pub fn comment(&mut self, lines: &[String]) {
        if !lines.is_empty() {
            self.put(Event::Comment(BytesText::from_escaped(comment(lines))));
        }
    }

    pub fn finish(self) -> String {
        String::from_utf8(self.0.into_inner()).expect("XML is UTF-8") + "\n"
    }
}

/// Text of an XML comment, which two hyphens in a row would end.
pub(super) fn comment(lines: &[String]) -> String {
    let mut text = String::from(" ");
    for letter in lines.join("\n     ").chars() {
        if letter == '-' && text.ends_with('-') {
            text.push(' ');
        }
        text.push(letter);
    }
    text.push(' ');
    text
}
