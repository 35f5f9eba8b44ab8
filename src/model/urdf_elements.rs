//! The XML of a URDF file, before the URDF parser sees it.
//!
//! The parser fills missing inertials and limits with zeros without a word, and refuses a file whose joint has two `<origin>`s or whose
//! meshes it does not understand. So the XML is looked at first: what it states is noted, and what has no part in the dynamics, or is
//! there twice, is cut out.

use super::{FieldProblem, ModelError};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// What the file states in so many words, and the part of it that matters.
pub(super) struct UrdfElements {
    /// Links with a mass of their own.
    pub inertials: HashSet<String>,
    /// Attributes of every joint's `<limit>`.
    pub limits: HashMap<String, HashSet<String>>,
    /// Elements that are there twice, in words.
    pub notes: Vec<String>,
    /// The file without what was cut out.
    pub xml: String,
}

impl UrdfElements {
    pub fn read(xml: &str) -> Result<Self, ModelError> {
        let options = ParsingOptions {
            allow_dtd: false,
            nodes_limit: 1_000_000,
            ..Default::default()
        };
        let document = Document::parse_with_options(xml, options).map_err(|e| {
            let problem = FieldProblem::new("/urdf", format!("is not readable XML: {e}"));
            ModelError(vec![problem.with_hint("check that the file is complete")])
        })?;
        let mut found = Self {
            inertials: HashSet::new(),
            limits: HashMap::new(),
            notes: Vec::new(),
            xml: String::new(),
        };
        let mut cut = Vec::new();
        for node in document.root_element().children().filter(Node::is_element) {
            match (node.tag_name().name(), node.attribute("name")) {
                ("link", Some(name)) => found.link(node, name, &mut cut),
                ("joint", Some(name)) => found.joint(node, name, &mut cut),
                // Transmissions and simulator settings say nothing of the mechanics; a joint named in them is not a joint.
                ("transmission" | "gazebo" | "ros2_control", _) => cut.push(node.range()),
                _ => {}
            }
        }
        found.xml = without(xml, cut);
        Ok(found)
    }

    fn link(&mut self, link: Node, name: &str, cut: &mut Vec<Range<usize>>) {
        let shapes = ["visual", "collision"];
        cut.extend(
            link.children()
                .filter(|c| shapes.contains(&c.tag_name().name()))
                .map(|c| c.range()),
        );
        self.keep_first(link, &["inertial"], &format!("link `{name}`"), cut);
        if let Some(inertial) = link.children().find(|c| c.has_tag_name("inertial")) {
            self.keep_first(
                inertial,
                &["origin", "mass", "inertia"],
                &format!("the inertial of link `{name}`"),
                cut,
            );
            if inertial.children().any(|c| c.has_tag_name("mass")) {
                self.inertials.insert(name.to_string());
            }
        }
    }

    fn joint(&mut self, joint: Node, name: &str, cut: &mut Vec<Range<usize>>) {
        self.keep_first(
            joint,
            &["origin", "parent", "child", "axis", "limit", "dynamics"],
            &format!("joint `{name}`"),
            cut,
        );
        if let Some(limit) = joint.children().find(|c| c.has_tag_name("limit")) {
            let attributes = limit.attributes().map(|a| a.name().to_string()).collect();
            self.limits.insert(name.to_string(), attributes);
        }
    }

    /// The first of several elements counts, as in ROS's own parser (urdfdom).
    fn keep_first(&mut self, parent: Node, tags: &[&str], place: &str, cut: &mut Vec<Range<usize>>) {
        for tag in tags {
            let further = parent.children().filter(|c| c.has_tag_name(*tag)).skip(1);
            let before = cut.len();
            cut.extend(further.map(|c| c.range()));
            if cut.len() > before {
                self.notes
                    .push(format!("{place} has more than one <{tag}>: the first is used"));
            }
        }
    }
}

/// `text` without the given ranges, which stand in the order of the text and do not overlap.
fn without(text: &str, cut: Vec<Range<usize>>) -> String {
    let mut ordered = cut;
    ordered.sort_by_key(|r| r.start);
    let mut kept = String::with_capacity(text.len());
    let mut from = 0;
    for range in ordered {
        // A second <inertial> and something inside it would overlap: the outer one comes first.
        if range.start >= from {
            kept.push_str(&text[from..range.start]);
            from = range.end;
        }
    }
    kept.push_str(&text[from..]);
    kept
}
