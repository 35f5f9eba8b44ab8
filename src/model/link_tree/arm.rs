//! The arm of a tree in the frames of the dynamics.
//!
//! Fixed joints are merged into the link before them, with their inertia; the base's own fixed part only moves frames. The
//! dynamics want z along every joint, files allow any axis: each link frame is turned so that its z axis is the joint's, and the
//! turn is kept ([`Joint::description_frame`]) so that results can be handed back in the file's own frames.

use super::chain::Chain;
use super::{ChainEnds, Freedom, LinkTree};
use crate::model::capsule::few;
use crate::model::notes::Notes;
use crate::model::{Capsule, FieldProblem, Friction, Joint, JointKind, LinkPrior, ModelError, Robot};
use crate::spatial::{LinkInertia, Transform};
use nalgebra::Vector3;

/// The robot that the chain between `ends` is, with gravity [m/s²] in the frame of the base link.
///
/// # Errors
/// As [`LinkTree::chain`], and everything that [`Robot::new`] refuses, of the joints by their names.
pub(in crate::model) fn arm(
    tree: &LinkTree,
    gravity: Vector3<f64>,
    friction: Friction,
    ends: ChainEnds,
    notes: &mut Notes,
) -> Result<Robot, ModelError> {
    let chain = tree.chain(ends)?;
    tree.locked(&chain, notes);
    let movable: Vec<usize> = chain
        .joints
        .iter()
        .copied()
        .filter(|&j| tree.joints[j].is_movable())
        .collect();
    let mut is_carrier = vec![false; tree.joints.len()];
    movable.iter().for_each(|&j| is_carrier[j] = true);
    let joints = described_joints(tree, &chain, &is_carrier, notes);
    Robot::new(tree.name.clone(), gravity, joints, friction).map_err(|e| {
        let placed = |p: FieldProblem| in_file(tree, &movable, p);
        ModelError(e.0.into_iter().map(placed).collect())
    })
}

