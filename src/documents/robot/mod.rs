//! Robot documents: JSON with modified DH or general placements, a URDF or an MJCF file.
//!
//! Every object of a robot document may carry a `source`: one string that says where its numbers come from.

mod joint;
mod written;

pub use written::{robot_value, written_robot};

use self::joint::{Reading, read_capsule, read_joint};
use crate::documents::cursor::{Cursor, Fields, Findings};
use crate::documents::effect_list::read_effects;
use crate::documents::requests;
use crate::effects::OwnEffect;
use crate::formats::json::Parsed;
use crate::model::{
    Capsule, ChainEnds, FieldProblem, Friction, INPUT_LIMITS, Robot, Rounding, from_mjcf_shaped, from_urdf_shaped,
};
use crate::spatial::Transform;
use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A robot as read, and what a user should know about how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDocument {
    /// The robot of the core, valid by construction.
    pub robot: Robot,
    /// Missing limits or inertials of a URDF file, in words.
    pub notes: Vec<String>,
    /// Effects with formulas of their own.
    pub effects: Vec<Arc<OwnEffect>>,
}

/// Robots, and results of a server, that documents may call by name.
pub trait NamedRobots {
    /// The robot called `name`; nothing if there is none.
    fn named(&self, name: &str) -> Option<RobotDocument>;
    /// All names, for the message about an unknown one.
    fn names(&self) -> Vec<String>;

    /// The JSON model of an identification, by its id.
    fn model(&self, _identification: &str) -> Option<serde_json::Value> {
        None
    }

    /// The result of a design, by its id.
    fn design(&self, _excitation: &str) -> Option<serde_json::Value> {
        None
    }

    /// The definition of an effect of the catalogue, by its name.
    fn effect(&self, _name: &str) -> Option<serde_json::Value> {
        None
    }

    /// Names of all effects of the catalogue, for the message about an unknown one.
    fn effect_names(&self) -> Vec<String> {
        Vec::new()
    }

    /// Why the robot called `name` cannot be read, where it is kept and cannot.
    fn fault(&self, _name: &str) -> Option<FieldProblem> {
        None
    }
}

/// Nothing is known by name.
struct NoNames;

impl NamedRobots for NoNames {
    fn named(&self, _name: &str) -> Option<RobotDocument> {
        None
    }

