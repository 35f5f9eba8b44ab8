//! The links and joints of a robot file as a tree, and the serial arm in it.
//!
//! A file has more than an arm: grippers, cameras, a second arm, a mobile base. The chain from `base` to `tip` is the robot;
//! everything else that hangs on a link of the chain is locked at zero and lumped into that link. All walks are loops over a tree
//! that has been checked to be one, so that they end, and their work is linear in the size of the file.

mod arm;
mod chain;

pub use arm::CarriedLinks;
pub(super) use arm::{arm, carried};

use super::notes::some_of;
use super::xml::single;
use super::{Capsule, Limits, ModelError, Rounding};
use crate::spatial::{LinkInertia, Transform};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};

/// Which part of a file's tree is the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChainEnds<'a> {
    /// The link that stands still; the root of the file if left out.
    pub base: Option<&'a str>,
    /// The last link; needed where the file has several chains.
    pub tip: Option<&'a str>,
}

/// What a joint of a file lets its link do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Freedom {
    Fixed,
    Revolute,
    Prismatic,
    /// More than one way: floating, planar, spherical; by its name in the file.
    Several(&'static str),
}

#[derive(Debug, Clone)]
pub(super) struct TreeLink {
    pub name: String,
    /// Line of the file.
    pub line: usize,
    /// About the link's frame; `None` where the file says nothing.
    pub inertia: Option<LinkInertia>,
    /// In the link's frame; empty where the file describes no shape, or by meshes alone.
    pub capsules: Vec<Capsule>,
    /// What to know about how it was read, where it is part of the arm.
    pub notes: Vec<String>,
}

#[derive(Debug, Clone)]
pub(super) struct TreeJoint {
    pub name: String,
    pub line: usize,
    pub freedom: Freedom,
    /// Places of the links in the tree.
    pub parent: usize,
    pub child: usize,
    /// Pose of the child's frame in the parent's at q = 0, with the joint's frame at the same place.
    pub origin: Transform,
    /// Unit vector in the child's frame.
    pub axis: Vector3<f64>,
    /// A point of the axis in the child's frame (m); zero in URDF.
    pub anchor: Vector3<f64>,
    /// Position (rad or m) at which the links stand as `origin` says; zero in URDF.
    pub reference: f64,
    pub limits: Limits,
    pub viscous: f64,
    pub coulomb: f64,
    /// The joint that this one follows.
    pub mimics: Option<String>,
    /// What to know about how it was read, where it is part of the arm.
    pub notes: Vec<String>,
}

impl TreeJoint {
    pub fn is_movable(&self) -> bool {
        matches!(self.freedom, Freedom::Revolute | Freedom::Prismatic)
    }

    /// Name and line.
    pub fn place(&self) -> String {
        format!("joint `{}` (line {})", self.name, self.line)
    }
}

/// A file as a forest: every link has one parent joint at most, and no joints form a loop.
#[derive(Debug)]
pub(super) struct LinkTree {
    pub name: String,
    /// Field of the document that holds the file, for errors.
    pub field: &'static str,
    pub rounding: Rounding,
    pub links: Vec<TreeLink>,
    pub joints: Vec<TreeJoint>,
    /// Per link, the joint that carries it.
    parent: Vec<Option<usize>>,
    /// Per link, the joints that it carries.
    children: Vec<Vec<usize>>,
}

impl LinkTree {
    /// Gives links other shapes.
    ///
    /// # Errors
    /// Links that are not in the file, all of them.
    pub fn shape(&mut self, shapes: &BTreeMap<String, Vec<Capsule>>) -> Result<(), ModelError> {
        let unknown: Vec<&str> = shapes.keys().map(String::as_str).filter(|l| self.link(l).is_none()).collect();
        if !unknown.is_empty() {
            let names: Vec<&str> = self.links.iter().map(|l| l.name.as_str()).collect();
            let hint = format!("use the name of a link in the file: {}", some_of(&names));
            return Err(single(
                "/geometry",
                format!("the file has no link {}", some_of(&unknown)),
                hint,
            ));
        }
        for (name, capsules) in shapes {
            if let Some(at) = self.link(name) {
                self.links[at].capsules.clone_from(capsules);
            }
        }
        Ok(())
    }

    /// # Errors
    /// Names used twice, links with two parents, closed loops, no joint at all.
    pub fn new(
        name: String,
        field: &'static str,
        rounding: Rounding,
        links: Vec<TreeLink>,
        joints: Vec<TreeJoint>,
    ) -> Result<Self, ModelError> {
        let mut tree = Self {
            parent: vec![None; links.len()],
            children: vec![Vec::new(); links.len()],
            name,
            field,
            rounding,
            links,
            joints,
        };
        tree.unique_names()?;
        for (at, joint) in tree.joints.iter().enumerate() {
            if let Some(other) = tree.parent[joint.child].replace(at) {
                return Err(single(
                    field,
                    format!(
                        "link `{}` has two parent joints: {} and {}",
                        tree.links[joint.child].name,
                        tree.joints[other].place(),
                        joint.place()
                    ),
                    "a serial arm has no closed loop: cut it at one of these joints",
                ));
            }
            tree.children[joint.parent].push(at);
        }
        tree.no_loop()?;
        Ok(tree)
    }

    fn unique_names(&self) -> Result<(), ModelError> {
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for link in &self.links {
            if let Some(first) = seen.insert(&link.name, link.line) {
                let detail = format!("has two links named `{}`, in lines {first} and {}", link.name, link.line);
                return Err(single(self.field, detail, "rename or remove one of them"));
            }
        }
        Ok(())
    }

    /// Every link has one parent at most: what no root reaches is a loop, or hangs on one.
    fn no_loop(&self) -> Result<(), ModelError> {
        let mut reached = vec![false; self.links.len()];
        let mut stack: Vec<usize> = (0..self.links.len()).filter(|&l| self.parent[l].is_none()).collect();
        while let Some(link) = stack.pop() {
            reached[link] = true;
            stack.extend(self.children[link].iter().map(|&j| self.joints[j].child));
        }
        let Some(start) = reached.iter().position(|r| !r) else {
            return Ok(());
        };
        // Upwards from there the walk comes to the loop, and once around it back to a link that it has seen.
        let (mut seen, mut link) = (vec![false; self.links.len()], start);
        let up = |link: usize| self.parent[link].map(|j| (j, self.joints[j].parent));
        while !std::mem::replace(&mut seen[link], true) {
            let Some((_, above)) = up(link) else { return Ok(()) };
            link = above;
        }
        let (mut links, mut joints, first) = (vec![self.links[link].name.as_str()], Vec::new(), link);
        while let Some((joint, above)) = up(link) {
            joints.push(self.joints[joint].name.as_str());
            link = above;
            if link == first {
                break;
            }
            links.push(self.links[link].name.as_str());
        }
        Err(single(
            self.field,
            format!(
                "has a closed loop: the links {} follow each other round by the joints {}",
                some_of(&links),
                some_of(&joints)
            ),
            "every link of an arm hangs on the base by one chain: remove one of these joints, or correct its parent",
        ))
    }

    /// The place of a link by its name.
    fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l.name == name)
    }
}
