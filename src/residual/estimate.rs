//! The estimate that is handed out: base parameters and effects of one model, fitted together, with what is known of them.
//!
//! Generalised least squares on the rows that the diagnosis works on: whitened by the noise between periods where that is measured, by the size of what
//! the model leaves where it is not. Deviations are those of the noise where it accounts for the residual, and of the jackknife over blocks of time
//! where more than noise is left.

use super::jackknife::jackknife_covariance;
use super::misfit::raw_residual;
use super::robust::robust_system;
use super::system::{Data, System};
use super::{AugmentedModel, NoiseModel, NoiseSource};
use crate::identification::{Estimate, Estimator, JointFit, JointNormal, Solution};
use crate::parameters::BaseParameters;
use nalgebra::{DMatrix, DVector};

/// A model with the estimate that it is made of.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// What the estimate is of: base parameters of the robot as described, or, with a tilt in the model, of any gravity.
    pub base: BaseParameters,
    pub model: AugmentedModel,
    /// Base parameters, then per effect its coefficients and free shapes.
    pub estimate: Estimate,
    /// Of the whitened rows, over all columns of the estimate.
    pub normals: Vec<JointNormal>,
}

impl Fitted {
    /// Place of term `at` among the values of the estimate.
    pub fn term_range(&self, at: usize) -> std::ops::Range<usize> {
        let first = self.base.len() + self.model.offset_of(at) - self.model.values.len();
        first..first + self.model.terms[at].parameters()
    }

    /// Covariance of the parameters of term `at`.
    pub fn term_covariance(&self, at: usize) -> DMatrix<f64> {
        let range = self.term_range(at);
        self.estimate
            .covariance
            .view((range.start, range.start), (range.len(), range.len()))
            .into_owned()
    }

    /// Inverse covariance of [`AugmentedModel::vector`]; zero along what the data leave open.
    pub fn information(&self) -> DMatrix<f64> {
        let from = Reduction::of(&self.base, &self.model);
        let covariance = &self.estimate.covariance;
        let information = super::projection::pseudo_inverse(covariance, super::projection::RANK);
        from.down.tr_mul(&(information * &from.down))
    }
}

/// How the base parameters of an augmented model, which are those of any gravity, and those that are reported follow from each other; effects stay as they are.
pub(super) struct Reduction {
    /// `θ_model = up θ_reported`.
    up: DMatrix<f64>,
    /// `θ_reported = down θ_model`.
    down: DMatrix<f64>,
}

impl Reduction {
    fn of(base: &BaseParameters, model: &AugmentedModel) -> Self {
        let all = model.values.len();
        let effects = model.parameters() - all;
        let bordered = |corner: DMatrix<f64>| {
            let (rows, columns) = corner.shape();
            let mut whole = DMatrix::zeros(rows + effects, columns + effects);
            whole.view_mut((0, 0), (rows, columns)).copy_from(&corner);
            (0..effects).for_each(|e| whole[(rows + e, columns + e)] = 1.0);
            whole
        };
        Self {
            up: bordered(model.base.map.select_columns(&base.kept)),
            down: bordered(base.map.select_columns(&model.base.kept)),
        }
    }
}

/// What is reported of a model: base parameters of the robot as described, unless an effect turns gravity.
fn reported_base(model: &AugmentedModel) -> BaseParameters {
    match model.terms.iter().any(|t| t.effect.turns_gravity()) {
        true => model.base.clone(),
        false => BaseParameters::exact(&model.robot),
    }
}

/// Fits `model` by `estimator` and says what is known of it.
pub(super) fn estimated(data: &Data, model: &AugmentedModel, estimator: Estimator) -> Fitted {
    match estimator {
        Estimator::Weighted => fitted(data, &data.fit(model.clone())),
        Estimator::Ordinary => {
            let alike = data.with_noise(alike_noise(data, model));
            fitted(&alike, &alike.fit(model.clone()))
        }
        Estimator::Robust => {
            let (weighted, system) = robust_system(data, model);
            fitted(&weighted, &system)
        }
    }
}

/// The same white noise on every joint, of the size of what ordinary least squares leaves.
fn alike_noise(data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let white = |std_dev: f64| vec![NoiseModel::white(std_dev); data.noise.len()];
    let unit = data.with_noise(white(1.0));
    let system = unit.fit(model.clone());
    let rows: usize = (0..data.noise.len()).map(|j| system.rows(j)).sum();
    let freedom = (rows as f64 - system.covariance.nrows() as f64).max(1.0);
    white((unit.chi_square(&system) / freedom).sqrt().max(f64::MIN_POSITIVE.sqrt()))
}