    fn names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Reads the robot that stands at `cursor`; what is wrong goes to the cursor's findings, and `None` comes back if anything is.
/// Effects that it names are those that `known` has.
pub fn read_robot(cursor: &Cursor, known: &dyn NamedRobots) -> Option<RobotDocument> {
    read_robot_of(cursor, Rounding::Meant, known)
}

/// [`read_robot`] with numbers as they are written, where the document names nothing.
pub(super) fn read_robot_rounded(cursor: &Cursor, rounding: Rounding) -> Option<RobotDocument> {
    read_robot_of(cursor, rounding, &NoNames)
}

fn read_robot_of(cursor: &Cursor, rounding: Rounding, known: &dyn NamedRobots) -> Option<RobotDocument> {
    let read = match ["urdf", "mjcf"].map(|kind| cursor.value().get(kind).is_some()) {
        [true, _] => read_xml::<requests::UrdfRobot>(cursor, "urdf", rounding, known),
        [_, true] => read_xml::<requests::MjcfRobot>(cursor, "mjcf", rounding, known),
        _ => read_joints(cursor, rounding, known),
    };
    read.filter(|_| !cursor.findings().within(cursor.pointer()))
}

/// A robot from the text of a file of one of two kinds.
fn read_xml<T: for<'de> Deserialize<'de>>(
    cursor: &Cursor,
    kind: &str,
    rounding: Rounding,
    known: &dyn NamedRobots,
) -> Option<RobotDocument> {
    let fields = cursor.fields_of::<T>()?;
    read_source(&fields);
    let friction = read_friction(&fields);
    let end = |name: &str| fields.nullable(name).and_then(|c| c.string());
    let ends = ChainEnds {
        base: end("base"),
        tip: end("tip"),
    };
    let xml = fields.required(kind)?.string()?;
    let shapes = fields.nullable("geometry").map(|c| read_shapes(&c)).unwrap_or_default();
    let read = match kind {
        "urdf" => from_urdf_shaped(xml, read_gravity(&fields), friction, ends, rounding, &shapes),
        _ => {
            let gravity = fields.has("gravity").then(|| read_gravity(&fields));
            from_mjcf_shaped(xml, gravity, friction, ends, rounding, &shapes)
        }
    };
    match read {
        Ok(read) => Some(RobotDocument {
            effects: read_effects(&fields, Some(&read.robot), &[], known),
            robot: read.robot,
            notes: read.notes,
        }),
        Err(e) => {
            let at = cursor.pointer();
            cursor.findings().merge(e.0.into_iter().map(|p| in_file(at, kind, p)));
            read_effects(&fields, None, &[], known);
            None
        }
    }
}

/// Capsules by the names of links, in the frames of the file.
fn read_shapes(cursor: &Cursor) -> BTreeMap<String, Vec<Capsule>> {
    let names: Vec<&str> = cursor
        .value()
        .as_object()
        .into_iter()
        .flatten()
        .map(|(k, _)| k.as_str())
        .collect();
    let Some(fields) = cursor.fields(&names) else {
        return BTreeMap::new();
    };
    let capsules = |name: &&str| {
        let items = fields
            .optional(name)?
            .items_up_to(INPUT_LIMITS.capsules_per_link, "capsules")?;
        let read = items.iter().filter_map(|c| read_capsule(c, &Transform::identity())).collect();
        Some((name.to_string(), read))
    };
    names.iter().filter_map(capsules).collect()
}

/// Problems of what XML states are problems of the field that holds it.
fn in_file(at: &str, kind: &str, problem: FieldProblem) -> FieldProblem {
    if ["/urdf", "/mjcf", "/base", "/tip", "/gravity", "/geometry"].contains(&problem.pointer.as_str()) {
        return FieldProblem {
            pointer: format!("{at}{}", problem.pointer),
            ..problem
        };
    }
    FieldProblem {
        pointer: format!("{at}/{kind}"),
        detail: format!("its {} {}", problem.pointer.trim_start_matches('/'), problem.detail),
        ..problem
    }
}

fn read_joints(cursor: &Cursor, rounding: Rounding, known: &dyn NamedRobots) -> Option<RobotDocument> {
    let fields = cursor.fields_of::<requests::JointRobot>()?;
    read_source(&fields);
    let name = fields.required("name").and_then(|c| c.string()).unwrap_or("robot");
    let (gravity, friction) = (read_gravity(&fields), read_friction(&fields));
    let mut joints = Vec::new();
    let mut reading = Reading::new(rounding);
    let mut to_here = Transform::identity();
    let items = fields
        .required("joints")
        .and_then(|c| c.items_up_to(INPUT_LIMITS.joints, "joints"));
    for (i, item) in items.unwrap_or_default().iter().enumerate() {
        // As in a URDF: where the axis is not z, the frame of the dynamics is the document's frame turned.
        let (joint, link) = read_joint(item, i, &to_here, &mut reading);
        to_here = link;
        joints.push(joint);
    }
    reading.look_at_table(joints.len());
    match Robot::new(name, gravity, joints, friction) {
        Ok(robot) => Some(RobotDocument {
            effects: read_effects(&fields, Some(&robot), &[], known),
            robot,
            notes: reading.notes.into_list(),
        }),
        Err(e) => {
            let of_table = |pointer: &str| {
                let index = pointer.strip_prefix("/joints/")?.split_once("/mdh/")?.0;
                let joint = cursor.value()["joints"].get(index.parse::<usize>().ok()?)?;
                joint.get("dh").map(|_| format!("/joints/{index}/dh"))
            };
            let placed = |p: FieldProblem| FieldProblem {
                pointer: format!("{}{}", cursor.pointer(), of_table(&p.pointer).unwrap_or(p.pointer)),
                ..p
            };
            cursor.findings().merge(e.0.into_iter().map(placed));
            read_effects(&fields, None, &[], known);
            None
        }
    }
}

fn read_source(fields: &Fields) {
    if let Some(source) = fields.optional("source") {
        source.string();
    }
}

fn read_gravity(fields: &Fields) -> Vector3<f64> {
    fields
        .optional("gravity")
        .and_then(|c| c.vector())
        .unwrap_or(Vector3::new(0.0, 0.0, -9.81))
}

fn read_friction(fields: &Fields) -> Friction {
    let Some(items) = fields.optional("friction").map(|c| c.items().unwrap_or_default()) else {
        return Friction {
            viscous: true,
            coulomb: true,
        };
    };
    let read: Vec<Option<requests::Friction>> = items.iter().map(Cursor::word).collect();
    Friction {
        viscous: read.contains(&Some(requests::Friction::Viscous)),
        coulomb: read.contains(&Some(requests::Friction::Coulomb)),
    }
}

/// Reads a whole robot document.
///
/// # Errors
/// Everything that is wrong with it.
pub fn robot_document(parsed: &Parsed) -> Result<RobotDocument, Vec<FieldProblem>> {
    robot_document_rounded(parsed, Rounding::Meant)
}

/// [`robot_document`] with effects that the document names, as `known` has them.
///
/// # Errors
/// As [`robot_document`], and names that are not known.
pub fn robot_document_of(parsed: &Parsed, known: &dyn NamedRobots) -> Result<RobotDocument, Vec<FieldProblem>> {
    whole(parsed, Rounding::Meant, known)
}

/// [`robot_document`] with numbers as they are written, for documents that this program has made.
///
/// # Errors
/// As [`robot_document`].
pub fn robot_document_rounded(parsed: &Parsed, rounding: Rounding) -> Result<RobotDocument, Vec<FieldProblem>> {
    whole(parsed, rounding, &NoNames)
}

fn whole(parsed: &Parsed, rounding: Rounding, known: &dyn NamedRobots) -> Result<RobotDocument, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read_robot_of(&Cursor::root(&parsed.value, &findings), rounding, known);
    match read {
        Some(document) if findings.is_empty() => Ok(document),
        _ => Err(findings.into_list()),
    }
}

/// A robot that stands in the document, or the name of a known one.
pub(super) fn read_robot_or_name(cursor: &Cursor, known: &dyn NamedRobots) -> Option<RobotDocument> {
    let Value::String(name) = cursor.value() else {
        return read_robot(cursor, known);
    };
    let found = known.named(name);
    let names = known.names();
    if found.is_none() && names.contains(name) {
        let why = known.fault(name).map(|p| format!(": {p}")).unwrap_or_default();
        cursor.complain_with(
            format!("is `{name}`, a robot whose stored document cannot be read{why}"),
            "keep it anew under its name, or give another robot",
        );
    } else if found.is_none() {
        let names: Vec<(&str, ())> = names.iter().map(|n| (n.as_str(), ())).collect();
        cursor.choice(&names);
    }
    found
}
