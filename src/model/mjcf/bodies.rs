//! `<body>` and `<inertial>` of an MJCF file as a tree of links.

use super::assets::{MeshAsset, mesh_assets};
use super::defaults::Defaults;
use super::{Compiler, named};
use crate::model::link_tree::{Freedom, LinkTree, TreeJoint, TreeLink};
use crate::model::urdf::body_complaint;
use crate::model::xml::{XmlText, single};
use crate::model::{Limits, LinkMesh, ModelError};
use crate::spatial::{LinkInertia, PhysicalInertia, Transform};
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// A body that is still to be read, and the link that it hangs on.
struct Open<'a> {
    body: Held<'a>,
    on: usize,
}

/// An element within a body.
pub(super) struct Held<'a> {
    pub node: Node<'a, 'a>,
    /// Of a body in the link that holds it, of other elements of the frames around them.
    pub pose: Transform,
    /// Of what it is and holds, where that states none.
    pub class: Option<&'a str>,
}

pub(super) struct Reading<'a> {
    pub text: &'a XmlText,
    pub compiler: &'a Compiler,
    pub defaults: Defaults<'a>,
    /// Meshes by their names.
    pub assets: HashMap<String, MeshAsset>,
    /// Joints by the joint that they follow.
    pub follows: HashMap<&'a str, &'a str>,
    pub links: Vec<TreeLink>,
    pub joints: Vec<TreeJoint>,
    /// Of all bodies that are described by meshes alone.
    pub meshes: Vec<LinkMesh>,
}

/// The tree, and the meshes of its links.
///
/// # Errors
/// Bodies and joints that cannot be read, each with its line.
pub(super) fn read_bodies<'a>(
    text: &'a XmlText,
    document: &'a Document<'a>,
    compiler: &'a Compiler,
) -> Result<(LinkTree, Vec<LinkMesh>), ModelError> {
    let root = document.root_element();
    let coupled = root.descendants().filter(|n| {
        n.has_tag_name("joint")
            && n.parent().is_some_and(|p| p.has_tag_name("equality"))
            && n.attribute("active") != Some("false")
    });
    let mut reading = Reading {
        text,
        compiler,
        defaults: Defaults::of(document),
        follows: coupled
            .filter_map(|n| Some((n.attribute("joint1")?, n.attribute("joint2")?)))
            .collect(),
        assets: HashMap::new(),
        links: Vec::new(),
        joints: Vec::new(),
        meshes: Vec::new(),
    };
    reading.assets = mesh_assets(&reading, document);
    let mut open = Vec::new();
    for world in root.children().filter(|c| c.has_tag_name("worldbody")) {
        if reading.links.is_empty() {
            reading.links.push(TreeLink {
                name: "world".into(),
                line: text.line(world),
                inertia: None,
                capsules: Vec::new(),
                notes: Vec::new(),
            });
        }
        let inside = reading.held(world, None)?;
        reading.children(&inside, 0, &mut open)?;
    }
    while let Some(body) = open.pop() {
        reading.body(&body, &mut open)?;
    }
    let name = root.attribute("model").unwrap_or("robot").to_string();
    let tree = LinkTree::new(name, text.field, compiler.rounding, reading.links, reading.joints)?;
    Ok((tree, reading.meshes))
}

