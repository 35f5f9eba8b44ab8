//! Gauss-Newton fits of an augmented model: what they gain, what they leave on every joint, and how much is known after them.

use super::ar_noise::{NoiseModel, NoiseSource};
use super::model::AugmentedModel;
use super::normal_equations::{Block, Data, System};
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

impl Data<'_> {
    /// Gauss-Newton from `model` until a step takes less than `settled_to_report` (or `settled_to_compare`) off the sum of
    /// squares, or makes the fit worse however short it is.
    pub fn fit(&self, model: AugmentedModel) -> System {
        let mut here = self.linearise(model);
        let mut cost = self.cost(&here);
        let rows = self.all_rows(&here) as f64;
        let enough = match self.compared {
            true => SETTINGS.settled_to_compare,
            false => SETTINGS.settled_to_report,
        };
        for _ in 0..SETTINGS.gauss_newton_steps {
            let step = &here.covariance * &here.gradient;
            let decrease = here.gradient.dot(&step);
            let linear = here.model.terms.is_empty();
            if decrease < enough && !linear {
                break;
            }
            let Some((there, lower)) = self.shortened(&here, &step, cost) else {
                break;
            };
            let settled = (cost - lower).abs() < (1e-7 * cost).max(enough / rows);
            (here, cost) = (there, lower);
            if settled || linear && decrease < 1.0 {
                break;
            }
        }
        here
    }

    /// The fit after `step`, or after the largest of its halves that does not make it worse, and its cost. `None` where a
    /// sixteenth does: the derivatives of a distortion are differences over steps in which friction reverses, and near the least
    /// cost they point elsewhere. A linear model takes every step.
    fn shortened(&self, here: &System, step: &DVector<f64>, cost: f64) -> Option<(System, f64)> {
        let linear = here.model.terms.is_empty();
        (0..SETTINGS.step_halvings + 1).find_map(|k| {
            let there = self.linearise(here.model.moved(&(step * 0.5f64.powi(k))));
            let lower = self.cost(&there);
            // Rows at reversals come and go with a distortion; their share of the sum is not a worse fit.
            (linear || lower <= cost * (1.0 + 1e-9)).then_some((there, lower))
        })
    }

    /// What a fit knows of its parameters, as an inverse covariance: the normal matrix with the prior's part, the rows of a joint
    /// that keeps more than noise counted for as much less as they leave and go together.
    pub fn known(&self, system: &System) -> DMatrix<f64> {
        let p = system.covariance.nrows();
        let doubts = self.doubts(system);
        let blocks = system.blocks.iter().flat_map(|b| b.iter().zip(&doubts));
        let mut normal = blocks
            .map(|(block, doubt)| &block.normal / *doubt)
            .fold(DMatrix::zeros(p, p), |a, b| a + b);
        if let Some(prior) = self.prior {
            let k = prior.mean.len();
            let mut corner = normal.view_mut((0, 0), (k, k));
            corner += &prior.information;
        }
        normal
    }

    /// By how much less the rows of every joint count: as much as they keep more than noise and go together. 1 for a joint that
    /// keeps nothing, or has no rows: nothing makes rows count for more.
    pub fn doubts(&self, system: &System) -> Vec<f64> {
        let doubt = |j: usize| match system.has_misfit(&[j]) {
            true => (system.mean_square(&[j]) * system.persistence(&[j])).max(1.0),
            false => 1.0,
        };
        (0..self.noise.len()).map(doubt).collect()
    }

    /// Mean square of the whitened residuals plus the prior's share.
    fn cost(&self, system: &System) -> f64 {
        self.chi_square(system) / self.all_rows(system) as f64
    }

    /// Rows of all joints; 1 where there are none.
    fn all_rows(&self, system: &System) -> usize {
        (0..self.noise.len()).map(|j| system.rows(j)).sum::<usize>().max(1)
    }

    /// Sum of squares of the whitened residuals, and of the distance to the prior.
    pub fn chi_square(&self, system: &System) -> f64 {
        let joints: f64 = (0..self.noise.len()).map(|j| system.joint_chi_square(j)).sum();
        joints + self.distance(system)
    }

    /// Squared distance to the prior.
    fn distance(&self, system: &System) -> f64 {
        self.prior.map_or(0.0, |prior| {
            let off = &prior.mean - system.model.vector().rows(0, prior.mean.len());
            (off.transpose() * &prior.information * off)[0]
        })
    }

    /// How much less `after` leaves than `before`, on the rows that both have: a distortion moves reversals, and the rows left
    /// out there are no gain.
    pub fn gain(&self, before: &System, after: &System) -> f64 {
        let pairs = before.blocks.iter().flatten().zip(after.blocks.iter().flatten());
        let rows: f64 = pairs
            .map(|(b, a)| {
                let both = b.rows.iter().zip(&a.rows).map(|(x, y)| *x && *y);
                let values = b.residual.iter().zip(&a.residual);
                values
                    .zip(both)
                    .filter(|(_, both)| *both)
                    .map(|((b, a), _)| b * b - a * a)
                    .sum::<f64>()
            })
            .sum();
        rows + self.distance(before) - self.distance(after)
    }

    /// White noise of the size of what a fit leaves on every joint. How far the rows go together is weighed effect by effect, or
    /// slow effects would pass for noise.
    pub fn left_as_noise(&self, system: &System) -> Vec<NoiseModel> {
        let of = |(j, noise): (usize, &NoiseModel)| {
            if system.rows(j) == 0 {
                return NoiseModel::absent(NoiseSource::Residual);
            }
            let freedom = (system.rows(j) as f64 - system.spent(j)).max(1.0);
            // A fit without residual is one of simulated data: rounding of the torque is all the noise there is.
            let recorded = self.stretches.iter().map(|s| s.resolution[j]).fold(0.0, f64::max);
            let least = recorded.max(f64::MIN_POSITIVE.sqrt());
            let std_dev = (noise.innovation * (system.joint_chi_square(j) / freedom).sqrt()).max(least);
            NoiseModel {
                source: NoiseSource::Residual,
                std_dev,
                autoregression: Vec::new(),
                innovation: std_dev,
                degrees_of_freedom: freedom,
            }
        };
        self.noise.iter().enumerate().map(of).collect()
    }
}

