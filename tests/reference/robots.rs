//! Shipped robots against what has been published of them: forward kinematics and numbers of base parameters.

use crate::support::{rng, uniform};
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::{forward_kinematics, inverse_dynamics};
use dynident::model::Robot;
use dynident::parameters::{BaseParameters, Layout};
use dynident::spatial::Transform;
use nalgebra::{Matrix3, Vector3};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

fn shipped(name: &str) -> Robot {
    Shipped.named(name).expect("comes with the program").robot
}

fn last(robot: &Robot, q: &[f64]) -> Transform {
    *forward_kinematics(robot, q).last().unwrap()
}

fn assert_at(pose: &Transform, translation: [f64; 3], bound: f64) {
    let error = (pose.translation - Vector3::from(translation)).amax();
    assert!(error <= bound, "{:?} for {translation:?}", pose.translation);
}

/// Corke, Robotics, Vision and Control, section 7: the nominal pose, printed to four digits, here 0.672 m above the floor.
#[test]
fn val_the_puma_has_the_published_nominal_pose() {
    let pose = last(&shipped("puma560"), &[0.0, FRAC_PI_4, PI, 0.0, FRAC_PI_4, 0.0]);
    assert_at(&pose, [0.5963, -0.1501, -0.01435 + 0.672], 1e-4);
    let turn = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
    assert!((pose.rotation - turn).amax() < 1e-12, "{}", pose.rotation);
}

/// MoveIt's tutorials print the flange of the ready pose; it is 0.107 m below the last frame.
#[test]
fn val_the_panda_has_the_published_ready_pose() {
    let ready = [0.0, -FRAC_PI_4, 0.0, -3.0 * FRAC_PI_4, 0.0, FRAC_PI_2, FRAC_PI_4];
    let pose = last(&shipped("panda"), &ready) * Transform::trans(0.0, 0.0, 0.107);
    assert_at(&pose, [0.306891, 0.0, 0.590282], 1e-6);
}

/// De Luca's table of the same arm in the standard convention, from the shoulder to the wrist.
#[test]
fn val_the_lwr_has_the_kinematics_of_another_table() {
    let alpha = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, 0.0].map(|quarter: f64| quarter * FRAC_PI_2);
    let d = [0.0, 0.0, 0.4, 0.0, 0.39, 0.0, 0.0];
    let (robot, mut rng) = (shipped("lwr4"), rng(1));
    for _ in 0..50 {
        let q: Vec<f64> = (0..7).map(|_| uniform(&mut rng, 3.0)).collect();
        let step =
            |t: Transform, i: usize| t * Transform::rot_z(q[i]) * Transform::trans(0.0, 0.0, d[i]) * Transform::rot_x(alpha[i]);
        let table = (0..7).fold(Transform::trans(0.0, 0.0, 0.3105), step);
        let flange = table * Transform::trans(0.0, 0.0, 0.078);
        let pose = last(&robot, &q);
        assert_at(&pose, flange.translation.into(), 1e-12);
        assert!((pose.rotation - flange.rotation).amax() < 1e-12);
    }
    assert_at(&last(&robot, &[0.0; 7]), [0.0, 0.0, 1.1785], 1e-12);
}

/// The maker's drawing: upright at zero, 320 mm and twice 225 mm high, 35 mm beside axis 1; axis 2 and axis 3 bend it forwards.
#[test]
fn val_the_tx40_has_the_lengths_and_the_zero_of_the_makers_drawing() {
    let robot = shipped("tx40");
    for (q2, q3, wrist) in [
        (0.0, 0.0, [0.0, 0.035, 0.770]),
        (FRAC_PI_2, 0.0, [0.450, 0.035, 0.320]),
        (0.0, FRAC_PI_2, [0.225, 0.035, 0.545]),
    ] {
        assert_at(&last(&robot, &[0.0, q2, q3, 0.0, 0.0, 0.0]), wrist, 1e-12);
    }
}

/// Inertial base parameters, beside viscous and Coulomb friction of every joint: 43 for anthropomorphic arms with seven joints
/// (Jubien et al. 2014 LWR; Gaz et al. 2019 Panda; Stürz et al. 2017 iiwa), 36 for arms like Puma and TX40 with their shoulder
/// and spherical wrist (Khalil & Dombre 2004).
#[test]
fn val_shipped_robots_have_the_published_number_of_base_parameters() {
    for (name, inertial) in [
        ("lwr4", 43),
        ("panda", 43),
        ("fr3", 43),
        ("iiwa7", 43),
        ("iiwa14", 43),
        ("puma560", 36),
        ("tx40", 36),
    ] {
        let robot = shipped(name);
        assert_eq!(
            BaseParameters::exact(&robot).len(),
            inertial + 2 * robot.joint_count(),
            "{name}"
        );
    }
}

/// Bodies that were published in other frames, against Pinocchio with the published numbers (`tests/data/ref_shipped_bodies.py`).
#[test]
fn val_shipped_bodies_have_the_torques_of_their_sources() {
    let text = include_str!("../data/ref_shipped_bodies.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    for (name, states) in reference["arms"].as_object().unwrap() {
        let robot = shipped(name);
        let layout = Layout::standard(&robot);
        let phi = layout.prior(&robot).expect("every link has a body");
        for state in states.as_array().unwrap() {
            let list =
                |field: &str| -> Vec<f64> { state[field].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
            let torque = inverse_dynamics(&robot, &layout, phi.as_slice(), &list("q"), &list("qd"), &list("qdd"));
            for (ours, theirs) in torque.iter().zip(list("torque")) {
                // The documents have twelve digits.
                assert!((ours - theirs).abs() < 1e-9 * (1.0 + theirs.abs()), "{name}: {ours} {theirs}");
            }
        }
    }
}