impl<'a> Reading<'a> {
    /// Puts bodies that hang on a link to those that are still to be read.
    fn children(&self, inside: &[Held<'a>], on: usize, open: &mut Vec<Open<'a>>) -> Result<(), ModelError> {
        // Backwards, as the last of a stack is the first to come.
        for held in inside.iter().rev().filter(|h| h.node.has_tag_name("body")) {
            let body = Held {
                node: held.node,
                pose: held.pose * self.pose(held.node)?,
                class: held.node.attribute("childclass").or(held.class),
            };
            open.push(Open { body, on });
        }
        Ok(())
    }

    /// Elements of a body of this class, those in its frames too, in the order of the file.
    fn held(&self, body: Node<'a, 'a>, class: Option<&'a str>) -> Result<Vec<Held<'a>>, ModelError> {
        let whole = Held {
            node: body,
            pose: Transform::identity(),
            class,
        };
        let (mut held, mut frames) = (Vec::new(), vec![whole]);
        while let Some(Held { node, pose, class }) = frames.pop() {
            for node in node.children().filter(Node::is_element) {
                if !node.has_tag_name("frame") {
                    held.push(Held { node, pose, class });
                    continue;
                }
                frames.push(Held {
                    node,
                    pose: pose * self.pose(node)?,
                    class: node.attribute("childclass").or(class),
                });
            }
        }
        held.sort_by_key(|h| h.node.range().start);
        Ok(held)
    }

    fn body(&mut self, next: &Open<'a>, open: &mut Vec<Open<'a>>) -> Result<(), ModelError> {
        let Open { body, on } = next;
        let (node, line) = (body.node, self.text.line(body.node));
        let name = named(node).unwrap_or_else(|| format!("body {}", self.links.len()));
        let inside = self.held(node, body.class)?;
        let joints: Vec<&Held> = inside
            .iter()
            .filter(|h| h.node.has_tag_name("joint") || h.node.has_tag_name("freejoint"))
            .collect();
        let (mut on, mut pose) = (*on, body.pose);
        for (k, joint) in joints.iter().enumerate() {
            // All joints of a body but the last carry nothing but the next.
            let link = match k + 1 == joints.len() {
                true => self.link(&inside, name.clone(), line)?,
                false => self.massless(format!("{name} {}", k + 1), line),
            };
            let joint = self.joint(joint, on, link, pose, &name)?;
            self.joints.push(joint);
            (on, pose) = (link, Transform::identity());
        }
        if joints.is_empty() {
            let link = self.link(&inside, name.clone(), line)?;
            self.joints.push(TreeJoint {
                name: format!("{name} weld"),
                line,
                freedom: Freedom::Fixed,
                parent: on,
                child: link,
                origin: pose,
                axis: Vector3::z(),
                anchor: Vector3::zeros(),
                reference: 0.0,
                limits: Limits::unlimited(),
                viscous: 0.0,
                coulomb: 0.0,
                mimics: None,
                notes: Vec::new(),
            });
            on = link;
        }
        self.children(&inside, on, open)
    }

    fn massless(&mut self, name: String, line: usize) -> usize {
        self.links.push(TreeLink {
            name,
            line,
            inertia: Some(LinkInertia::zero()),
            capsules: Vec::new(),
            notes: Vec::new(),
        });
        self.links.len() - 1
    }

    fn link(&mut self, inside: &[Held<'a>], name: String, line: usize) -> Result<usize, ModelError> {
        let mut notes = Vec::new();
        let of = |tag: &str| inside.iter().find(|h| h.node.has_tag_name(tag));
        let inertia = match of("inertial") {
            Some(inertial) => Some(self.inertial(inertial, &name, &mut notes)?),
            None => {
                if of("geom").is_some() {
                    notes.push(format!(
                        "body `{name}` (line {line}) has no <inertial>, and that of its geoms is not computed: let MuJoCo write it \
                         (`mj_saveLastXML`) where it matters"
                    ));
                }
                None
            }
        };
        let capsules = self.shape(inside, &name);
        self.links.push(TreeLink {
            capsules,
            name,
            line,
            inertia,
            notes,
        });
        Ok(self.links.len() - 1)
    }

    fn inertial(&self, held: &Held<'a>, body: &str, notes: &mut Vec<String>) -> Result<LinkInertia, ModelError> {
        let (node, owner) = (held.node, format!("body `{body}`"));
        let one = |name: &str| self.numbers(node.attribute(name), name, 1, node, &owner);
        let mass = one("mass")?.map_or(0.0, |v| v[0]);
        let diagonal = self.numbers(node.attribute("diaginertia"), "diaginertia", 3, node, &owner)?;
        let full = self.numbers(node.attribute("fullinertia"), "fullinertia", 6, node, &owner)?;
        let inertia = match (full, diagonal) {
            (Some(f), _) => Matrix3::new(f[0], f[3], f[4], f[3], f[1], f[5], f[4], f[5], f[2]),
            (None, Some(d)) => Matrix3::from_diagonal(&Vector3::from_column_slice(&d)),
            (None, None) => Matrix3::zeros(),
        };
        if mass < 0.0 {
            let detail = format!("{owner}, line {}: its mass is {mass} kg", self.text.line(node));
            return Err(single(self.text.field, detail, "a mass is not negative"));
        }
        if let Some(complaint) = body_complaint(mass, &inertia) {
            notes.push(format!("{owner} (line {}) {complaint}", self.text.line(node)));
        }
        let own = PhysicalInertia {
            mass,
            center_of_mass: Vector3::zeros(),
            inertia,
        };
        Ok(own.about_origin().transformed(&(held.pose * self.pose(node)?)))
    }
}
