//! A serial arm from a URDF file.
//!
//! Fixed joints are merged into the link before them, with their inertia; the base's own fixed part only moves frames. The
//! dynamics want z along every joint, a URDF allows any axis: each link frame is turned so that its z axis is the joint's, and the
//! turn is kept ([`Joint::description_frame`]) so that results can be handed back in the file's own frames.

use super::urdf_elements::UrdfElements;
use super::{FieldProblem, Friction, Joint, JointKind, Limits, LinkPrior, ModelError, Robot};
use crate::spatial::{LinkInertia, PhysicalInertia, Transform};
use nalgebra::{Matrix3, Vector3};
use std::collections::{HashMap, HashSet};

/// A robot read from a URDF file, and what a user should know about how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct UrdfRobot {
    pub robot: Robot,
    /// Missing limits or inertials, frozen branches: what the file does not say or what was left out, in words.
    pub notes: Vec<String>,
}

/// Reads a URDF document.
///
/// `gravity` is given in the frame of the root link. `tip` names the last link of the chain where the file has several; joints off
/// the chain are then frozen at zero.
///
/// # Errors
/// Not XML or not URDF, no movable joint, several chains and no `tip`, joint types a serial arm cannot have, and everything
/// that [`Robot::new`] refuses.
pub fn from_urdf(xml: &str, gravity: Vector3<f64>, friction: Friction, tip: Option<&str>) -> Result<UrdfRobot, ModelError> {
    let stated = UrdfElements::read(xml)?;
    let file = urdf_rs::read_from_string(&stated.xml).map_err(|e| {
        single(
            "/urdf",
            format!("is not a readable URDF document: {e}"),
            "check that the file is complete",
        )
    })?;
    let tree = Tree::new(&file)?;
    let chain = tree.chain(tip)?;
    let mut notes = stated.notes.clone();
    notes.extend(tree.frozen_branches(&chain));
    let mut joints = Vec::new();
    // Pose of the present link frame (as the file has it) in the frame of the dynamics before it.
    let mut to_here = Transform::identity();
    for joint in &chain {
        let origin = pose(&joint.origin);
        if !is_movable(joint) {
            to_here = to_here * origin;
            continue;
        }
        let turn = Transform::z_onto(&axis(joint)?);
        let placement = to_here * origin * Transform::from_rotation(turn);
        // From here on the dynamics' frame is the file's link frame turned by `turn`.
        to_here = Transform::from_rotation(turn.transpose());
        let body = tree.merged_inertia(&joint.child.link, &chain, &stated, &mut notes);
        joints.push(described_joint(joint, placement, turn, body, &stated, &mut notes));
    }
    let robot = Robot::new(file.name.clone(), gravity, joints, friction)?;
    Ok(UrdfRobot { robot, notes })
}

fn single(pointer: &str, detail: impl Into<String>, hint: &str) -> ModelError {
    ModelError(vec![FieldProblem::new(pointer, detail).with_hint(hint)])
}

fn described_joint(
    joint: &urdf_rs::Joint,
    placement: Transform,
    turn: Matrix3<f64>,
    body: Option<LinkInertia>,
    stated: &UrdfElements,
    notes: &mut Vec<String>,
) -> Joint {
    let kind = match joint.joint_type {
        urdf_rs::JointType::Prismatic => JointKind::Prismatic,
        _ => JointKind::Revolute,
    };
    let (viscous, coulomb) = joint.dynamics.as_ref().map_or((0.0, 0.0), |d| (d.damping, d.friction));
    let prior = body.and_then(|b| b.transformed(&Transform::from_rotation(turn.transpose())).physical());
    Joint {
        limits: limits(joint, stated, notes),
        prior: prior.map(|inertia| LinkPrior {
            inertia,
            viscous,
            coulomb,
        }),
        description_frame: turn,
        link_name: joint.child.link.clone(),
        ..Joint::from_placement(joint.name.clone(), kind, placement)
    }
}

