//! Kinetic and potential energy: the yardstick for power balance, `qdᵀ tau = d/dt (T + U)` without friction.

use super::kinematics::forward_kinematics;
use crate::model::Robot;
use crate::parameters::Layout;
use nalgebra::Vector3;

/// Energies of the arm (J).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Zero where every first moment lies in the base origin.
    pub potential: f64,
}

impl Energy {
    /// Kinetic and potential energy together (J).
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential
    }
}

/// Energy at `q, qd` (n) for `phi` (p). Works in the base frame with Jacobians, sharing nothing with the recursions in the link
/// frames.
///
/// `T = Σ ½ m v·v + v·(ω × h) + ½ ω·I ω`, `U = −Σ g·(m p + h)`, all about the link origins.
pub fn energy(robot: &Robot, layout: &Layout, phi: &[f64], q: &[f64], qd: &[f64]) -> Energy {
    let mut total = Energy {
        kinetic: 0.0,
        potential: 0.0,
    };
    let poses = forward_kinematics(robot, q);
    for (k, pose) in poses.iter().enumerate() {
        let (mut v, mut w) = (Vector3::zeros(), Vector3::zeros());
        for (j, joint) in robot.joints().iter().enumerate().take(k + 1) {
            let axis = poses[j].rotation * Vector3::z() * qd[j];
            if joint.is_revolute() {
                w += axis;
                v += axis.cross(&(pose.translation - poses[j].translation));
            } else {
                v += axis;
            }
        }
        let body = layout.link_inertia(phi, k);
        let h = pose.rotation * body.first_moment;
        let inertia = pose.rotation * body.inertia * pose.rotation.transpose();
        total.kinetic += 0.5 * body.mass * v.dot(&v) + v.dot(&w.cross(&h)) + 0.5 * w.dot(&(inertia * w));
        total.potential -= robot.gravity().dot(&(pose.translation * body.mass + h));
    }
    total
}
