//! Limits along the path: what of them is used, and what exceeds them as a part of the criterion.

use super::Evaluator;
use crate::dynamics::Coulomb;

impl Evaluator<'_> {
    /// Largest torque of every joint over what it is allowed, at the samples of `x` with the true sign; none without torque
    /// limits.
    fn torque_used(&mut self, x: &[f64]) -> Vec<f64> {
        self.set_motion(&self.variables.project(x).coefficients);
        let Some(limits) = self.problem.torque() else {
            return Vec::new();
        };
        let (mut torque, mut used) = (Vec::new(), vec![0.0f64; self.columns.joints()]);
        for index in 0..self.block.count() {
            self.block
                .fill(index, self.problem.chain(), &self.columns, &self.motion, Coulomb::Sign);
            for (j, used) in used.iter_mut().enumerate() {
                self.torque_of(j, &limits.base, &mut torque);
                let most = torque.iter().fold(0.0f64, |most, t| most.max(t.abs()));
                *used = used.max(most / limits.allowed[j]);
            }
        }
        used
    }

    /// Whether all limits along the path hold at the samples, with the true sign; `room` of each limit is left for rounding.
    pub fn path_holds(&mut self, x: &[f64], room: f64) -> bool {
        let torques = self.torque_used(x);
        let (robot, motion) = (self.problem.robot(), &self.motion);
        torques.iter().all(|used| *used <= 1.0 - room) && self.problem.space().is_none_or(|set| set.holds(robot, motion, room))
    }

    /// Adds what comes too near in space to the gradient, and returns its part of the criterion.
    pub(super) fn add_intrusion(&mut self, penalty: f64) -> f64 {
        let Some(set) = self.problem.space() else { return 0.0 };
        set.add_excess(self.problem.robot(), &self.motion, penalty, &mut self.gradient.q)
    }

    /// `τ_j = Y_b,j π` over the samples of the filled block.
    fn torque_of(&self, joint: usize, base: &[f64], torque: &mut Vec<f64>) {
        let (stride, samples) = (self.block.stride(), self.block.samples());
        torque.clear();
        torque.resize(samples, 0.0);
        for (c, &column) in self.columns.row(joint).iter().enumerate() {
            let values = &self.block.rows.block(joint)[c * stride..c * stride + samples];
            torque.iter_mut().zip(values).for_each(|(t, y)| *t += y * base[column]);
        }
    }

    /// Adds the filled block's part of `penalty · mean over samples of Σ_j max(0, |τ_j|/allowed_j − 1)²`: its derivative by Y to
    /// the weights, its value to the criterion.
    pub(super) fn add_torque_excess(&mut self, penalty: f64) -> f64 {
        let Some(limits) = self.problem.torque() else { return 0.0 };
        let (stride, samples) = (self.block.stride(), self.block.samples());
        let (mut torque, mut total) = (Vec::new(), 0.0);
        let share = penalty / self.motion.samples() as f64;
        for j in 0..self.columns.joints() {
            self.torque_of(j, &limits.base, &mut torque);
            let allowed = limits.allowed[j];
            for t in torque.iter_mut() {
                let excess = (t.abs() / allowed - 1.0).max(0.0);
                total += share * excess * excess;
                *t = share * 2.0 * excess * t.signum() / allowed;
            }
            for (c, &column) in self.columns.row(j).iter().enumerate() {
                let weights = &mut self.block.weights.block_mut(j)[c * stride..c * stride + samples];
                weights
                    .iter_mut()
                    .zip(&torque)
                    .for_each(|(w, t)| *w += t * limits.base[column]);
            }
        }
        total
    }
}