fn limits(joint: &urdf_rs::Joint, stated: &UrdfElements, notes: &mut Vec<String>) -> Limits {
    let attributes = stated.limits.get(joint.name.as_str());
    let has = |name: &str| attributes.is_some_and(|a| a.contains(name));
    let continuous = joint.joint_type == urdf_rs::JointType::Continuous;
    let position = (has("lower") || has("upper")) && !continuous;
    // The parser reads a missing attribute as 0, which as a limit would say that the joint cannot move.
    let magnitude = |name: &str, v: f64| (has(name) && v > 0.0).then_some(v);
    let found = Limits {
        position: position.then_some([joint.limit.lower, joint.limit.upper]),
        velocity: magnitude("velocity", joint.limit.velocity),
        effort: magnitude("effort", joint.limit.effort),
        acceleration: None,
        jerk: None,
    };
    let missing: Vec<_> = [
        ("position", found.position.is_none() && !continuous),
        ("velocity", found.velocity.is_none()),
        ("effort", found.effort.is_none()),
    ]
    .iter()
    .filter(|(_, absent)| *absent)
    .map(|(name, _)| *name)
    .collect();
    if !missing.is_empty() {
        notes.push(format!(
            "joint `{}` has no {} limit in the file",
            joint.name,
            missing.join(", ")
        ));
    }
    found
}

fn pose(origin: &urdf_rs::Pose) -> Transform {
    Transform::from_xyz_rpy(Vector3::from_row_slice(&origin.xyz.0), Vector3::from_row_slice(&origin.rpy.0))
}

fn axis(joint: &urdf_rs::Joint) -> Result<Vector3<f64>, ModelError> {
    let axis = Vector3::from_row_slice(&joint.axis.xyz.0);
    let length = axis.norm();
    if length.is_finite() && length > 1e-6 {
        return Ok(axis / length);
    }
    Err(single(
        "/urdf",
        format!(
            "joint `{}` has the axis {:?}, which has no direction",
            joint.name, joint.axis.xyz.0
        ),
        "give a unit vector",
    ))
}

fn is_movable(joint: &urdf_rs::Joint) -> bool {
    matches!(
        joint.joint_type,
        urdf_rs::JointType::Revolute | urdf_rs::JointType::Continuous | urdf_rs::JointType::Prismatic
    )
}

/// The links and joints of the file as a tree.
struct Tree<'a> {
    file: &'a urdf_rs::Robot,
    root: &'a str,
    children: HashMap<&'a str, Vec<&'a urdf_rs::Joint>>,
}

impl<'a> Tree<'a> {
    fn new(file: &'a urdf_rs::Robot) -> Result<Self, ModelError> {
        let mut children: HashMap<&str, Vec<&urdf_rs::Joint>> = HashMap::new();
        let mut parents = HashMap::new();
        let known: HashSet<&str> = file.links.iter().map(|l| l.name.as_str()).collect();
        for joint in &file.joints {
            if joint.mimic.is_some()
                || matches!(
                    joint.joint_type,
                    urdf_rs::JointType::Floating | urdf_rs::JointType::Planar | urdf_rs::JointType::Spherical
                )
            {
                let what = format!(
                    "joint `{}` is {:?} or a mimic: not a joint of a serial arm",
                    joint.name, joint.joint_type
                );
                return Err(single("/urdf", what, "make it fixed, or cut it off"));
            }
            for end in [&joint.parent.link, &joint.child.link] {
                if !known.contains(end.as_str()) {
                    return Err(single(
                        "/urdf",
                        format!("joint `{}` names the link `{end}`, which the file does not have", joint.name),
                        "check that the file is complete",
                    ));
                }
            }
            if parents.insert(joint.child.link.as_str(), joint).is_some() {
                return Err(single(
                    "/urdf",
                    format!("link `{}` has two parent joints", joint.child.link),
                    "a serial arm has no closed loop",
                ));
            }
            children.entry(joint.parent.link.as_str()).or_default().push(joint);
        }
        let mut roots = file
            .links
            .iter()
            .map(|l| l.name.as_str())
            .filter(|l| !parents.contains_key(l) && children.contains_key(l));
        let root = roots
            .next()
            .ok_or_else(|| single("/urdf", "has no root link with a joint", "check that the file is complete"))?;
        if let Some(other) = roots.next() {
            return Err(single(
                "/urdf",
                format!("has two roots, `{root}` and `{other}`"),
                "join them by a fixed joint",
            ));
        }
        Ok(Self { file, root, children })
    }

    fn children(&self, link: &str) -> &[&'a urdf_rs::Joint] {
        self.children.get(link).map_or(&[], Vec::as_slice)
    }

