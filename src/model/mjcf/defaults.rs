//! Default classes: attributes that joints have without stating them.

use roxmltree::{Document, Node};
use std::collections::HashMap;

/// Attributes of joints that are read.
const ATTRIBUTES: [&str; 10] = [
    "type",
    "axis",
    "pos",
    "range",
    "limited",
    "ref",
    "armature",
    "damping",
    "frictionloss",
    "actuatorfrcrange",
];

type Values<'a> = [Option<&'a str>; ATTRIBUTES.len()];

/// Attributes of joints by class. A class has those of the class around it.
pub(super) struct Defaults<'a>(HashMap<&'a str, Values<'a>>);

impl<'a> Defaults<'a> {
    pub fn of(document: &'a Document<'a>) -> Self {
        let mut classes = HashMap::new();
        let tops = document.root_element().children().filter(|c| c.has_tag_name("default"));
        let mut open: Vec<(Node<'a, 'a>, Values<'a>)> = tops.map(|n| (n, Values::default())).collect();
        while let Some((node, mut values)) = open.pop() {
            for joint in node.children().filter(|c| c.has_tag_name("joint")) {
                overwrite(&mut values, joint);
            }
            classes.insert(node.attribute("class").unwrap_or("main"), values);
            open.extend(node.children().filter(|c| c.has_tag_name("default")).map(|n| (n, values)));
        }
        Self(classes)
    }

    /// The attributes of a joint within bodies of the class `around`.
    pub fn attributes(&self, joint: Node<'a, 'a>, around: Option<&str>) -> Attributes<'a> {
        let class = joint.attribute("class").or(around).unwrap_or("main");
        let mut values = self.0.get(class).copied().unwrap_or_default();
        overwrite(&mut values, joint);
        Attributes(values)
    }
}

fn overwrite<'a>(values: &mut Values<'a>, joint: Node<'a, 'a>) {
    for (value, name) in values.iter_mut().zip(ATTRIBUTES) {
        *value = joint.attribute(name).or(*value);
    }
}

/// The attributes of one joint, stated or by default.
pub(super) struct Attributes<'a>(Values<'a>);

impl<'a> Attributes<'a> {
    pub fn get(&self, name: &str) -> Option<&'a str> {
        ATTRIBUTES.iter().position(|a| *a == name).and_then(|at| self.0[at])
    }
}
