//! Which sign of a fit is physical: friction takes energy out of a motion, kinetic energy is positive, and priors know their
//! sign.

use super::evidence::Evidence;
use super::order::{Projection, Sampled, root_mean_square};
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks, inverse_dynamics_batch};
use crate::parameters::{Layout, ParameterKind};
use nalgebra::DVector;

/// The sums over parameters that have a sign, for one motion.
pub(crate) struct Physics<'a> {
    sampled: &'a Sampled<'a>,
    projection: &'a Projection,
    /// Power that the friction of every joint takes out of the motion, per unit of every parameter.
    friction: Vec<DVector<f64>>,
    /// `Σ qdᵀ M qd` over the motion, per unit of every parameter.
    energy: DVector<f64>,
}

impl<'a> Physics<'a> {
    pub fn new(sampled: &'a Sampled<'a>, projection: &'a Projection) -> Self {
        let joints = sampled.robot.joint_count();
        Self {
            friction: (0..joints).map(|j| friction_power(sampled, &projection.kept, j)).collect(),
            energy: kinetic_energy(sampled, &projection.kept),
            sampled,
            projection,
        }
    }

    /// Sign of the power that the friction of joint j takes out, where there is enough of it and its sign is beyond chance; else
    /// 0.
    fn dissipates(&self, evidence: &Evidence, j: usize) -> f64 {
        let layout = Layout::standard(self.sampled.robot);
        let speeds = self.sampled.motion.velocities(j);
        let mut torque = vec![0.0; speeds.len()];
        for (&at, &value) in self.projection.kept.iter().zip(evidence.values.iter()) {
            let parameter = layout.parameters()[at];
            let unit: fn(f64) -> f64 = match parameter.kind {
                ParameterKind::Viscous => |v| v,
                ParameterKind::Coulomb => |v| if v == 0.0 { 0.0 } else { v.signum() },
                ParameterKind::Inertial(_) => continue,
            };
            if parameter.link == j {
                torque.iter_mut().zip(speeds).for_each(|(t, &v)| *t += value * unit(v));
            }
        }
        match root_mean_square(&torque) < SETTINGS.data_quality.least_friction * root_mean_square(&self.sampled.torque[j]) {
            true => 0.0,
            false => evidence.sign(&self.friction[j]),
        }
    }

    /// A joint whose parameters are mostly its own fits nearly as well with its torque turned; but its friction then drives. Such
    /// a joint is turned where friction says so against the other joints' and the fit hardly gets worse. What would call the
    /// joint's own sign wrong is not believed against friction, however well it fits. Where the turned column leaves clearly
    /// less, the misfit of the column as recorded hides the sign of its friction, and the turned fit decides: what the model
    /// lacks passes for friction only where both fit alike, so that friction need not be large then.
    pub fn dissipating(&self, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let mut signs = signs.to_vec();
        let joints = signs.len();
        let powers = |evidence: &Evidence| -> Vec<f64> { (0..joints).map(|j| self.dissipates(evidence, j)).collect() };
        let mut evidence = Evidence::of(self.projection, order, &signs);
        let mut power = powers(&evidence);
        let majority = if power.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        for j in 0..joints {
            let mut turned = signs.clone();
            turned[j] = -turned[j];
            let [rest, rest_turned] = [&signs, &turned].map(|s| self.projection.rest(order, s));
            let clearly = rest > SETTINGS.data_quality.order_gain * rest_turned;
            let drives = if clearly {
                evidence.ratio(&self.friction[j])
            } else {
                power[j]
            } * majority
                < 0.0;
            if !drives {
                continue;
            }
            let then = Evidence::of(self.projection, order, &turned);
            let power_then = powers(&then);
            let brakes = if clearly {
                then.sign(&self.friction[j])
            } else {
                power_then[j]
            } * majority
                > 0.0;
            let claimed = signs[j] * majority < 0.0;
            if brakes && (claimed || rest_turned < SETTINGS.data_quality.sign_gain * rest) {
                (signs, power, evidence) = (turned, power_then, then);
            }
        }
        signs
    }

