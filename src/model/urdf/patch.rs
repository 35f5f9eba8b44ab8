//! New bodies in a URDF file that otherwise stays as it is, byte by byte.

use super::elements::read_tree;
use super::is_urdf;
use crate::model::link_tree::{CarriedLinks, ChainEnds, carried};
use crate::model::notes::Notes;
use crate::model::xml::XmlText;
use crate::model::{ModelError, Rounding, shortest};
use crate::spatial::PhysicalInertia;
use roxmltree::Node;
use std::ops::Range;

/// The movable joints of a file's chain with the links that they carry.
///
/// # Errors
/// As [`from_urdf`](super::from_urdf).
pub fn urdf_carried(xml: &str, ends: ChainEnds, rounding: Rounding) -> Result<Vec<CarriedLinks>, ModelError> {
    let mut notes = Notes::default();
    let text = XmlText::new(xml, "/urdf", &mut notes)?;
    let document = text.parse()?;
    is_urdf(&text, &document)?;
    carried(&read_tree(&text, &document, rounding, &mut notes)?, ends)
}

/// What is to stand in a file for one link or joint.
#[derive(Debug, Clone, PartialEq)]
pub enum NewBody {
    /// Mass, centre and inertia in the link's frame.
    Body(PhysicalInertia),
    /// No `<inertial>`.
    None,
    /// Of a joint: viscous and Coulomb friction.
    Friction(f64, f64),
}

/// The file with new bodies of links and friction of joints, by name.
///
/// # Errors
/// Not XML.
pub fn urdf_with_bodies(xml: &str, new: &[(String, NewBody)]) -> Result<String, ModelError> {
    let text = XmlText::new(xml, "/urdf", &mut Notes::default())?;
    let document = text.parse()?;
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    for (name, body) in new {
        let tag = if matches!(body, NewBody::Friction(..)) {
            "joint"
        } else {
            "link"
        };
        let mut elements = document.root_element().children().filter(|c| c.has_tag_name(tag));
        let Some(node) = elements.find(|n| n.attribute("name") == Some(name)) else {
            continue;
        };
        edits.extend(match body {
            NewBody::Body(inertia) => vec![put_inertial(&text, node, inertia)],
            NewBody::None => child(node, "inertial").map(|n| without(&text, n)).into_iter().collect(),
            NewBody::Friction(viscous, coulomb) => put_friction(&text, node, *viscous, *coulomb),
        });
    }
    let bare = xml.trim_start_matches('\u{feff}');
    edits.sort_by_key(|(range, _)| range.start);
    let (mut patched, mut at) = (String::with_capacity(bare.len() + 4096), 0);
    for (range, with) in edits {
        let (from, to) = (text.in_file(range.start), text.in_file(range.end));
        patched.push_str(&bare[at..from]);
        patched.push_str(&with);
        at = to;
    }
    patched.push_str(&bare[at..]);
    Ok(patched)
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.has_tag_name(tag))
}

/// Blanks at the start of the line on which a node begins.
fn indent(text: &XmlText, node: Node) -> String {
    let before = &text.as_str()[..node.range().start];
    let line = before.rsplit('\n').next().unwrap_or_default();
    line.chars().take_while(|c| c.is_whitespace()).collect()
}

fn put_inertial(text: &XmlText, link: Node, body: &PhysicalInertia) -> (Range<usize>, String) {
    let margin = indent(text, link) + "  ";
    let c = body.center_of_mass;
    let i = |r, k| shortest(body.inertia[(r, k)]);
    let content = format!(
        "<inertial>\n{margin}  <origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/>\n{margin}  <mass value=\"{}\"/>\n{margin}  <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" \
         iyz=\"{}\" izz=\"{}\"/>\n{margin}</inertial>",
        shortest(c.x),
        shortest(c.y),
        shortest(c.z),
        shortest(body.mass),
        i(0, 0),
        i(0, 1),
        i(0, 2),
        i(1, 1),
        i(1, 2),
        i(2, 2)
    );
    match child(link, "inertial") {
        Some(old) => (old.range(), content),
        None => first_child(text, link, &content, &margin),
    }
}

/// A new first child of an element.
fn first_child(text: &XmlText, node: Node, content: &str, margin: &str) -> (Range<usize>, String) {
    let range = node.range();
    let end = start_tag_end(&text.as_str()[range.clone()]) + range.start;
    let outer = &margin[..margin.len() - 2];
    // `<link name="a"/>` has no end of its own.
    match text.as_str()[..end].ends_with("/>") {
        true => (
            end - 2..end,
            format!(">\n{margin}{content}\n{outer}</{}>", node.tag_name().name()),
        ),
        false => (end..end, format!("\n{margin}{content}")),
    }
}

/// Length of the start tag that a text begins with.
fn start_tag_end(text: &str) -> usize {
    let mut quote = None;
    for (at, letter) in text.char_indices() {
        match (quote, letter) {
            (None, '>') => return at + 1,
            (None, '"' | '\'') => quote = Some(letter),
            (Some(q), l) if q == l => quote = None,
            _ => {}
        }
    }
    text.len()
}

/// An element left out, with the blanks before it.
fn without(text: &XmlText, node: Node) -> (Range<usize>, String) {
    let range = node.range();
    let before = &text.as_str()[..range.start];
    (before.trim_end().len()..range.end, String::new())
}

fn put_friction(text: &XmlText, joint: Node, viscous: f64, coulomb: f64) -> Vec<(Range<usize>, String)> {
    let values = [("damping", shortest(viscous)), ("friction", shortest(coulomb))];
    let Some(old) = child(joint, "dynamics") else {
        let content = format!("<dynamics damping=\"{}\" friction=\"{}\"/>", values[0].1, values[1].1);
        let margin = indent(text, joint) + "  ";
        return vec![first_child(text, joint, &content, &margin)];
    };
    let tag_end = old.range().start + "<dynamics".len();
    let mut missing = String::new();
    let mut edits = Vec::new();
    for (name, value) in values {
        match old.attributes().find(|a| a.name() == name && a.namespace().is_none()) {
            Some(attribute) => edits.push((attribute.range_value(), value)),
            None => missing += &format!(" {name}=\"{value}\""),
        }
    }
    if !missing.is_empty() {
        edits.push((tag_end..tag_end, missing));
    }
    edits
}
