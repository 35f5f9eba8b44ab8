//! Random arms and states for the property tests.
#![allow(dead_code)]

use dynident::model::{Friction, Joint, JointKind, Limits, Mdh, Robot};
use dynident::spatial::Transform;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const FRICTION: Friction = Friction {
    viscous: true,
    coulomb: true,
};

pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub fn uniform(rng: &mut ChaCha8Rng, half: f64) -> f64 {
    rng.random_range(-half..half)
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[rng.random_range(0..from.len())]
}

/// An arm with general placements: nothing parallel, nothing zero.
pub fn general_arm(seed: u64, joints: usize) -> Robot {
    let mut rng = rng(seed);
    let joints = (0..joints)
        .map(|j| {
            let kind = if rng.random_range(0..4) == 0 {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            };
            let xyz = Vector3::from_fn(|_, _| uniform(&mut rng, 0.5));
            let rpy = Vector3::from_fn(|_, _| uniform(&mut rng, 3.0));
            Joint::from_placement(format!("j{j}"), kind, Transform::from_xyz_rpy(xyz, rpy))
        })
        .collect();
    let gravity = Vector3::from_fn(|_, _| uniform(&mut rng, 9.81));
    Robot::new("general", gravity, joints, FRICTION).unwrap()
}

/// An arm as they are built: modified DH with quarter turns and many zeros, gravity along an axis or none. These have the
/// special cases of the regrouping rules: parallel first axes, sliding joints, intersecting axes.
pub fn structured_arm(seed: u64, joints: usize) -> Robot {
    let mut rng = rng(seed);
    let quarter = std::f64::consts::FRAC_PI_2;
    let sliding = pick(&mut rng, &[0, 2, 4]);
    let joints = (0..joints)
        .map(|j| {
            let kind = if rng.random_range(0..6) < sliding {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            };
            let mdh = Mdh {
                alpha: pick(&mut rng, &[0.0, 0.0, quarter, -quarter, 2.0 * quarter, 0.7]),
                d: pick(&mut rng, &[0.0, 0.0, 0.3, -0.25]),
                theta: pick(&mut rng, &[0.0, 0.0, quarter, 0.4]),
                r: pick(&mut rng, &[0.0, 0.0, 0.4]),
            };
            Joint::from_mdh(format!("j{j}"), kind, mdh)
        })
        .collect();
    let g = 9.81;
    let gravities = [
        [0.0, 0.0, -g],
        [0.0, 0.0, -g],
        [g, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 3.0, -9.0],
    ];
    let gravity = Vector3::from(pick(&mut rng, &gravities));
    Robot::new("structured", gravity, joints, FRICTION).unwrap()
}

/// `count` vectors of `n` values in ±half.
pub fn vectors(rng: &mut ChaCha8Rng, count: usize, n: usize, half: f64) -> Vec<Vec<f64>> {
    (0..count).map(|_| (0..n).map(|_| uniform(rng, half)).collect()).collect()
}

/// The paper's Table 1.
pub fn iiwa14() -> Robot {
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, -quarter, -quarter, quarter, quarter, -quarter];
    let r = [0.0, 0.0, 0.42, 0.0, 0.4, 0.0, 0.0];
    let joints = (0..7)
        .map(|j| {
            let mdh = Mdh {
                alpha: alphas[j],
                d: 0.0,
                theta: 0.0,
                r: r[j],
            };
            Joint::from_mdh(format!("A{}", j + 1), JointKind::Revolute, mdh).with_limits(Limits::unlimited())
        })
        .collect();
    Robot::new("iiwa 14", Vector3::new(0.0, 0.0, -9.81), joints, FRICTION).unwrap()
}

/// The same with the manufacturer's position and velocity limits.
pub fn iiwa14_limited() -> Robot {
    let positions = [170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0f64];
    let velocities = [85.0, 85.0, 100.0, 75.0, 130.0, 135.0, 135.0f64];
    let bare = iiwa14();
    let limited = bare.joints().iter().enumerate().map(|(j, joint)| {
        let q = positions[j].to_radians();
        let limits = Limits {
            position: Some([-q, q]),
            velocity: Some(velocities[j].to_radians()),
            ..Limits::unlimited()
        };
        joint.clone().with_limits(limits)
    });
    Robot::new("iiwa 14", Vector3::new(0.0, 0.0, -9.81), limited.collect(), FRICTION).unwrap()
}