    /// Least squares fits all signs turned at once just as well: friction that would drive, inertia below zero, or a prior that
    /// says the opposite decide, where they are beyond chance.
    pub fn global_sign(&self, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let vote = self.physical_sign(&Evidence::of(self.projection, order, signs));
        signs.iter().map(|s| s * vote).collect()
    }

    /// +1 or −1.
    fn physical_sign(&self, evidence: &Evidence) -> f64 {
        if let Some(sign) = self.prior_sign(evidence) {
            return sign;
        }
        let total: DVector<f64> = self.friction.iter().fold(DVector::zeros(self.energy.len()), |a, b| a + b);
        let substantial = (0..self.friction.len()).any(|j| self.dissipates(evidence, j) != 0.0);
        let friction = if substantial {
            evidence.sign(&total) * evidence.ratio(&total).abs()
        } else {
            0.0
        };
        let inertia = evidence.sign(&self.energy) * evidence.ratio(&self.energy).abs();
        if friction + inertia < 0.0 { -1.0 } else { 1.0 }
    }

    /// The sign that makes the fit agree with the links' prior parameters, where they correlate.
    fn prior_sign(&self, evidence: &Evidence) -> Option<f64> {
        let (robot, motion) = (self.sampled.robot, &self.sampled.motion);
        let layout = Layout::standard(robot);
        let prior = layout.prior(robot)?;
        let torque = inverse_dynamics_batch(&Chain::new(robot), &layout, prior.as_slice(), motion, Coulomb::Sign);
        let at = |a: usize, s: usize| torque[a * motion.stride() + s];
        let along = self.projection.along(at);
        let [own, other] = self.projection.sizes(&evidence.values, at);
        let dot: f64 = along.dot(&evidence.values);
        (dot.abs() > SETTINGS.data_quality.sign_correlation * (own * other).sqrt())
            .then(|| evidence.sign(&along))
            .filter(|s| *s != 0.0)
    }
}

fn friction_power(sampled: &Sampled, kept: &[usize], joint: usize) -> DVector<f64> {
    let layout = Layout::standard(sampled.robot);
    let speeds = sampled.motion.velocities(joint);
    let of = |i: usize| {
        let parameter = layout.parameters()[kept[i]];
        match parameter.kind {
            _ if parameter.link != joint => 0.0,
            ParameterKind::Viscous => speeds.iter().map(|v| v * v).sum(),
            ParameterKind::Coulomb => speeds.iter().map(|v| v.abs()).sum(),
            ParameterKind::Inertial(_) => 0.0,
        }
    };
    DVector::from_fn(kept.len(), |i, _| of(i))
}

/// With qd = 0, qdd = the speeds and no gravity, inverse dynamics is M qd.
fn kinetic_energy(sampled: &Sampled, kept: &[usize]) -> DVector<f64> {
    let (robot, motion) = (sampled.robot, &sampled.motion);
    let moved = Motion::from_fn(motion.joints(), motion.samples(), |j, s| {
        let [q, qd, _] = motion.get(j, s);
        [q, 0.0, qd]
    });
    let weightless = robot.with_gravity(nalgebra::Vector3::zeros());
    let set = ColumnSet::new(&weightless, &Layout::standard(robot), kept);
    let mut rows = RowBlocks::new(&set, motion.samples());
    rows.fill(&Chain::new(&weightless), &set, &moved, Coulomb::Sign);
    let mut energy = DVector::zeros(kept.len());
    for j in 0..motion.joints() {
        for (values, &at) in rows.block(j).chunks_exact(rows.stride()).zip(set.row(j)) {
            energy[at] += values.iter().zip(motion.velocities(j)).map(|(m, v)| m * v).sum::<f64>();
        }
    }
    energy
}
