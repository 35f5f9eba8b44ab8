//! What a robot looks like, and what a motion asks of it.

use super::CancelFlag;
use crate::documents::{DrawnCapsule, DrawnJoint, DrawnLink, MotionDocument, MotionRequest, SampledMotion, written_robot};
use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::{Capsule, Joint, Robot};
use crate::parameters::Layout;
use crate::spatial::Transform;
use crate::trajectory::{FourierSeries, Trajectory};
use nalgebra::Matrix3;

/// Draws the robot of a request and samples its trajectory; `None` where `cancel` was set meanwhile.
pub fn motion(request: &MotionRequest, cancel: &CancelFlag) -> Option<MotionDocument> {
    let robot = &request.robot.robot;
    let motion = match &request.series {
        Some(series) => Some(sampled(robot, series, request.samples, cancel)?),
        None => None,
    };
    let (shaped, guessed) = robot.with_shape();
    Some(MotionDocument {
        shape: shape(&shaped),
        shape_guessed: !guessed.is_empty(),
        robot: robot.name().to_string(),
        gravity: robot.gravity().into(),
        joints: robot.joints().iter().map(drawn).collect(),
        motion,
        description: written_robot(robot),
        notes: request.robot.notes.clone(),
    })
}

fn shape(robot: &Robot) -> Vec<DrawnCapsule> {
    let joints = robot.joints().iter().enumerate();
    let capsules = joints.flat_map(|(j, joint)| joint.geometry.iter().map(move |c| (j, c)));
    let drawn = |(joint, c): (usize, &Capsule)| DrawnCapsule {
        joint,
        from: c.ends[0].into(),
        to: c.ends[1].into(),
        radius: c.radius,
    };
    capsules.map(drawn).collect()
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
}

fn drawn(joint: &Joint) -> DrawnJoint {
    DrawnJoint {
        name: joint.name.clone(),
        kind: if joint.is_revolute() { "revolute" } else { "prismatic" },
        rotation: rows(&joint.placement.rotation),
        translation: joint.placement.translation.into(),
        description_frame: rows(&joint.description_frame),
        position_limits: joint.limits.position,
        velocity_limit: joint.limits.velocity,
        acceleration_limit: joint.limits.acceleration,
        jerk_limit: joint.limits.jerk,
        effort_limit: joint.limits.effort,
        position_unit: joint.position_unit(),
        effort_unit: joint.effort_unit(),
        prior: joint.prior.map(|prior| DrawnLink {
            mass: prior.inertia.mass,
            center_of_mass: prior.inertia.center_of_mass.into(),
            inertia: rows(&prior.inertia.inertia),
        }),
    }
}