/// Rows over which whitened residuals keep their sign: mean square of sums over runs of rows, relative to white noise.
pub(crate) fn persistence<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut together, mut alone) = (0.0, 0.0);
    for r in residuals {
        for run in r.chunks((r.len() / SETTINGS.persistence_runs).max(1)) {
            together += run.iter().sum::<f64>().powi(2);
            alone += run.iter().map(|v| v * v).sum::<f64>();
        }
    }
    if alone > 0.0 { (together / alone).max(1.0) } else { 1.0 }
}

impl System {
    /// Sum of squares of the whitened residuals of one joint.
    pub fn joint_chi_square(&self, joint: usize) -> f64 {
        self.blocks.iter().map(|b| b[joint].residual.norm_squared()).sum()
    }

    /// Rows of one joint.
    pub fn rows(&self, joint: usize) -> usize {
        self.blocks.iter().map(|b| b[joint].rows.iter().filter(|r| **r).count()).sum()
    }

    /// Rows over which the residual of these joints keeps its sign: mean square of sums over runs of rows, relative to white
    /// noise.
    pub fn persistence(&self, joints: &[usize]) -> f64 {
        let rows = self
            .blocks
            .iter()
            .flat_map(|blocks| joints.iter().map(|&j| blocks[j].residual.as_slice()));
        persistence(rows)
    }

    /// Degrees of freedom that the fit has spent on the rows of one joint: the trace of its part of the hat matrix.
    pub fn spent(&self, joint: usize) -> f64 {
        let trace = |b: &Block| (&b.jacobian * &self.covariance).component_mul(&b.jacobian).sum();
        self.blocks.iter().map(|b| trace(&b[joint])).sum()
    }

    /// Covariance of term `at`.
    pub fn term_covariance(&self, at: usize) -> DMatrix<f64> {
        let (from, k) = (self.model.offset_of(at), self.model.terms[at].parameters());
        self.covariance.view((from, from), (k, k)).into_owned()
    }
}