fn described_joints(tree: &LinkTree, chain: &Chain, is_carrier: &[bool], notes: &mut Notes) -> Vec<Joint> {
    let mut joints = Vec::new();
    // Pose of the present link frame (as the file has it) in the frame of the dynamics before it.
    let mut to_here = Transform::identity();
    for joint in chain.joints.iter().map(|&j| &tree.joints[j]) {
        notes.extend(joint.notes.iter().cloned());
        if !joint.is_movable() {
            to_here = to_here * joint.origin;
            continue;
        }
        let turn = Transform::z_onto(&joint.axis);
        let anchor = Transform::trans(joint.anchor.x, joint.anchor.y, joint.anchor.z);
        let mut placement = to_here * joint.origin * anchor * Transform::from_rotation(turn);
        placement.rotation = tree.rounding.rotation(placement.rotation);
        placement = placement
            * match joint.freedom {
                Freedom::Prismatic => Transform::trans(0.0, 0.0, -joint.reference),
                _ => Transform::rot_z(-joint.reference),
            };
        // From here on the dynamics' frame is the file's link frame turned by `turn`, at the axis.
        to_here = Transform::from_rotation(turn.transpose()) * anchor.inverse();
        let body = lumped_inertia(tree, joint.child, is_carrier, notes);
        let prior = body.and_then(|b| b.transformed(&to_here).physical());
        let kind = match joint.freedom {
            Freedom::Prismatic => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        joints.push(Joint {
            limits: joint.limits,
            prior: prior.map(|inertia| LinkPrior {
                inertia,
                viscous: joint.viscous,
                coulomb: joint.coulomb,
            }),
            geometry: lumped_shape(tree, joint.child, is_carrier, &to_here),
            description_frame: turn,
            link_name: tree.links[joint.child].name.clone(),
            ..Joint::from_placement(joint.name.clone(), kind, placement)
        });
    }
    joints
}

/// Inertia of `link` and of all that hangs on it without being carried by a joint of the chain, about the frame of `link`; `None`
/// when none of these has an inertial. Every link is in one such part.
fn lumped_inertia(tree: &LinkTree, link: usize, is_carrier: &[bool], notes: &mut Notes) -> Option<LinkInertia> {
    let (mut total, mut any) = (LinkInertia::zero(), false);
    for (at, here) in locked_to(tree, link, is_carrier) {
        notes.extend(tree.links[at].notes.iter().cloned());
        if let Some(own) = &tree.links[at].inertia {
            total = total + own.transformed(&here);
            any = true;
        }
    }
    if !any {
        notes.push(format!(
            "link `{}` has no inertial in the file: its prior parameters are unknown",
            tree.links[link].name
        ));
    }
    any.then_some(total)
}

/// Capsules of `link` and of all that hangs on it, in the frame that its frame has the pose `pose` in.
fn lumped_shape(tree: &LinkTree, link: usize, is_carrier: &[bool], pose: &Transform) -> Vec<Capsule> {
    let parts = locked_to(tree, link, is_carrier);
    let moved = parts.into_iter().flat_map(|(at, here)| {
        let whole = *pose * here;
        tree.links[at].capsules.iter().map(move |c| c.moved(&whole))
    });
    few(moved.collect())
}

/// `link` and all that hangs on it without being carried by a joint of the chain, with the poses in the frame of `link`.
fn locked_to(tree: &LinkTree, link: usize, is_carrier: &[bool]) -> Vec<(usize, Transform)> {
    let (mut all, mut next) = (vec![(link, Transform::identity())], 0);
    while next < all.len() {
        let (at, here) = all[next];
        let locked = tree.children[at]
            .iter()
            .filter(|&&j| !is_carrier[j])
            .map(|&j| &tree.joints[j]);
        all.extend(locked.map(|joint| (joint.child, here * joint.origin)));
        next += 1;
    }
    all
}

/// A movable joint of a chain with the links that move with it.
#[derive(Debug, Clone, PartialEq)]
pub struct CarriedLinks {
    /// Name of the joint.
    pub joint: String,
    /// Name of the link that it moves.
    pub link: String,
    /// The links locked to it, with their inertia about the frame of `link`, where they have one.
    pub locked: Vec<(String, Option<LinkInertia>)>,
}

/// The movable joints of a chain from base to tip, with the links that they carry.
///
/// # Errors
/// As [`LinkTree::chain`].
pub(in crate::model) fn carried(tree: &LinkTree, ends: ChainEnds) -> Result<Vec<CarriedLinks>, ModelError> {
    let chain = tree.chain(ends)?;
    let movable: Vec<usize> = chain.joints.into_iter().filter(|&j| tree.joints[j].is_movable()).collect();
    let mut is_carrier = vec![false; tree.joints.len()];
    movable.iter().for_each(|&j| is_carrier[j] = true);
    let one = |j: usize| {
        let joint = &tree.joints[j];
        let locked = locked_to(tree, joint.child, &is_carrier).into_iter().skip(1);
        let body = |(at, here): (usize, Transform)| {
            let link = &tree.links[at];
            (link.name.clone(), link.inertia.map(|own| own.transformed(&here)))
        };
        CarriedLinks {
            joint: joint.name.clone(),
            link: tree.links[joint.child].name.clone(),
            locked: locked.map(body).collect(),
        }
    };
    Ok(movable.into_iter().map(one).collect())
}

/// A problem of joint i as one of the file's joint: the JSON document has no place for it.
fn in_file(tree: &LinkTree, movable: &[usize], problem: FieldProblem) -> FieldProblem {
    let Some(rest) = problem.pointer.strip_prefix("/joints") else {
        return problem;
    };
    let joint = rest
        .split('/')
        .nth(1)
        .and_then(|index| index.parse::<usize>().ok())
        .and_then(|index| movable.get(index))
        .map(|&j| tree.joints[j].place());
    let field = rest.split('/').skip(2).collect::<Vec<_>>().join("/");
    let detail = match joint {
        Some(joint) if field.is_empty() => format!("{joint}: {}", problem.detail),
        Some(joint) => format!("{joint}: {field} {}", problem.detail),
        None => format!("{rest} {}", problem.detail).trim().to_string(),
    };
    FieldProblem {
        pointer: tree.field.to_string(),
        detail,
        ..problem
    }
}
