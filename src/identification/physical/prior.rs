//! What a link weighs before anything is measured.

use crate::model::{LinkPrior, Robot};
use crate::spatial::PhysicalInertia;
use nalgebra::{Matrix3, Vector3};

/// Mass and length that make a link's parameters comparable: M by `mass`, first moments by `mass · length`, inertias by
/// `mass · length²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkScale {
    /// Mass that stands for a link's (kg).
    pub mass: f64,
    /// Length that stands for a link's (m).
    pub length: f64,
}

/// Diameter (m) and density [kg/m³] of the rod: a 40 cm link then weighs 4.7 kg, as the links of arms with 10 kg payload do.
const ROD_DIAMETER: f64 = 0.1;
const ROD_DENSITY: f64 = 1500.0;

/// Links of a robot as given with it, and rods where they are not.
pub fn priors(robot: &Robot) -> Vec<LinkPrior> {
    (0..robot.joint_count())
        .map(|k| {
            robot.joints()[k]
                .prior
                .filter(|p| p.inertia.mass > 0.0)
                .unwrap_or_else(|| rod_prior(robot, k))
        })
        .collect()
}

/// Link `k` as a solid rod from its joint to the next, 10 cm across and at least as long, of density 1500 kg/m³, without
/// friction.
pub fn rod_prior(robot: &Robot, k: usize) -> LinkPrior {
    let end = robot
        .joints()
        .get(k + 1)
        .map_or(Vector3::zeros(), |next| next.placement.translation);
    let length = end.norm().max(ROD_DIAMETER);
    let axis = if end.norm() > 1e-6 { end.normalize() } else { Vector3::z() };
    let radius = ROD_DIAMETER / 2.0;
    let mass = ROD_DENSITY * std::f64::consts::PI * radius * radius * length;
    let along = 0.5 * mass * radius * radius;
    let across = mass * (radius * radius / 4.0 + length * length / 12.0);
    let inertia = Matrix3::identity() * across + axis * axis.transpose() * (along - across);
    LinkPrior {
        inertia: PhysicalInertia {
            mass,
            center_of_mass: end / 2.0,
            inertia,
        },
        viscous: 0.0,
        coulomb: 0.0,
    }
}

impl LinkScale {
    /// Of a prior: its mass, and its radius of gyration about the link frame's origin.
    pub fn from_link(prior: &LinkPrior) -> Self {
        let about_origin = prior.inertia.about_origin();
        let length = (about_origin.inertia.trace() / (2.0 * prior.inertia.mass)).sqrt();
        Self {
            mass: prior.inertia.mass,
            length: length.max(ROD_DIAMETER / 2.0),
        }
    }
}
