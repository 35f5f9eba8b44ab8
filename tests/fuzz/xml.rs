//! XML as a tree of elements.

use super::dice::Dice;
use super::tokens;

#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Child>,
    /// Before the root element; of the root alone.
    prolog: String,
}

#[derive(Debug, Clone, PartialEq)]
enum Child {
    Element(Element),
    /// As it stands in the file.
    Raw(String),
}

const BILLION_LAUGHS: &str = "<!DOCTYPE r [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;\">\
    <!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;\"><!ENTITY d \"&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;\">]>";

impl Element {
    pub fn parse(text: &str) -> Self {
        let document = roxmltree::Document::parse(text).expect("a base document is XML");
        Self::of(document.root_element())
    }

    fn of(node: roxmltree::Node) -> Self {
        let children = node
            .children()
            .filter(|c| c.is_element())
            .map(|c| Child::Element(Self::of(c)));
        Self {
            name: node.tag_name().name().to_string(),
            attributes: node
                .attributes()
                .map(|a| (a.name().to_string(), a.value().to_string()))
                .collect(),
            children: children.collect(),
            prolog: String::new(),
        }
    }

    pub fn render(&self) -> String {
        let mut text = self.prolog.clone();
        self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) {
        out.push_str(&format!("<{}", self.name));
        for (name, value) in &self.attributes {
            out.push_str(&format!(
                " {name}=\"{}\"",
                value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
            ));
        }
        if self.children.is_empty() {
            out.push_str("/>");
            return;
        }
        out.push_str(">\n");
        for child in &self.children {
            match child {
                Child::Element(element) => element.write(out),
                Child::Raw(text) => out.push_str(text),
            }
        }
        out.push_str(&format!("</{}>\n", self.name));
    }

    fn elements(&self) -> impl Iterator<Item = &Element> {
        self.children.iter().filter_map(|c| match c {
            Child::Element(element) => Some(element),
            Child::Raw(_) => None,
        })
    }

    fn count(&self) -> usize {
        1 + self.elements().map(Element::count).sum::<usize>()
    }

    fn at(&mut self, index: &mut usize) -> Option<&mut Element> {
        if *index == 0 {
            return Some(self);
        }
        *index -= 1;
        self.children.iter_mut().find_map(|c| match c {
            Child::Element(element) => element.at(index),
            Child::Raw(_) => None,
        })
    }

    /// Values of all attributes of this name: what one element may take from another makes cycles, doubles and wrong references.
    fn values(&self, name: &str, into: &mut Vec<String>) {
        into.extend(self.attributes.iter().filter(|(n, _)| n == name).map(|(_, v)| v.clone()));
        self.elements().for_each(|e| e.values(name, into));
    }

    /// Changes one place.
    pub fn mutate(&mut self, dice: &mut Dice) {
        if dice.chance(0.02) {
            self.prolog = dice
                .pick(&[
                    "<?xml version=\"1.1\"?>",
                    "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
                    "\u{feff}",
                    "<!-- -->",
                    BILLION_LAUGHS,
                    "x",
                ])
                .to_string();
        }
        let whole = self.clone();
        let count = self.count();
        let (mut index, mut other) = (dice.below(count), dice.below(count));
        let piece = self.at(&mut other).cloned();
        if let Some(element) = self.at(&mut index) {
            match dice.chance(0.6) && !element.attributes.is_empty() {
                true => element.change_attribute(&whole, dice),
                false => element.change_children(piece, dice),
            }
        }
    }

    fn change_attribute(&mut self, whole: &Element, dice: &mut Dice) {
        let at = dice.below(self.attributes.len());
        match dice.below(12) {
            0 => drop(self.attributes.remove(at)),
            1 => {
                self.attributes[at].0 = dice
                    .pick(&["name", "xyz", "rpy", "value", "link", "type", "é", "a:b", "x"])
                    .to_string()
            }
            2 => self.attributes.push(self.attributes[at].clone()),
            3 => self.attributes[at].1 = tokens::word(dice),
            4..=6 => {
                let mut values = Vec::new();
                whole.values(&self.attributes[at].0, &mut values);
                self.attributes[at].1.clone_from(&values[dice.below(values.len())]);
            }
            _ => change_numbers(&mut self.attributes[at].1, dice),
        }
    }

    fn change_children(&mut self, piece: Option<Element>, dice: &mut Dice) {
        let at = dice.below(self.children.len());
        let piece = piece.map_or(Child::Raw(tokens::word(dice)), Child::Element);
        match dice.below(12) {
            0 | 1 if !self.children.is_empty() => drop(self.children.remove(at)),
            2 if !self.children.is_empty() => self.children.push(self.children[at].clone()),
            3 | 4 => self.children.insert(at, piece),
            5 if self.children.len() > 1 => self.children.swap(0, at),
            6 => {
                self.name = dice
                    .pick(&["joint", "link", "robot", "origin", "xacro:macro", "sdf", "mujoco", "é", "x"])
                    .to_string()
            }
            7 => self.children.push(Child::Raw(tokens::word(dice))),
            8 => {
                let depth = [10, 90, 300, 4_000, 60_000][dice.below(5)];
                self.children
                    .push(Child::Raw(format!("{}{}", "<g>".repeat(depth), "</g>".repeat(depth))));
            }
            9 => self.children.push(Child::Raw(
                dice.pick(&["<![CDATA[ ]]>", "<!-- -- -->", "&a;", "&#0;", "&#xD800;", "<?x?>"])
                    .to_string(),
            )),
            10 => self.children.clear(),
            _ => {
                let values = [
                    "fixed",
                    "continuous",
                    "prismatic",
                    "planar",
                    "floating",
                    "revolute",
                    "box",
                    "1 0 0",
                    "0 0 0",
                ];
                let name = dice.pick(&["type", "axis", "xyz", "filename"]).to_string();
                self.attributes.push((name, dice.pick(&values).to_string()));
            }
        }
    }
}

/// One of the numbers in a text like `0 0 1.57`.
fn change_numbers(text: &mut String, dice: &mut Dice) {
    let mut parts: Vec<String> = text.split_whitespace().map(str::to_string).collect();
    let at = dice.below(parts.len());
    match parts.get_mut(at) {
        Some(part) => *part = tokens::another(part, dice),
        None => parts.push(tokens::number(dice)),
    }
    if dice.chance(0.1) {
        parts.truncate(at);
    }
    *text = parts.join(dice.pick(&[" ", " ", " ", "  ", "\n", ","]));
}
