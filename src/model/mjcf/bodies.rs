//! `<body>`, `<joint>` and `<inertial>` of an MJCF file as a tree of links.

use super::defaults::{Attributes, Defaults};
use super::orientation::{ORIENTATIONS, rotation};
use super::{Compiler, named};
use crate::model::capsule::few;
use crate::model::link_tree::{Freedom, LinkTree, TreeJoint, TreeLink};
use crate::model::urdf::body_complaint;
use crate::model::xml::{XmlText, single};
use crate::model::{Capsule, INPUT_LIMITS, Limits, ModelError};
use crate::spatial::{LinkInertia, PhysicalInertia, Transform};
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// A body that is still to be read: its element, the link that it hangs on, its pose in that link, and the class of its joints.
struct Open<'a> {
    node: Node<'a, 'a>,
    on: usize,
    pose: Transform,
    class: Option<&'a str>,
}

struct Reading<'a> {
    text: &'a XmlText,
    compiler: &'a Compiler,
    defaults: Defaults<'a>,
    /// Joints by the joint that they follow.
    follows: HashMap<&'a str, &'a str>,
    links: Vec<TreeLink>,
    joints: Vec<TreeJoint>,
}

/// # Errors
/// Bodies and joints that cannot be read, each with its line.
pub(super) fn read_bodies<'a>(
    text: &'a XmlText,
    document: &'a Document<'a>,
    compiler: &'a Compiler,
) -> Result<LinkTree, ModelError> {
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
        links: Vec::new(),
        joints: Vec::new(),
    };
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
        reading.children(world, 0, Transform::identity(), None, &mut open)?;
    }
    while let Some(body) = open.pop() {
        reading.body(&body, &mut open)?;
    }
    let name = root.attribute("model").unwrap_or("robot").to_string();
    LinkTree::new(name, text.field, compiler.rounding, reading.links, reading.joints)
}

