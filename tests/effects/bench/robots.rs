//! Arms with plausible bodies, and the published one.

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::model::{Friction, Joint, JointKind, Mdh, Robot};
use dynident::parameters::{Layout, ParameterKind};
use dynident::spatial::PhysicalInertia;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn arm(name: &str, table: &[(f64, f64, f64, f64)]) -> Robot {
    let joint = |(i, &(alpha, d, theta, r)): (usize, &(f64, f64, f64, f64))| {
        Joint::from_mdh(format!("J{}", i + 1), JointKind::Revolute, Mdh { alpha, d, theta, r })
    };
    let joints = table.iter().enumerate().map(joint).collect();
    Robot::new(
        name,
        Vector3::new(0.0, 0.0, -9.81),
        joints,
        Friction {
            viscous: true,
            coulomb: true,
        },
    )
    .unwrap()
}

/// The iiwa 14 of the paper's Table 1.
pub fn seven_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "iiwa 14",
        &[
            (0.0, 0.0, 0.0, 0.0),
            (q, 0.0, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.42),
            (-q, 0.0, 0.0, 0.0),
            (q, 0.0, 0.0, 0.4),
            (q, 0.0, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.0),
        ],
    )
}

/// Kinematics of a UR10-type arm.
pub fn six_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "six axes",
        &[
            (0.0, 0.0, 0.0, 0.128),
            (q, 0.0, 0.0, 0.0),
            (0.0, -0.612, 0.0, 0.0),
            (0.0, -0.572, 0.0, 0.164),
            (q, 0.0, 0.0, 0.116),
            (-q, 0.0, 0.0, 0.092),
        ],
    )
}

/// Four axes: waist, shoulder, elbow and a roll.
pub fn four_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "four axes",
        &[
            (0.0, 0.0, 0.0, 0.3),
            (-q, 0.1, 0.0, 0.0),
            (0.0, 0.4, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.35),
        ],
    )
}

pub fn robots() -> Vec<Robot> {
    vec![seven_axes(), six_axes(), four_axes()]
}

/// Plausible bodies: boxes that get lighter towards the tip, friction that goes with them.
pub fn bodies(robot: &Robot, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xb0d1e5);
    let layout = Layout::standard(robot);
    let mut phi = vec![0.0; layout.len()];
    let n = robot.joint_count();
    for link in 0..n {
        let size = 1.0 - 0.8 * link as f64 / n as f64;
        let mass = 5.0 * size * rng.random_range(0.7..1.3);
        let center = Vector3::from_fn(|_, _| rng.random_range(-0.12..0.12) * size);
        let sides = Vector3::from_fn(|_, _| rng.random_range(0.08..0.3) * size);
        let square = sides.component_mul(&sides) * (mass / 12.0);
        let inertia = Matrix3::from_diagonal(&Vector3::new(square.y + square.z, square.x + square.z, square.x + square.y));
        let body = PhysicalInertia {
            mass,
            center_of_mass: center,
            inertia,
        }
        .about_origin()
        .parameters();
        for (at, parameter) in layout.parameters().iter().enumerate().filter(|(_, p)| p.link == link) {
            phi[at] = match parameter.kind {
                ParameterKind::Inertial(i) => body[i as usize],
                ParameterKind::Viscous => 1.5 * size * rng.random_range(0.5..1.5),
                ParameterKind::Coulomb => 1.5 * size * rng.random_range(0.5..1.5),
            };
        }
    }
    phi
}

/// The iiwa 14 with the limits of its data sheet and without priors, and the parameters of the paper's Table 3.
pub fn published() -> (Robot, Vec<f64>) {
    let truth = Shipped.named("iiwa14").expect("comes with the program").robot;
    let parameters = Layout::standard(&truth).prior(&truth).expect("has priors");
    let bare = |joint: &Joint| Joint {
        prior: None,
        ..joint.clone()
    };
    let joints = truth.joints().iter().map(bare).collect();
    let robot = Robot::new(truth.name(), truth.gravity(), joints, truth.friction()).expect("valid without priors");
    (robot, parameters.as_slice().to_vec())
}

/// Bodies whose friction is none, though it is declared.
pub fn frictionless_bodies(robot: &Robot, seed: u64) -> Vec<f64> {
    let mut phi = bodies(robot, seed);
    let kinds = Layout::standard(robot);
    for (value, parameter) in phi.iter_mut().zip(kinds.parameters()) {
        if !matches!(parameter.kind, ParameterKind::Inertial(_)) {
            *value = 0.0;
        }
    }
    phi
}
