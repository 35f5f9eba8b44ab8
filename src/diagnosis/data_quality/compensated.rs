//! Torques from which the drive has taken gravity: commanded efforts of controllers that compensate for it.

use super::evidence::Evidence;
use super::fault::{DataFault, FaultKind, Remedy};
use super::order::{Extra, Projection, Sampled, root_mean_square};
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::Robot;
use crate::parameters::Layout;
use nalgebra::Vector3;

/// The same arm in free fall.
pub(crate) fn weightless(robot: &Robot) -> Robot {
    robot.with_gravity(Vector3::zeros())
}

/// What the model without gravity leaves, where it explains more than a constant.
pub(crate) fn rest_without_gravity(sampled: &Sampled, floating: &Robot) -> Option<f64> {
    let n = floating.joint_count();
    let projection = Projection::new(&sampled.of(floating), &[]);
    let (order, signs): (Vec<usize>, Vec<f64>) = ((0..n).collect(), vec![1.0; n]);
    projection.explains(&order, &signs).then(|| projection.rest(&order, &signs))
}

/// Whether the torques hold next to nothing of the gravity that the links' priors have, in whichever direction it points, beside
/// a model without gravity.
pub(crate) fn lacks_gravity_of_priors(sampled: &Sampled, floating: &Robot) -> bool {
    let size = sampled.robot.gravity().norm();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let columns: Option<Vec<Extra>> = axes.iter().map(|axis| gravity_of_priors(sampled, axis * size)).collect();
    let Some(columns) = columns.filter(|_| size > 0.0) else {
        return false;
    };
    let n = floating.joint_count();
    let projection = Projection::new(&sampled.of(floating), &columns);
    let evidence = Evidence::of(&projection, &(0..n).collect::<Vec<_>>(), &vec![1.0; n]);
    let first = evidence.values.len() - columns.len();
    // Along an axis that all joints share, gravity makes no torque and cannot be seen.
    let seen = |k: &usize| columns[*k].iter().any(|(_, torque)| root_mean_square(torque) > 0.0);
    let mut shares = (0..columns.len())
        .filter(seen)
        .map(|k| evidence.with_deviation(first + k))
        .peekable();
    shares.peek().is_some()
        && shares.all(|(share, deviation)| {
            share.abs() < SETTINGS.data_quality.most_gravity
                && share.abs() + SETTINGS.data_quality.gravity_deviations * deviation < SETTINGS.data_quality.least_gravity
        })
}

/// Torque that the links' priors need to hold the arm up along the motion, where gravity is this; `None` without priors.
fn gravity_of_priors(sampled: &Sampled, gravity: Vector3<f64>) -> Option<Extra> {
    let robot = sampled.robot.with_gravity(gravity);
    let layout = Layout::standard(&robot);
    let prior = layout.prior(&robot)?;
    let motion = &sampled.motion;
    let held = Motion::from_fn(motion.joints(), motion.samples(), |j, s| [motion.get(j, s)[0], 0.0, 0.0]);
    let torque = inverse_dynamics_batch(&Chain::new(&robot), &layout, prior.as_slice(), &held, Coulomb::Sign);
    let of = |j: usize| (j, torque[j * motion.stride()..][..motion.samples()].to_vec());
    Some((0..motion.joints()).map(of).collect())
}

pub(crate) fn compensated(robot: &Robot, evidence: &str) -> DataFault {
    let detail = format!(
        "the torques have no gravity in them: {evidence}; log the torque of the joints and not what a controller adds to its gravity compensation, \
         or identify with `gravity` [0, 0, 0] for inertia and friction alone"
    );
    let joints = robot.joints().iter().map(|j| j.name.clone()).collect();
    DataFault::new(FaultKind::GravityCompensatedTorque, joints, detail, Remedy::Nothing)
}
