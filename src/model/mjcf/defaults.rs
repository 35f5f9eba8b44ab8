//! Default classes: attributes that elements have without stating them.

use super::orientation::ORIENTATIONS;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// Attributes that are read, with the elements that have them.
const ATTRIBUTES: [(&str, &str); 25] = [
    ("joint", "type"),
    ("joint", "axis"),
    ("joint", "pos"),
    ("joint", "range"),
    ("joint", "limited"),
    ("joint", "ref"),
    ("joint", "armature"),
    ("joint", "damping"),
    ("joint", "frictionloss"),
    ("joint", "actuatorfrcrange"),
    ("geom", "type"),
    ("geom", "mesh"),
    ("geom", "size"),
    ("geom", "fromto"),
    ("geom", "contype"),
    ("geom", "conaffinity"),
    ("geom", "pos"),
    ("geom", "quat"),
    ("geom", "axisangle"),
    ("geom", "euler"),
    ("geom", "xyaxes"),
    ("geom", "zaxis"),
    ("mesh", "scale"),
    ("mesh", "refpos"),
    ("mesh", "refquat"),
];

type Values<'a> = [Option<&'a str>; ATTRIBUTES.len()];

/// Attributes by class. A class has those of the class around it.
pub(super) struct Defaults<'a> {
    classes: HashMap<&'a str, Values<'a>>,
    /// The class of elements without one.
    top: &'a str,
}

impl<'a> Defaults<'a> {
    pub fn of(document: &'a Document<'a>) -> Self {
        let mut classes: HashMap<&str, Values> = HashMap::new();
        let named = |n: Node<'a, 'a>| n.attribute("class").unwrap_or("main");
        let within = |n: Node<'a, 'a>| n.children().filter(|c| c.has_tag_name("default")).collect::<Vec<_>>();
        let tops = within(document.root_element());
        // Backwards, as the last of a stack is the first to come.
        let mut open: Vec<(Node<'a, 'a>, Values<'a>)> = tops.iter().rev().map(|n| (*n, Values::default())).collect();
        while let Some((node, around)) = open.pop() {
            // A section may go on with a class of one before it.
            let mut values = classes.get(named(node)).copied().unwrap_or(around);
            for element in node.children().filter(Node::is_element) {
                overwrite(&mut values, element);
            }
            classes.insert(named(node), values);
            open.extend(within(node).into_iter().rev().map(|n| (n, values)));
        }
        Self {
            classes,
            top: tops.first().map_or("main", |n| named(*n)),
        }
    }

    /// The attributes of an element within bodies of the class `around`.
    pub fn attributes(&self, node: Node<'a, 'a>, around: Option<&str>) -> Attributes<'a> {
        let class = node.attribute("class").or(around).unwrap_or(self.top);
        let mut values = self.classes.get(class).copied().unwrap_or_default();
        overwrite(&mut values, node);
        let tag = node.tag_name().name();
        Attributes {
            tag: if tag == "freejoint" { "joint" } else { tag },
            values,
        }
    }
}

/// An orientation that is stated takes the place of those that are not, whatever their kind.
fn overwrite<'a>(values: &mut Values<'a>, node: Node<'a, 'a>) {
    let tag = node.tag_name().name();
    let is_orientation = |name: &str| ORIENTATIONS.iter().any(|(other, _)| *other == name);
    let is_turned = ORIENTATIONS.iter().any(|(name, _)| node.has_attribute(*name));
    for (value, (of, name)) in values.iter_mut().zip(ATTRIBUTES) {
        if of == tag {
            let inherited = value.filter(|_| !(is_turned && is_orientation(name)));
            *value = node.attribute(name).or(inherited);
        }
    }
}

/// The attributes of one element, stated or by default.
pub(super) struct Attributes<'a> {
    tag: &'a str,
    values: Values<'a>,
}

impl<'a> Attributes<'a> {
    pub fn get(&self, name: &str) -> Option<&'a str> {
        let at = ATTRIBUTES.iter().position(|&(of, own)| of == self.tag && own == name);
        at.and_then(|at| self.values[at])
    }
}
