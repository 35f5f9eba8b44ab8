//! A robot written out again as a robot document, in the frames of the description it came from.

use crate::documents::bounds::{written_axis, written_bounds};
use crate::documents::requests;
use crate::formats::models::frames::{Described, described, roll_pitch_yaw};
use crate::model::{Capsule, Joint, LinkPrior, Mdh, Robot};
use nalgebra::Matrix3;
use serde_json::Value;

/// [`written_robot`] as JSON.
pub fn robot_value(robot: &Robot) -> Value {
    serde_json::to_value(written_robot(robot)).expect("plain numbers and words")
}

/// The robot as a document that POST /robots takes, its priors included.
pub fn written_robot(robot: &Robot) -> requests::JointRobot {
    let frames = described(robot);
    let declared = robot.friction();
    let friction = [
        (declared.viscous, requests::Friction::Viscous),
        (declared.coulomb, requests::Friction::Coulomb),
    ];
    requests::JointRobot {
        name: robot.name().into(),
        gravity: Some(robot.gravity().into()),
        joints: robot
            .joints()
            .iter()
            .zip(&frames)
            .map(|(joint, frame)| written_joint(joint, frame))
            .collect(),
        friction: Some(friction.into_iter().filter_map(|(is, word)| is.then_some(word)).collect()),
        effects: None,
        source: None,
    }
}

fn written_joint(joint: &Joint, frame: &Described) -> requests::Joint {
    let limits = &joint.limits;
    let capsules: Vec<_> = joint.geometry.iter().map(|c| written_capsule(c, &frame.turn)).collect();
    requests::Joint {
        name: joint.name.clone(),
        kind: match joint.is_revolute() {
            true => requests::JointKind::Revolute,
            false => requests::JointKind::Prismatic,
        },
        mdh: joint.mdh.map(written_mdh),
        dh: None,
        placement: joint.mdh.is_none().then(|| requests::Placement {
            xyz: Some(frame.pose.translation.into()),
            rpy: Some(roll_pitch_yaw(&frame.pose.rotation)),
            axis: Some(frame.axis.into()),
            source: None,
        }),
        limits: Some(requests::Limits {
            position: limits.position,
            velocity: limits.velocity,
            acceleration: limits.acceleration,
            jerk: limits.jerk,
            effort: limits.effort,
            source: None,
        }),
        prior: joint.prior.as_ref().map(|prior| written_prior(prior, &frame.turn)),
        geometry: (!capsules.is_empty()).then_some(capsules),
        bounds: written_bounds(&joint.bounds),
        slender_axis: joint.slender_axis.map(written_axis),
        link: Some(joint.link_name.clone()),
        source: None,
    }
}

fn written_mdh(mdh: Mdh) -> requests::Mdh {
    requests::Mdh {
        alpha: mdh.alpha,
        d: mdh.d,
        theta: mdh.theta,
        r: mdh.r,
        source: None,
    }
}

/// What is known of a link, in the link frame of the description.
fn written_prior(prior: &LinkPrior, turn: &Matrix3<f64>) -> requests::LinkPrior {
    let i = turn * prior.inertia.inertia * turn.transpose();
    requests::LinkPrior {
        mass: prior.inertia.mass,
        center_of_mass: (turn * prior.inertia.center_of_mass).into(),
        inertia: requests::Inertia {
            xx: i[(0, 0)],
            xy: i[(0, 1)],
            xz: i[(0, 2)],
            yy: i[(1, 1)],
            yz: i[(1, 2)],
            zz: i[(2, 2)],
        },
        viscous: Some(prior.viscous),
        coulomb: Some(prior.coulomb),
        source: None,
    }
}

/// A capsule in the link frame of the description.
fn written_capsule(capsule: &Capsule, turn: &Matrix3<f64>) -> requests::Capsule {
    let [from, to] = capsule.ends.map(|end| (turn * end).into());
    requests::Capsule {
        from,
        to,
        radius: capsule.radius,
        source: None,
    }
}