    /// Paths (as joints) from the root to every last movable joint.
    fn paths(&self) -> Vec<Vec<&'a urdf_rs::Joint>> {
        let mut ends = Vec::new();
        let mut stack: Vec<(&str, Vec<&'a urdf_rs::Joint>)> = vec![(self.root, Vec::new())];
        while let Some((link, path)) = stack.pop() {
            let next = self.children(link);
            if next.is_empty() {
                ends.push(path);
                continue;
            }
            for joint in next.iter().rev() {
                let mut longer = path.clone();
                longer.push(*joint);
                stack.push((&joint.child.link, longer));
            }
        }
        ends
    }

    fn chain(&self, tip: Option<&str>) -> Result<Vec<&'a urdf_rs::Joint>, ModelError> {
        if let Some(tip) = tip {
            return self.path_to(tip);
        }
        let mut longest: Vec<Vec<&urdf_rs::Joint>> = Vec::new();
        for mut path in self.paths() {
            // Whatever hangs on the last movable joint by fixed joints is merged into its link.
            while path.last().is_some_and(|j| !is_movable(j)) {
                path.pop();
            }
            let names = |p: &[&urdf_rs::Joint]| p.iter().map(|j| j.name.clone()).collect::<Vec<_>>();
            let mine = names(&path);
            if longest.iter().any(|p| names(p).starts_with(&mine)) {
                continue;
            }
            longest.retain(|p| !mine.starts_with(&names(p)));
            longest.push(path);
        }
        match longest.len() {
            1 if !longest[0].is_empty() => Ok(longest.remove(0)),
            0 | 1 => Err(single(
                "/urdf",
                "has no movable joint",
                "a robot has at least one revolute, continuous or prismatic joint",
            )),
            _ => {
                let tips: Vec<_> = longest
                    .iter()
                    .filter_map(|p| p.last())
                    .map(|j| format!("`{}`", j.child.link))
                    .collect();
                Err(single(
                    "/urdf",
                    format!("has several chains, ending in {}", tips.join(", ")),
                    "name the one you mean in `tip`",
                ))
            }
        }
    }

    fn path_to(&self, tip: &str) -> Result<Vec<&'a urdf_rs::Joint>, ModelError> {
        let mut path = Vec::new();
        let mut link = tip;
        while link != self.root {
            let Some(joint) = self.file.joints.iter().find(|j| j.child.link == link) else {
                return Err(single(
                    "/tip",
                    format!("the file has no link `{tip}`"),
                    "use the name of a link in the file",
                ));
            };
            path.push(joint);
            link = &joint.parent.link;
        }
        path.reverse();
        Ok(path)
    }

    /// Inertia of `link` and of all that hangs on it without being the next link of the chain, about the frame of `link`;
    /// `None` when none of these has an inertial.
    fn merged_inertia(
        &self,
        link: &str,
        chain: &[&urdf_rs::Joint],
        stated: &UrdfElements,
        notes: &mut Vec<String>,
    ) -> Option<LinkInertia> {
        let mut total = LinkInertia::zero();
        let mut any = false;
        let mut stack = vec![(link.to_string(), Transform::identity())];
        while let Some((name, here)) = stack.pop() {
            if stated.inertials.contains(&name) {
                let inertial = &self.file.links.iter().find(|l| l.name == name)?.inertial;
                total = total + own_inertia(inertial).transformed(&here);
                any = true;
            }
            for joint in self.children(&name) {
                let goes_on = chain.iter().any(|c| c.name == joint.name) && is_movable(joint);
                if !goes_on {
                    stack.push((joint.child.link.clone(), here * pose(&joint.origin)));
                }
            }
        }
        if !any {
            notes.push(format!(
                "link `{link}` has no inertial in the file: its prior parameters are unknown"
            ));
        }
        any.then_some(total)
    }

    fn frozen_branches(&self, chain: &[&urdf_rs::Joint]) -> Vec<String> {
        self.file
            .joints
            .iter()
            .filter(|j| is_movable(j) && !chain.iter().any(|c| c.name == j.name))
            .map(|j| format!("joint `{}` is not on the chain: it is taken as fixed at zero", j.name))
            .collect()
    }
}

fn own_inertia(inertial: &urdf_rs::Inertial) -> LinkInertia {
    let i = &inertial.inertia;
    let about_com = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let body = PhysicalInertia {
        mass: inertial.mass.value,
        center_of_mass: Vector3::zeros(),
        inertia: about_com,
    };
    body.about_origin().transformed(&pose(&inertial.origin))
}