/// The estimate of a system that has been fitted.
pub(super) fn fitted(data: &Data, system: &System) -> Fitted {
    let base = reported_base(&system.model);
    let reduction = Reduction::of(&base, &system.model);
    let at = system.model.vector();
    let normals: Vec<JointNormal> = (0..data.noise.len())
        .map(|j| joint_normal(data, system, j, &at, &reduction))
        .collect();
    let columns = reduction.up.ncols();
    let solution = Solution::new(&normals, &vec![1.0; normals.len()], columns);
    let values = solution.values.clone();
    let model = system.model.moved(&(&reduction.up * &values - &at));
    let joints: Vec<JointFit> = (0..normals.len()).map(|j| joint_fit(data, system, j)).collect();
    let covariance = covariance(data, system, &reduction, &solution);
    let textbook_std_dev = textbook(&normals, &solution);
    Fitted {
        base,
        model,
        estimate: Estimate {
            values,
            covariance,
            textbook_std_dev,
            joints,
            solution,
            iterations: 1,
        },
        normals,
    }
}

/// Normal equations of the whitened rows of a joint, about zero: the rows `r + Jθ` are what is left to a model without parameters.
fn joint_normal(data: &Data, system: &System, joint: usize, at: &DVector<f64>, reduction: &Reduction) -> JointNormal {
    let p = at.len();
    let (mut gram, mut gradient, mut square) = (DMatrix::zeros(p, p), DVector::zeros(p), 0.0);
    for block in system.blocks.iter().map(|b| &b[joint]) {
        gram += &block.normal;
        gradient += block.jacobian.tr_mul(&block.residual);
        square += (&block.residual + &block.jacobian * at).norm_squared();
    }
    let moment = gradient + &gram * at;
    JointNormal {
        columns: (0..reduction.up.ncols()).collect(),
        gram: reduction.up.tr_mul(&(gram * &reduction.up)),
        moment: reduction.up.tr_mul(&moment),
        torque_square: square,
        rows: system.rows(joint),
        resolution: resolution(data, joint),
    }
}

/// Standard deviation that recording has added to a torque, of the coarsest log [N·m or N].
fn resolution(data: &Data, joint: usize) -> f64 {
    data.stretches.iter().map(|s| s.resolution[joint]).fold(0.0, f64::max)
}

fn joint_fit(data: &Data, system: &System, joint: usize) -> JointFit {
    let noise = &data.noise[joint];
    let rows = system.rows(joint);
    let degrees_of_freedom = (rows as f64 - system.spent(joint)).max(1.0);
    let (sum, count, repetitions) = raw_residual(data, system, joint);
    let measured = noise.source == NoiseSource::Periods && !noise.is_absent();
    JointFit {
        rows,
        rms: (sum / count.max(1.0)).sqrt(),
        degrees_of_freedom,
        effective_rows: system.effective_rows(joint),
        noise_std: measured.then(|| noise.std_dev / repetitions.sqrt()),
        misfit: measured.then(|| system.joint_chi_square(joint) / degrees_of_freedom),
        sigma: noise.innovation / repetitions.sqrt(),
        resolution: resolution(data, joint),
    }
}

/// Of the noise where it is measured and accounts for the residual of every joint; by the jackknife otherwise, with no deviation below that of noise of the
/// size that the rows were weighted with.
fn covariance(data: &Data, system: &System, reduction: &Reduction, solution: &Solution) -> DMatrix<f64> {
    let joints: Vec<usize> = (0..data.noise.len()).collect();
    let by_noise = solution.inverse.clone();
    if !joints.iter().any(|&j| system.has_misfit(&[j])) {
        return by_noise;
    }
    let spread = &reduction.down * jackknife_covariance(data, system) * reduction.down.transpose();
    let grow = DVector::from_fn(spread.nrows(), |i, _| {
        (by_noise[(i, i)] / spread[(i, i)].max(f64::MIN_POSITIVE)).max(1.0).sqrt()
    });
    DMatrix::from_fn(spread.nrows(), spread.ncols(), |r, c| spread[(r, c)] * grow[r] * grow[c])
}

/// The paper's (15): every row counted as independent.
fn textbook(normals: &[JointNormal], solution: &Solution) -> DVector<f64> {
    let square: f64 = normals.iter().map(|n| n.residual_square(&solution.values)).sum();
    let rows: usize = normals.iter().map(|n| n.rows).sum();
    let variance = square / (rows as f64 - solution.rank as f64).max(1.0);
    solution.inverse.diagonal().map(|v| (v.max(0.0) * variance).sqrt())
}
