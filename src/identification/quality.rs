//! Whether a log is good enough for the model.

use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use crate::preparation::PreparedLog;
use crate::regression::{Estimate, Explained};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// What the estimate's own covariance says about torques elsewhere in the workspace.
#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    /// Per joint: standard deviation of the predicted torque, root mean square over random states [N m or N]; infinite when an
    /// undetermined direction matters there.
    pub prediction_std: Vec<f64>,
    /// Per joint: the same over the residual on the log itself.
    pub extrapolation: Vec<f64>,
    /// Share of the torque that the model explains beyond a constant.
    pub explained: Explained,
    /// The judgement.
    pub verdict: QualityVerdict,
}

impl Quality {
    /// Joints whose predicted torque is less certain away from the recorded motion than it is exact on it, the worst first;
    /// joints without rows, of which nothing is known, come before all.
    pub fn poor_joints(&self) -> Vec<usize> {
        let mut poor: Vec<usize> = (0..self.extrapolation.len())
            .filter(|&j| self.extrapolation[j] > MOST_EXTRAPOLATION)
            .collect();
        poor.sort_by(|&a, &b| self.extrapolation[b].total_cmp(&self.extrapolation[a]));
        poor
    }
}

/// Whether a log is good enough to identify from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QualityVerdict {
    /// It is.
    Good,
    /// Away from the recorded motion the predicted torque is far less certain than on it.
    PoorExcitation,
    /// Some base parameters are not determined at all.
    Unidentifiable,
    /// The model explains no more of the torque than a constant per joint: it has nothing to do with the motion.
    ExplainsNothing,
    /// The data have a fault that nobody could put right: parameters are those of wrong data.
    DataFault,
}

impl QualityVerdict {
    /// Name in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::PoorExcitation => "poor_excitation",
            Self::Unidentifiable => "unidentifiable",
            Self::ExplainsNothing => "explains_nothing",
            Self::DataFault => "data_fault",
        }
    }
}

/// A model whose parameters alone make it err by more than it errs on its own log has learnt the path, not the robot.
const MOST_EXTRAPOLATION: f64 = 1.0;
/// The mean of 400 squares is known to 7 %.
const STATES: usize = 400;

/// Predicts torques with the base parameters of `estimate` at random states: positions anywhere within the limits (all the way
/// round, or as far as the logs went, where there are none), speeds and accelerations as large as in the logs.
///
/// `explained` is what [`Explained`] says of the same rows: a model of noise has no quality.
pub fn quality(
    robot: &Robot,
    base: &BaseParameters,
    logs: &[&PreparedLog],
    estimate: &Estimate,
    explained: Explained,
) -> Quality {
    let states = random_states(robot, logs);
    let columns = ColumnSet::new(robot, &Layout::standard(robot), &base.kept);
    let mut rows = RowBlocks::new(&columns, STATES);
    rows.fill(&Chain::new(robot), &columns, &states, Coulomb::Sign);
    let prediction_std: Vec<f64> = (0..robot.joint_count())
        .into_par_iter()
        .map(|j| prediction_std(&rows, &columns, j, estimate))
        .collect();
    let extrapolation: Vec<f64> = prediction_std
        .iter()
        .zip(&estimate.joints)
        .map(|(p, fit)| {
            if fit.rows > 0 {
                p / fit.rms.max(fit.resolution)
            } else {
                f64::INFINITY
            }
        })
        .collect();
    let tested = |j: &usize| estimate.joints[*j].rows > 0;
    let verdict = if !explained.is_more_than_a_constant() {
        QualityVerdict::ExplainsNothing
    } else if (0..base.len()).any(|c| !estimate.is_determined(c)) {
        QualityVerdict::Unidentifiable
    } else if (0..extrapolation.len())
        .filter(tested)
        .any(|j| extrapolation[j] > MOST_EXTRAPOLATION)
    {
        QualityVerdict::PoorExcitation
    } else {
        QualityVerdict::Good
    };
    Quality {
        prediction_std,
        extrapolation,
        explained,
        verdict,
    }
}

fn random_states(robot: &Robot, logs: &[&PreparedLog]) -> Motion {
    // A fixed seed: the same logs give the same answer.
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let largest = |j: usize, of: fn(&Motion, usize) -> &[f64]| {
        logs.iter()
            .flat_map(|l| of(&l.motion, j))
            .fold(0.0f64, |m, v| m.max(v.abs()))
            .max(f64::MIN_POSITIVE)
    };
    let travel = |j: usize| {
        let joint = &robot.joints()[j];
        match joint.limits.position {
            Some([low, high]) => [low, high],
            None if joint.is_revolute() => [-std::f64::consts::PI, std::f64::consts::PI],
            None => [-largest(j, Motion::positions), largest(j, Motion::positions)],
        }
    };
    let joints = 0..robot.joint_count();
    let reach: Vec<_> = joints
        .map(|j| (travel(j), largest(j, Motion::velocities), largest(j, Motion::accelerations)))
        .collect();
    Motion::from_fn(robot.joint_count(), STATES, |j, _| {
        let ([low, high], speed, acceleration) = reach[j];
        [
            rng.random_range(low..high),
            rng.random_range(-speed..speed),
            rng.random_range(-acceleration..acceleration),
        ]
    })
}

/// `sqrt(mean y C yᵀ)`, plus nothing finite when y reaches into a direction that is open.
fn prediction_std(rows: &RowBlocks, columns: &ColumnSet, j: usize, estimate: &Estimate) -> f64 {
    let own = columns.row(j);
    let mut sum = 0.0;
    for s in 0..rows.samples() {
        let y: Vec<f64> = rows.block(j).chunks_exact(rows.stride()).map(|c| c[s]).collect();
        for (a, &ca) in own.iter().enumerate() {
            for (b, &cb) in own.iter().enumerate() {
                sum += y[a] * estimate.covariance[(ca, cb)] * y[b];
            }
        }
        let length = y.iter().map(|v| v * v).sum::<f64>().sqrt();
        let open = estimate.solution.null_directions.iter().any(|null| {
            let divisor = |c: usize| {
                if estimate.solution.column_scale[c] > 0.0 {
                    estimate.solution.column_scale[c]
                } else {
                    1.0
                }
            };
            let direction: Vec<f64> = own.iter().map(|&c| null[c] / divisor(c)).collect();
            let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
            let along: f64 = direction.iter().zip(&y).map(|(d, v)| d * v).sum();
            along.abs() > 1e-6 * norm * length
        });
        if open {
            return f64::INFINITY;
        }
    }
    (sum / rows.samples() as f64).max(0.0).sqrt()
}
