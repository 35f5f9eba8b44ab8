//! A robot written out again as a robot document, in the frames of the description it came from.

use crate::documents::bounds::{axis_name, bounds_value};
use crate::formats::models::frames::{Described, described, roll_pitch_yaw};
use crate::model::{Capsule, Joint, Robot};
use nalgebra::Matrix3;
use serde_json::{Map, Value, json};

/// The robot as a document that POST /robots takes, its priors included.
pub fn robot_value(robot: &Robot) -> Value {
    let joints: Vec<Value> = robot
        .joints()
        .iter()
        .zip(described(robot))
        .map(|(joint, frame)| joint_value(joint, &frame))
        .collect();
    let friction = robot.friction();
    let declared: Vec<&str> = [(friction.viscous, "viscous"), (friction.coulomb, "coulomb")]
        .iter()
        .filter(|(on, _)| *on)
        .map(|(_, n)| *n)
        .collect();
    json!({"name": robot.name(), "gravity": robot.gravity().as_slice(), "joints": joints, "friction": declared})
}

fn joint_value(joint: &Joint, frame: &Described) -> Value {
    let mut value = Map::new();
    value.insert("name".into(), json!(joint.name));
    value.insert(
        "kind".into(),
        json!(if joint.is_revolute() { "revolute" } else { "prismatic" }),
    );
    match joint.mdh {
        Some(mdh) => value.insert("mdh".into(), json!({"alpha": mdh.alpha, "d": mdh.d, "theta": mdh.theta, "r": mdh.r})),
        None => value.insert(
            "placement".into(),
            json!({"xyz": frame.pose.translation.as_slice(), "rpy": roll_pitch_yaw(&frame.pose.rotation), "axis": frame.axis.as_slice()}),
        ),
    };
    let l = &joint.limits;
    value.insert(
        "limits".into(),
        json!({"position": l.position, "velocity": l.velocity, "acceleration": l.acceleration, "jerk": l.jerk, "effort": l.effort}),
    );
    value.insert("link".into(), json!(joint.link_name));
    if let Some(prior) = &joint.prior {
        let turn = frame.turn;
        let center = turn * prior.inertia.center_of_mass;
        let i = turn * prior.inertia.inertia * turn.transpose();
        let prior = json!({
            "mass": prior.inertia.mass,
            "center_of_mass": center.as_slice(),
            "inertia": {"xx": i[(0, 0)], "xy": i[(0, 1)], "xz": i[(0, 2)], "yy": i[(1, 1)], "yz": i[(1, 2)], "zz": i[(2, 2)]},
            "viscous": prior.viscous,
            "coulomb": prior.coulomb,
        });
        value.insert("prior".into(), prior);
    }
    if !joint.geometry.is_empty() {
        let capsules = joint.geometry.iter().map(|c| capsule_value(c, &frame.turn));
        value.insert("geometry".into(), capsules.collect());
    }
    if let Some(bounds) = bounds_value(&joint.bounds) {
        value.insert("bounds".into(), bounds);
    }
    if let Some(axis) = joint.slender_axis {
        value.insert("slender_axis".into(), json!(axis_name(axis)));
    }
    Value::Object(value)
}

/// A capsule in the link frame of the description.
fn capsule_value(capsule: &Capsule, turn: &Matrix3<f64>) -> Value {
    let [from, to] = capsule.ends.map(|end| turn * end);
    json!({"from": from.as_slice(), "to": to.as_slice(), "radius": capsule.radius})
}
