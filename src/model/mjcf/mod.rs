//! A serial arm from an MJCF file (MuJoCo).
//!
//! Bodies are nested: each hangs on the one around it by its joints, one after the other, or is welded to it. Angles are in
//! degrees unless `<compiler angle="radian">` says otherwise; attributes of joints may stand in default classes. What a compiled
//! model has beside its bodies (tendons, sites, contacts, sensors) says nothing of the chain.

mod assets;
mod bodies;
mod defaults;
mod geoms;
mod joints;
mod orientation;
mod values;

use self::assets::MeshFolder;
use self::bodies::read_bodies;
use super::link_tree::{ChainEnds, LinkTree, arm};
use super::notes::Notes;
use super::urdf::{Element, UrdfRobot};
use super::xml::{XmlText, single};
use super::{Capsule, Friction, LinkMesh, ModelError, Rounding};
use nalgebra::Vector3;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// How the numbers of a file are meant.
struct Compiler {
    /// Factor from an angle of the file to radians.
    pub angle: f64,
    /// Three letters: axes of Euler angles, small where they turn with the body.
    pub euler: [char; 3],
    pub meshes: MeshFolder,
    pub rounding: Rounding,
}

/// Reads an MJCF document; `gravity` [m/s²] is that of the file where `None`.
///
/// # Errors
/// Not XML or not MJCF, files that are to be included, and what [`from_urdf`](super::from_urdf) refuses.
pub fn from_mjcf(
    xml: &str,
    gravity: Option<Vector3<f64>>,
    friction: Friction,
    ends: ChainEnds,
    rounding: Rounding,
) -> Result<UrdfRobot, ModelError> {
    from_mjcf_shaped(xml, gravity, friction, ends, rounding, &BTreeMap::new())
}

/// [`from_mjcf`] with shapes of bodies, in the frames of the file: they take the place of those in it.
///
/// # Errors
/// As [`from_mjcf`]; shapes of bodies that the file does not have.
pub fn from_mjcf_shaped(
    xml: &str,
    gravity: Option<Vector3<f64>>,
    friction: Friction,
    ends: ChainEnds,
    rounding: Rounding,
    shapes: &BTreeMap<String, Vec<Capsule>>,
) -> Result<UrdfRobot, ModelError> {
    let mut notes = Notes::default();
    let text = XmlText::new(xml, "/mjcf", &mut notes)?;
    let document = text.parse()?;
    let (mut tree, _) = tree(&text, &document, rounding)?;
    tree.shape(shapes)?;
    let of_file = stated_gravity(&text, &document)?;
    let robot = arm(&tree, gravity.unwrap_or(of_file), friction, ends, &mut notes)?;
    Ok(UrdfRobot {
        robot,
        notes: notes.into_list(),
    })
}

/// Meshes of the bodies that are described by them alone: those of geoms that collide or, where a body has none, of geoms that
/// are only seen.
///
/// # Errors
/// As [`from_mjcf`], of what is not the chain.
pub fn mjcf_meshes(xml: &str) -> Result<Vec<LinkMesh>, ModelError> {
    let text = XmlText::new(xml, "/mjcf", &mut Notes::default())?;
    let document = text.parse()?;
    Ok(tree(&text, &document, Rounding::Meant)?.1)
}

fn tree(text: &XmlText, document: &Document, rounding: Rounding) -> Result<(LinkTree, Vec<LinkMesh>), ModelError> {
    whole(text, document)?;
    let compiler = compiler(text, document, rounding)?;
    read_bodies(text, document, &compiler)
}

/// MuJoCo's parts that stand for others are written out by MuJoCo itself.
fn whole(text: &XmlText, document: &Document) -> Result<(), ModelError> {
    let root = document.root_element();
    if !root.has_tag_name("mujoco") {
        let detail = format!(
            "has <{}> at its top, not <mujoco>",
            root.tag_name().name().chars().take(80).collect::<String>()
        );
        return Err(single(text.field, detail, "give an MJCF file, or a URDF file in `urdf`"));
    }
    let unfinished = ["include", "replicate", "attach", "composite", "flexcomp"];
    match root.descendants().find(|n| unfinished.contains(&n.tag_name().name())) {
        Some(node) => Err(single(
            text.field,
            format!(
                "has <{}> in line {}, which only MuJoCo can carry out",
                node.tag_name().name(),
                text.line(node)
            ),
            "let MuJoCo write the whole model: `mujoco.mj_saveLastXML(\"robot.xml\", model)` after loading it, and give that file",
        )),
        None => Ok(()),
    }
}

fn compiler(text: &XmlText, document: &Document, rounding: Rounding) -> Result<Compiler, ModelError> {
    let mut compiler = Compiler {
        angle: std::f64::consts::PI / 180.0,
        euler: ['x', 'y', 'z'],
        meshes: MeshFolder::default(),
        rounding,
    };
    for node in document.root_element().children().filter(|c| c.has_tag_name("compiler")) {
        compiler.meshes.read(node);
        match node.attribute("angle") {
            Some("radian") => compiler.angle = 1.0,
            Some("degree") => compiler.angle = std::f64::consts::PI / 180.0,
            _ => {}
        }
        if let Some(sequence) = node.attribute("eulerseq") {
            let letters: Vec<char> = sequence.chars().collect();
            let known = |c: &char| "xyzXYZ".contains(*c);
            let Some(three) = letters.try_into().ok().filter(|l: &[char; 3]| l.iter().all(known)) else {
                let detail = format!(
                    "<compiler> in line {} has an eulerseq that is not three axes",
                    text.line(node)
                );
                return Err(single(
                    text.field,
                    detail,
                    "three of x, y, z (turning with the body) or X, Y, Z (fixed)",
                ));
            };
            compiler.euler = three;
        }
    }
    Ok(compiler)
}

fn stated_gravity(text: &XmlText, document: &Document) -> Result<Vector3<f64>, ModelError> {
    let options = document.root_element().children().filter(|c| c.has_tag_name("option"));
    let mut gravity = Vector3::new(0.0, 0.0, -9.81);
    for node in options {
        let element = Element {
            text,
            node,
            owner: "the file",
        };
        gravity = element.vector("gravity")?.unwrap_or(gravity);
    }
    Ok(gravity)
}

/// The name of a body or joint.
fn named(node: Node) -> Option<String> {
    node.attribute("name").filter(|n| !n.trim().is_empty()).map(str::to_string)
}
