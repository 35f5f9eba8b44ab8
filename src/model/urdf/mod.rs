//! A serial arm from a URDF file.
//!
//! The XML is read as it is in the wild: what a file states twice, in another place or not quite, is read with a note; what
//! would change the mechanics is refused with link or joint, line and remedy.

mod collision;
mod elements;
mod inertial;
mod numbers;
mod patch;

use self::elements::read_tree;
use super::link_tree::{ChainEnds, arm};
use super::notes::Notes;
use super::xml::{XmlText, single};
use super::{Capsule, Friction, ModelError, Robot, Rounding};
use nalgebra::Vector3;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

pub use self::collision::urdf_meshes;
pub use self::inertial::INERTIA_ENTRIES;
pub use self::inertial::body_complaint;
pub(super) use self::numbers::Element;
pub use self::patch::{NewBody, urdf_carried, urdf_with_bodies};

/// A robot read from a file, and what a user should know about how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct UrdfRobot {
    /// The arm as a robot.
    pub robot: Robot,
    /// What the file does not say, what was locked or left out, and what was read otherwise than written, in words.
    pub notes: Vec<String>,
}

/// Reads a URDF document.
///
/// `gravity` is given in the frame of the base link. `ends` names the base and the last link of the chain where the file has more
/// than one arm; joints off the chain are locked at zero and their links lumped into those that carry them.
///
/// # Errors
/// Not XML or not URDF, no movable joint, several chains and no `tip`, closed loops, joint types a serial arm cannot have, and
/// everything that [`Robot::new`] refuses.
pub fn from_urdf(xml: &str, gravity: Vector3<f64>, friction: Friction, ends: ChainEnds) -> Result<UrdfRobot, ModelError> {
    from_urdf_rounded(xml, gravity, friction, ends, Rounding::Meant)
}

/// [`from_urdf`] with numbers as they are written, for files that this program has made.
///
/// # Errors
/// As [`from_urdf`].
pub fn from_urdf_rounded(
    xml: &str,
    gravity: Vector3<f64>,
    friction: Friction,
    ends: ChainEnds,
    rounding: Rounding,
) -> Result<UrdfRobot, ModelError> {
    from_urdf_shaped(xml, gravity, friction, ends, rounding, &BTreeMap::new())
}

/// [`from_urdf_rounded`] with shapes of links, in the frames of the file: they take the place of those in it.
///
/// # Errors
/// As [`from_urdf`]; shapes of links that the file does not have.
pub fn from_urdf_shaped(
    xml: &str,
    gravity: Vector3<f64>,
    friction: Friction,
    ends: ChainEnds,
    rounding: Rounding,
    shapes: &BTreeMap<String, Vec<Capsule>>,
) -> Result<UrdfRobot, ModelError> {
    let mut notes = Notes::default();
    let text = XmlText::new(xml, "/urdf", &mut notes)?;
    let document = text.parse()?;
    is_urdf(&text, &document)?;
    let mut tree = read_tree(&text, &document, rounding, &mut notes)?;
    tree.shape(shapes)?;
    let robot = arm(&tree, gravity, friction, ends, &mut notes)?;
    Ok(UrdfRobot {
        robot,
        notes: notes.into_list(),
    })
}

/// Files of other kinds, by their names.
fn is_urdf(text: &XmlText, document: &Document) -> Result<(), ModelError> {
    let root = document.root_element();
    let refuse = |what: &str, hint: &str| Err(single(text.field, what, hint));
    match root.tag_name().name() {
        "robot" => {}
        "mujoco" => {
            return refuse(
                "is MJCF (MuJoCo), not URDF",
                "give the file as it is, or its text in `mjcf` instead of `urdf`",
            );
        }
        "sdf" | "gazebo" => {
            let hint =
                "SDF is not read: give the URDF or MJCF that it was made from, or convert it (`sdf2urdf`, `sdformat_mjcf`)";
            return refuse("is SDF (Gazebo), not URDF", hint);
        }
        "COLLADA" => {
            return refuse(
                "is a COLLADA mesh, not URDF",
                "give the file that refers to it, with <robot> at its top",
            );
        }
        other => {
            let what = format!("is XML with <{}> at its top, not a robot", shortened(other));
            return refuse(&what, "a URDF file has <robot name=\"…\"> at its top");
        }
    }
    match document.descendants().find(|n| is_xacro(n)) {
        Some(node) => refuse(
            &format!(
                "is xacro, a URDF that is still to be expanded: <xacro:{}> in line {}",
                shortened(node.tag_name().name()),
                text.line(node)
            ),
            "expand it first, with ROS: `xacro robot.urdf.xacro > robot.urdf`, and give that file",
        ),
        None => Ok(()),
    }
}

fn is_xacro(node: &Node) -> bool {
    let namespace = node.tag_name().namespace().unwrap_or_default();
    let by_name = namespace.ends_with("xacro") || namespace.contains("/xacro");
    node.is_element() && (by_name || !namespace.is_empty() && node.lookup_prefix(namespace) == Some("xacro"))
}

/// Names of a file can be megabytes long.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