impl<'a> Reading<'a> {
    /// Bodies within `node`; frames within it move what they hold.
    fn children(
        &self,
        node: Node<'a, 'a>,
        on: usize,
        pose: Transform,
        class: Option<&'a str>,
        open: &mut Vec<Open<'a>>,
    ) -> Result<(), ModelError> {
        let mut frames = vec![(node, pose, class)];
        while let Some((node, pose, class)) = frames.pop() {
            // Backwards, as the last of a stack is the first to come.
            for child in node.children().filter(Node::is_element).collect::<Vec<_>>().into_iter().rev() {
                let here = || child.attribute("childclass").or(class);
                match child.tag_name().name() {
                    "body" => open.push(Open {
                        node: child,
                        on,
                        pose: pose * self.pose(child)?,
                        class: here(),
                    }),
                    "frame" => frames.push((child, pose * self.pose(child)?, here())),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn body(&mut self, body: &Open<'a>, open: &mut Vec<Open<'a>>) -> Result<(), ModelError> {
        let (node, line) = (body.node, self.text.line(body.node));
        let name = named(node).unwrap_or_else(|| format!("body {}", self.links.len()));
        let joints: Vec<Node> = node
            .children()
            .filter(|c| c.has_tag_name("joint") || c.has_tag_name("freejoint"))
            .collect();
        let (mut on, mut pose) = (body.on, body.pose);
        for (k, joint) in joints.iter().enumerate() {
            // All joints of a body but the last carry nothing but the next.
            let link = match k + 1 == joints.len() {
                true => self.link(node, name.clone(), line)?,
                false => self.massless(format!("{name} {}", k + 1), line),
            };
            let joint = self.joint(*joint, body.class, on, link, pose, &name)?;
            self.joints.push(joint);
            (on, pose) = (link, Transform::identity());
        }
        if joints.is_empty() {
            let link = self.link(node, name.clone(), line)?;
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
        self.children(node, on, Transform::identity(), body.class, open)
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

    fn link(&mut self, node: Node<'a, 'a>, name: String, line: usize) -> Result<usize, ModelError> {
        let mut notes = Vec::new();
        let inertia = match node.children().find(|c| c.has_tag_name("inertial")) {
            Some(inertial) => Some(self.inertial(inertial, &name, &mut notes)?),
            None => {
                if node.children().any(|c| c.has_tag_name("geom")) {
                    notes.push(format!(
                        "body `{name}` (line {line}) has no <inertial>, and that of its geoms is not computed: let MuJoCo write it \
                         (`mj_saveLastXML`) where it matters"
                    ));
                }
                None
            }
        };
        self.links.push(TreeLink {
            capsules: self.capsules(node),
            name,
            line,
            inertia,
            notes,
        });
        Ok(self.links.len() - 1)
    }

    /// Geoms of a body that state their shape, as capsules that contain them; meshes, and what default classes state, are left out.
    fn capsules(&self, body: Node<'a, 'a>) -> Vec<Capsule> {
        let geoms = body.children().filter(|c| c.has_tag_name("geom"));
        few(geoms
            .take(INPUT_LIMITS.capsules_per_link)
            .filter_map(|g| self.capsule(g))
            .collect())
    }

    fn capsule(&self, geom: Node<'a, 'a>) -> Option<Capsule> {
        let numbers = |name: &str| -> Option<Vec<f64>> {
            let words = geom.attribute(name)?.split_whitespace().take(7);
            words.map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect()
        };
        let size = numbers("size").unwrap_or_default();
        let (first, second) = (*size.first()?, size.get(1).copied().unwrap_or(0.0));
        let up = |z: f64| Vector3::new(0.0, 0.0, z);
        let ends = match (numbers("fromto").as_deref(), geom.attribute("type")?) {
            (Some(&[a, b, c, d, e, f]), "capsule" | "cylinder") => {
                return Capsule::around(&[(Vector3::new(a, b, c), first), (Vector3::new(d, e, f), first)]);
            }
            (None, "capsule" | "cylinder") => vec![(up(-second), first), (up(second), first)],
            (None, "sphere") => vec![(up(0.0), first)],
            (None, "box") => {
                let third = *size.get(2)?;
                let half = [first, second, third];
                let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] });
                (0..8).map(|k| (corner(k), 0.0)).collect()
            }
            _ => return None,
        };
        let pose = self.pose(geom).ok()?;
        Capsule::around(&ends)
            .map(|c| c.moved(&pose))
            .filter(|c| Capsule::around(&c.balls()).is_some())
    }

    fn inertial(&self, node: Node<'a, 'a>, body: &str, notes: &mut Vec<String>) -> Result<LinkInertia, ModelError> {
        let owner = format!("body `{body}`");
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
        Ok(own.about_origin().transformed(&self.pose(node)?))
    }

    fn joint(
        &self,
        node: Node<'a, 'a>,
        class: Option<&str>,
        parent: usize,
        child: usize,
        origin: Transform,
        body: &str,
    ) -> Result<TreeJoint, ModelError> {
        let attributes = self.defaults.attributes(node, class);
        let name = named(node).unwrap_or_else(|| format!("{body} joint {}", self.joints.len() + 1));
        let owner = format!("joint `{name}`");
        let freedom = match (node.tag_name().name(), attributes.get("type")) {
            ("freejoint", _) | (_, Some("free")) => Freedom::Several("free"),
            (_, Some("ball")) => Freedom::Several("a ball joint"),
            (_, Some("slide")) => Freedom::Prismatic,
            _ => Freedom::Revolute,
        };
        let vector = |name: &str| -> Result<Option<Vector3<f64>>, ModelError> {
            let read = self.numbers(attributes.get(name), name, 3, node, &owner)?;
            Ok(read.map(|v| Vector3::from_column_slice(&v)))
        };
        let number = |name: &str| -> Result<f64, ModelError> {
            // Some attributes have further numbers for what a rigid model does not have.
            let first = attributes.get(name).map(|t| t.split_whitespace().next().unwrap_or_default());
            Ok(self.numbers(first, name, 1, node, &owner)?.map_or(0.0, |v| v[0]))
        };
        let axis = vector("axis")?.unwrap_or(Vector3::z());
        if axis.norm() < 1e-6 {
            let detail = format!("{owner}, line {}: its axis has no direction", self.text.line(node));
            return Err(single(self.text.field, detail, "give a unit vector"));
        }
        let unit = if freedom == Freedom::Revolute {
            self.compiler.angle
        } else {
            1.0
        };
        let mut notes = Vec::new();
        let armature = number("armature")?;
        if armature != 0.0 {
            notes.push(format!(
                "{owner} has an armature (rotor inertia) of {armature} kg m² or kg, which is not part of the declared model: expected torques lack it"
            ));
        }
        Ok(TreeJoint {
            line: self.text.line(node),
            freedom,
            parent,
            child,
            origin,
            axis: self.compiler.rounding.axis(axis.normalize()),
            anchor: vector("pos")?.unwrap_or_default(),
            reference: number("ref")? * unit,
            limits: self.limits(&attributes, node, &owner, unit, freedom == Freedom::Revolute, &mut notes)?,
            viscous: number("damping")?,
            coulomb: number("frictionloss")?,
            mimics: self.follows.get(name.as_str()).map(|f| f.to_string()),
            name,
            notes,
        })
    }

    fn limits(
        &self,
        attributes: &Attributes<'a>,
        node: Node<'a, 'a>,
        owner: &str,
        unit: f64,
        is_revolute: bool,
        notes: &mut Vec<String>,
    ) -> Result<Limits, ModelError> {
        let pair = |name: &str| -> Result<Option<[f64; 2]>, ModelError> {
            let read = self.numbers(attributes.get(name), name, 2, node, owner)?;
            Ok(read.map(|v| [v[0], v[1]]))
        };
        let is_limited = attributes.get("limited") != Some("false");
        let written = Limits {
            position: pair("range")?.filter(|_| is_limited).map(|ends| ends.map(|v| v * unit)),
            effort: pair("actuatorfrcrange")?.map(|[low, high]| low.abs().max(high.abs())),
            ..Limits::unlimited()
        };
        let (read, dropped) = written.without_placeholders(is_revolute, true);
        notes.extend(dropped.iter().map(|d| format!("{owner}: {d}")));
        if read.effort.is_none() {
            notes.push(format!("{owner} has no velocity, effort limit in the file"));
        } else {
            notes.push(format!("{owner} has no velocity limit in the file"));
        }
        Ok(read)
    }

    fn pose(&self, node: Node<'a, 'a>) -> Result<Transform, ModelError> {
        let owner = format!("<{}>", node.tag_name().name());
        let position = self.numbers(node.attribute("pos"), "pos", 3, node, &owner)?;
        let translation = position.map_or(Vector3::zeros(), |v| Vector3::from_column_slice(&v));
        let mut turn = Matrix3::identity();
        for (name, count) in ORIENTATIONS {
            if let Some(v) = self.numbers(node.attribute(name), name, count, node, &owner)? {
                turn = rotation(name, &v, self.compiler).ok_or_else(|| {
                    let detail = format!("{owner}, line {}: its {name} has no direction", self.text.line(node));
                    single(self.text.field, detail, "correct it in the file")
                })?;
            }
        }
        Ok(Transform {
            rotation: turn,
            translation: self.compiler.rounding.lengths("pos", translation).0,
        })
    }

    /// So many finite numbers; `None` where the attribute is missing.
    fn numbers(
        &self,
        written: Option<&str>,
        name: &str,
        count: usize,
        node: Node,
        owner: &str,
    ) -> Result<Option<Vec<f64>>, ModelError> {
        let Some(written) = written else { return Ok(None) };
        let words = written.split_whitespace().take(count + 1);
        let read: Option<Vec<f64>> = words.map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect();
        match read.filter(|v| v.len() == count) {
            Some(v) => Ok(Some(v)),
            None => {
                let shown: String = written.chars().take(80).collect();
                let detail = format!(
                    "{owner}, line {}: {name} is `{shown}`, expected {count} finite numbers",
                    self.text.line(node)
                );
                Err(single(self.text.field, detail, "correct it in the file"))
            }
        }
    }
}
