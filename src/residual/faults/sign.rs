//! Which sign of a fit is physical.

use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use crate::residual::AugmentedModel;
use nalgebra::DVector;

/// +1 or −1: which sign of the base parameters dissipates energy and has positive inertia.
///
/// With link-side torque sensors friction is small; the kinetic energy of the motion and, where the links have prior parameters, the
/// agreement with their torque are asked as well. Each votes with its share of the torque.
pub(super) fn physical_sign(robot: &Robot, motion: &Motion, values: &DVector<f64>) -> f64 {
    let layout = Layout::standard(robot);
    let model = AugmentedModel::declared(robot);
    let mut phi = vec![0.0; layout.len()];
    model.base.kept.iter().zip(values.iter()).for_each(|(&at, &v)| phi[at] = v);
    if let Some(prior) = layout.prior(robot) {
        let chain = Chain::new(robot);
        let torque = |phi: &[f64]| inverse_dynamics_batch(&chain, &layout, phi, motion, Coulomb::Sign);
        let (have, want) = (torque(&phi), torque(prior.as_slice()));
        let (dot, a, b) = have
            .iter()
            .zip(&want)
            .fold((0.0, 0.0, 0.0), |(d, a, b), (x, y)| (d + x * y, a + x * x, b + y * y));
        // Priors may be off by half; a correlation of more than a half has a sign.
        if dot.abs() > 0.5 * (a * b).sqrt() {
            return dot.signum();
        }
    }
    let power = friction_power(robot, motion, values);
    let friction = (power.iter().sum::<f64>(), power.iter().map(|p| p.abs()).sum::<f64>());
    let inertia = inertia_share(robot, &layout, &phi, motion);
    let share = |(sum, size): (f64, f64)| if size > 0.0 { sum / size } else { 0.0 };
    if share(friction) + inertia < -0.5 { -1.0 } else { 1.0 }
}

/// Power that the friction of every joint takes out of the motion, summed over the samples.
pub(super) fn friction_power(robot: &Robot, motion: &Motion, values: &DVector<f64>) -> Vec<f64> {
    let layout = Layout::standard(robot);
    let kept = AugmentedModel::declared(robot).base.kept;
    let mut power = vec![0.0; robot.joint_count()];
    for (&at, &value) in kept.iter().zip(values.iter()) {
        let parameter = layout.parameters()[at];
        let speeds = motion.velocities(parameter.link);
        power[parameter.link] += match parameter.kind {
            ParameterKind::Viscous => speeds.iter().map(|v| value * v * v).sum(),
            ParameterKind::Coulomb => speeds.iter().map(|v| value * v.abs()).sum(),
            ParameterKind::Inertial(_) => 0.0,
        };
    }
    power
}

/// Mean sign of the kinetic energy `½ qdᵀ M qd` along the motion, M from the inertial parameters: −1 … 1.
fn inertia_share(robot: &Robot, layout: &Layout, phi: &[f64], motion: &Motion) -> f64 {
    let n = robot.joint_count();
    let mut bare = phi.to_vec();
    for (at, parameter) in layout.parameters().iter().enumerate() {
        if !matches!(parameter.kind, ParameterKind::Inertial(_)) {
            bare[at] = 0.0;
        }
    }
    // With qd = 0, qdd = the speeds and no gravity, inverse dynamics is M qd.
    let still = Motion::from_fn(n, motion.samples(), |j, s| {
        let [q, qd, _] = motion.get(j, s);
        [q, 0.0, qd]
    });
    let weightless = robot.with_gravity(nalgebra::Vector3::zeros());
    let momentum = inverse_dynamics_batch(&Chain::new(&weightless), layout, &bare, &still, Coulomb::Sign);
    let energy = |s: usize| {
        (0..n)
            .map(|j| momentum[j * motion.stride() + s] * motion.get(j, s)[1])
            .sum::<f64>()
    };
    let (sum, size) = (0..motion.samples())
        .map(energy)
        .fold((0.0, 0.0), |(a, b), e: f64| (a + e, b + e.abs()));
    if size > 0.0 { sum / size } else { 0.0 }
}
