//! Robot documents: JSON with modified DH or general placements, or a URDF file.
//!
//! Every object of a robot document may carry a `source`: one string that says where its numbers come from.

mod file;
mod joint;

pub use file::robot_file;
pub use joint::{INERTIA_FIELDS, JOINT_FIELDS, LIMIT_FIELDS, MDH_FIELDS, PLACEMENT_FIELDS, PRIOR_FIELDS};

use self::joint::{Reading, read_joint};
use super::cursor::{Cursor, Fields, Findings};
use super::json::Parsed;
use crate::model::{ChainEnds, FieldProblem, Friction, INPUT_LIMITS, Notes, Robot, Rounding, from_urdf_rounded};
use crate::spatial::Transform;
use nalgebra::Vector3;
use serde_json::Value;

/// A robot as read, and what a user should know about how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDocument {
    pub robot: Robot,
    /// Missing limits or inertials of a URDF file, in words.
    pub notes: Vec<String>,
}

/// Robots, and results of a server, that documents may call by name.
pub trait NamedRobots {
    fn named(&self, name: &str) -> Option<RobotDocument>;
    fn names(&self) -> Vec<String>;

    /// The JSON model of an identification, by its id.
    fn model(&self, _identification: &str) -> Option<serde_json::Value> {
        None
    }

    /// The result of a design, by its id.
    fn design(&self, _excitation: &str) -> Option<serde_json::Value> {
        None
    }
}

/// Fields of a robot with joints.
pub const ROBOT_FIELDS: &[&str] = &["name", "gravity", "joints", "friction", "source"];
/// Fields of a robot given as a URDF file.
pub const URDF_FIELDS: &[&str] = &["urdf", "gravity", "friction", "base", "tip", "source"];

/// Reads the robot that stands at `cursor`; what is wrong goes to the cursor's findings, and `None` comes back if anything is.
pub fn read_robot(cursor: &Cursor) -> Option<RobotDocument> {
    read_robot_rounded(cursor, Rounding::Meant)
}

fn read_robot_rounded(cursor: &Cursor, rounding: Rounding) -> Option<RobotDocument> {
    let urdf = cursor.value().get("urdf").is_some();
    let read = match urdf {
        true => read_urdf(cursor, rounding),
        false => read_joints(cursor, rounding),
    };
    read.filter(|_| !cursor.findings().within(cursor.pointer()))
}

fn read_urdf(cursor: &Cursor, rounding: Rounding) -> Option<RobotDocument> {
    let fields = cursor.fields(URDF_FIELDS)?;
    read_source(&fields);
    let (gravity, friction) = (read_gravity(&fields), read_friction(&fields));
    let end = |name: &str| fields.nullable(name).and_then(|c| c.string());
    let ends = ChainEnds {
        base: end("base"),
        tip: end("tip"),
    };
    let xml = fields.required("urdf")?.string()?;
    match from_urdf_rounded(xml, gravity, friction, ends, rounding) {
        Ok(read) => Some(RobotDocument {
            robot: read.robot,
            notes: read.notes,
        }),
        Err(e) => {
            cursor.findings().merge(e.0.into_iter().map(|p| in_urdf(cursor.pointer(), p)));
            None
        }
    }
}

/// Problems of what XML states are problems of the field that holds it.
fn in_urdf(at: &str, problem: FieldProblem) -> FieldProblem {
    if ["/urdf", "/base", "/tip", "/gravity"].contains(&problem.pointer.as_str()) {
        return FieldProblem {
            pointer: format!("{at}{}", problem.pointer),
            ..problem
        };
    }
    FieldProblem {
        pointer: format!("{at}/urdf"),
        detail: format!("its {} {}", problem.pointer.trim_start_matches('/'), problem.detail),
        ..problem
    }
}

fn read_joints(cursor: &Cursor, rounding: Rounding) -> Option<RobotDocument> {
    let fields = cursor.fields(ROBOT_FIELDS)?;
    read_source(&fields);
    let name = fields.required("name").and_then(|c| c.string()).unwrap_or("robot");
    let (gravity, friction) = (read_gravity(&fields), read_friction(&fields));
    let mut joints = Vec::new();
    let mut reading = Reading {
        rounding,
        notes: Notes::default(),
    };
    let mut to_here = Transform::identity();
    let items = fields
        .required("joints")
        .and_then(|c| c.items_up_to(INPUT_LIMITS.joints, "joints"));
    for (i, item) in items.unwrap_or_default().iter().enumerate() {
        let (joint, turn) = read_joint(item, i, &to_here, &mut reading);
        // As in a URDF: where the axis is not z, the frame of the dynamics is the document's frame turned.
        to_here = Transform::from_rotation(turn.transpose());
        joints.push(joint);
    }
    match Robot::new(name, gravity, joints, friction) {
        Ok(robot) => Some(RobotDocument {
            robot,
            notes: reading.notes.into_list(),
        }),
        Err(e) => {
            let placed = |p: FieldProblem| FieldProblem {
                pointer: format!("{}{}", cursor.pointer(), p.pointer),
                ..p
            };
            cursor.findings().merge(e.0.into_iter().map(placed));
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
    let words = [("viscous", true), ("coulomb", false)];
    let read: Vec<Option<bool>> = items.iter().map(|c| c.choice(&words)).collect();
    Friction {
        viscous: read.contains(&Some(true)),
        coulomb: read.contains(&Some(false)),
    }
}

/// Reads a whole robot document.
///
/// # Errors
/// Everything that is wrong with it.
pub fn robot_document(parsed: &Parsed) -> Result<RobotDocument, Vec<FieldProblem>> {
    robot_document_rounded(parsed, Rounding::Meant)
}

/// [`robot_document`] with numbers as they are written, for documents that this program has made.
///
/// # Errors
/// As [`robot_document`].
pub fn robot_document_rounded(parsed: &Parsed, rounding: Rounding) -> Result<RobotDocument, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read_robot_rounded(&Cursor::root(&parsed.value, &findings), rounding);
    match read {
        Some(document) if findings.is_empty() => Ok(document),
        _ => Err(findings.into_list()),
    }
}

/// A robot that stands in the document, or the name of a known one.
pub(super) fn read_robot_or_name(cursor: &Cursor, known: &dyn NamedRobots) -> Option<RobotDocument> {
    let Value::String(name) = cursor.value() else {
        return read_robot(cursor);
    };
    let found = known.named(name);
    let names = known.names();
    if found.is_none() && names.contains(name) {
        cursor.complain_with(
            format!("is `{name}`, a robot whose stored document cannot be read"),
            "keep it anew under its name, or give another robot",
        );
    } else if found.is_none() {
        let names: Vec<(&str, ())> = names.iter().map(|n| (n.as_str(), ())).collect();
        cursor.choice(&names);
    }
    found
}