fn sampled(robot: &Robot, series: &FourierSeries, samples: usize, cancel: &CancelFlag) -> Option<SampledMotion> {
    let n = robot.joint_count();
    // The last sample is the first of the next period: curves close.
    let time: Vec<f64> = (0..samples)
        .map(|s| series.duration() * s as f64 / (samples - 1) as f64)
        .collect();
    let motion = Motion::from_fn(n, samples, |j, s| match cancel.is_cancelled() {
        true => [0.0; 3],
        false => series.state(j, time[s]),
    });
    if cancel.is_cancelled() {
        return None;
    }
    let layout = Layout::standard(robot);
    let each = |of: &dyn Fn(usize) -> Vec<f64>| (0..n).map(of).collect::<Vec<_>>();
    let torque = layout.prior(robot).map(|phi| {
        let all = inverse_dynamics_batch(&Chain::new(robot), &layout, phi.as_slice(), &motion, Coulomb::Sign);
        each(&|j| all[j * motion.stride()..j * motion.stride() + samples].to_vec())
    });
    let end = |s: usize| {
        let poses = robot
            .joints()
            .iter()
            .enumerate()
            .map(|(j, joint)| joint.pose(motion.get(j, s)[0]));
        poses
            .fold(Transform::identity(), |to_here, pose| to_here * pose)
            .translation
            .into()
    };
    Some(SampledMotion {
        end: (0..samples).map(end).collect(),
        q: each(&|j| motion.positions(j).to_vec()),
        qd: each(&|j| motion.velocities(j).to_vec()),
        qdd: each(&|j| motion.accelerations(j).to_vec()),
        torque,
        time,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::documents::read_motion_request;
    use crate::documents::shipped::Shipped;
    use crate::dynamics::inverse_dynamics;
    use crate::formats::parse;

    #[test]
    fn a_motion_is_sampled_with_the_torque_of_single_states() {
        let text = r#"{"robot": "planar_two_link", "samples": 11, "trajectory": {"fundamental_hz": 0.5, "offset": [0.1, -0.2],
            "coefficients": {"a": [[0.3, 0.1], [0.2, -0.4]], "b": [[0.1, 0.0], [0.0, 0.2]]}}}"#;
        let request = read_motion_request(&parse(text.as_bytes()).unwrap(), &Shipped).unwrap();
        let robot = &request.robot.robot;
        let drawn = motion(&request, &CancelFlag::default()).unwrap().motion.unwrap();
        let layout = Layout::standard(robot);
        let phi = layout.prior(robot).expect("the shipped arm has priors");
        let at = |of: &Vec<Vec<f64>>, s: usize| vec![of[0][s], of[1][s]];
        for s in 0..11 {
            let alone = inverse_dynamics(
                robot,
                &layout,
                phi.as_slice(),
                &at(&drawn.q, s),
                &at(&drawn.qd, s),
                &at(&drawn.qdd, s),
            );
            for j in 0..2 {
                let torque = drawn.torque.as_ref().unwrap()[j][s];
                assert!(
                    (torque - alone[j]).abs() < 1e-12 * (1.0 + alone[j].abs()),
                    "{torque} {}",
                    alone[j]
                );
            }
        }
        // One period later the arm is where it was.
        let gap: f64 = (0..3).map(|i| (drawn.end[0][i] - drawn.end[10][i]).abs()).sum();
        assert!(gap < 1e-12 && drawn.time[10] == 2.0);
    }

    /// What a page is handed to edit is the robot that it asked about: shape, knowledge and all, whatever axis its joints turn
    /// about.
    #[test]
    fn prop_a_description_reads_back_as_the_same_robot() {
        let text = r#"{"robot": {"name": "arm", "gravity": [0, 3, -9], "friction": ["viscous"], "joints": [
            {"name": "J1", "kind": "revolute", "placement": {"xyz": [0.1, 0.2, 0.3], "rpy": [0.4, -0.2, 1.0], "axis": [0, 1, 0]}, "slender_axis": "y",
             "limits": {"position": [-1, 2], "velocity": 1.5}, "link": "upper", "bounds": {"mass": [0.5, 3]},
             "geometry": [{"from": [0, 0, 0.1], "to": [0.3, 0.1, 0], "radius": 0.05}, {"from": [0, 0, 0], "to": [0, 0, 0], "radius": 0.1}],
             "prior": {"mass": 2, "center_of_mass": [0.1, 0.02, 0.03], "inertia": {"xx": 0.02, "xy": 0.001, "xz": 0.002, "yy": 0.03, "yz": -0.001, "zz": 0.025},
                       "viscous": 0.1, "coulomb": 0.2}},
            {"name": "J2", "kind": "prismatic", "placement": {"xyz": [0, 0, 0.5], "axis": [1, 0, 0]}, "limits": {"effort": 30}}]}}"#;
        let read = |text: &str| read_motion_request(&parse(text.as_bytes()).unwrap(), &Shipped).unwrap();
        let draw = |text: &str| motion(&read(text), &CancelFlag::default()).unwrap();
        let first = draw(text);
        let capsules = first.description.joints[0].geometry.as_ref().unwrap();
        assert_eq!(capsules.len(), 2);
        assert!((capsules[0].to[0] - 0.3).abs() < 1e-12, "{capsules:?}");
        let second = draw(&serde_json::json!({"robot": first.description}).to_string());
        let close =
            |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12);
        for (a, b) in first.joints.iter().zip(&second.joints) {
            assert!(
                close(&a.rotation, &b.rotation) && close(&a.description_frame, &b.description_frame),
                "{}",
                a.name
            );
            assert_eq!(
                (&a.name, a.kind, a.position_limits, a.velocity_limit, a.effort_limit),
                (&b.name, b.kind, b.position_limits, b.velocity_limit, b.effort_limit)
            );
        }
        let (first, second) = (first.description, second.description);
        let kept =
            |joint: &crate::documents::requests::Joint| (joint.bounds.clone(), joint.slender_axis.clone(), joint.link.clone());
        assert_eq!(kept(&first.joints[0]), kept(&second.joints[0]));
        assert_eq!((first.friction, first.gravity), (second.friction, second.gravity));
    }

    #[test]
    fn a_cancelled_motion_is_none() {
        let text = r#"{"robot": "planar_two_link", "trajectory": {"fundamental_hz": 0.5, "offset": [0, 0],
            "coefficients": {"a": [[0.3], [0.2]], "b": [[0.1], [0.0]]}}}"#;
        let request = read_motion_request(&parse(text.as_bytes()).unwrap(), &Shipped).unwrap();
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert!(motion(&request, &cancel).is_none());
    }

    #[test]
    fn what_is_wrong_is_named() {
        let text = r#"{"robot": "planar_two_link", "trajectory": {"fundamental_hz": -1, "offset": [0],
            "coefficients": {"a": [[1, 2]], "b": [[1], [2]]}}}"#;
        let found = read_motion_request(&parse(text.as_bytes()).unwrap(), &Shipped).unwrap_err();
        let pointers: Vec<&str> = found.iter().map(|p| p.pointer.as_str()).collect();
        assert_eq!(
            pointers,
            [
                "/trajectory/fundamental_hz",
                "/trajectory/offset",
                "/trajectory/coefficients/a"
            ]
        );
    }
}
