//! The estimate that is handed out: base parameters and effects of one model, fitted together, with what is known of them.
//!
//! Generalised least squares on the rows that the diagnosis works on: whitened by the noise between periods where that is
//! measured, by the size of what the model leaves where it is not. Deviations are those of the noise where it accounts for the
//! residual, and of the jackknife over blocks of time where more than noise is left.

use super::ar_noise::{NoiseModel, NoiseSource};
use super::block_jackknife::jackknife_covariance;
use super::dataset::Stretch;
use super::errors::raw_residual;
use super::huber::robust_system;
use super::joint_normal::JointNormal;
use super::model::AugmentedModel;
use super::noise_floor::floor;
use super::normal_equations::{Data, System};
use super::rank::pseudo_inverse;
use super::solution::Solution;
use crate::model::Robot;
use crate::parameters::BaseParameters;
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

/// How rows weigh against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// Every row the same, the paper's (9).
    Ordinary,
    /// Rows of joint j by `1/σⱼ²`, σⱼ from the residual, iterated.
    #[default]
    Weighted,
    /// Weighted with σⱼ from the median residual, and rows whose residual is beyond 1.345 σⱼ by `1.345 σⱼ/|e|` more (Huber): 95 %
    /// as good as least squares on normal noise, and a few gross errors do no harm.
    Robust,
}

/// What least squares says.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// p values, base parameters first; what is not [determined](Self::is_determined) has a value of least norm that only
    /// predictions of the same data may use.
    pub values: DVector<f64>,
    /// Covariance of the values, p × p, for noise that is correlated in time.
    pub covariance: DMatrix<f64>,
    /// Standard deviations by the paper's (15): `σ² (WᵀW)⁻¹`, every row counted as independent.
    pub textbook_std_dev: DVector<f64>,
    /// Fit of every joint.
    pub joints: Vec<JointFit>,
    /// Solution of the normal equations: rank, values and covariance of white noise.
    pub solution: Solution,
    /// Iterations of the weights.
    pub iterations: usize,
}

/// The fit of one joint's rows.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// Rows that count.
    pub rows: usize,
    /// Root mean square residual [N m or N].
    pub rms: f64,
    /// Rows less the parameters spent on them.
    pub degrees_of_freedom: f64,
    /// Independent values that the rows are worth, given the noise's correlation.
    pub effective_rows: f64,
    /// Standard deviation of a row's noise as measured by the scatter of the periods; `None` without periods.
    pub noise_std: Option<f64>,
    /// Residual mean square over what noise alone would leave; `None` without periods. Well above 1: the model lacks something.
    pub misfit: Option<f64>,
    /// Standard deviation that the rows were weighted with.
    pub sigma: f64,
    /// Standard deviation that recording has added to a torque: no error is known to be less [N m or N].
    pub resolution: f64,
}

impl Estimate {
    /// Infinite for a parameter that the data do not determine.
    pub fn std_dev(&self, c: usize) -> f64 {
        if self.is_determined(c) {
            self.covariance[(c, c)].max(0.0).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// The paper's σ: `100 std_dev/|value|`.
    pub fn relative_std_dev_percent(&self, c: usize) -> f64 {
        100.0 * self.std_dev(c) / self.values[c].abs()
    }

    /// Whether the data determine parameter `c`.
    pub fn is_determined(&self, c: usize) -> bool {
        self.solution.is_determined(c)
    }
}

/// A model with the estimate that it is made of.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// What the estimate is of: base parameters of the robot as described, or, with a tilt in the model, of any gravity.
    pub base: BaseParameters,
    /// The model at its estimate.
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
        let from = Reduction::from_model(&self.base, &self.model);
        let covariance = &self.estimate.covariance;
        let information = pseudo_inverse(covariance, SETTINGS.rank_tolerance);
        from.down.tr_mul(&(information * &from.down))
    }
}

/// How the base parameters of an augmented model, which are those of any gravity, and those that are reported follow from each
/// other; effects stay as they are.
pub(crate) struct Reduction {
    /// `θ_model = up θ_reported`.
    up: DMatrix<f64>,
    /// `θ_reported = down θ_model`.
    down: DMatrix<f64>,
}

impl Reduction {
    fn from_model(base: &BaseParameters, model: &AugmentedModel) -> Self {
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

/// Base parameters of `robot` as declared, from the rows of `stretches`, without a search for effects: the paper's (9) with
/// [`Estimator::Ordinary`], otherwise rows weighted by their noise.
///
/// # Panics
/// Without a stretch.
pub fn estimate(robot: &Robot, stretches: &[Stretch], estimator: Estimator) -> Fitted {
    let model = AugmentedModel::declared(robot);
    let data = Data::new(stretches, Vec::new(), None);
    let noise = floor(robot, &data, &model);
    estimated(&data.with_noise(noise), &model, estimator)
}

/// Fits `model` by `estimator` and says what is known of it.
pub(crate) fn estimated(data: &Data, model: &AugmentedModel, estimator: Estimator) -> Fitted {
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
pub(crate) fn fitted(data: &Data, system: &System) -> Fitted {
    let base = reported_base(&system.model);
    let reduction = Reduction::from_model(&base, &system.model);
    let at = system.model.vector();
    let normals: Vec<JointNormal> = (0..data.noise.len())
        .map(|j| joint_normal(data, system, j, &at, &reduction))
        .collect();
    let columns = reduction.up.ncols();
    let solution = Solution::new(&normals, columns);
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

/// Normal equations of the whitened rows of a joint, about zero: the rows `r + Jθ` are what is left to a model without
/// parameters.
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

/// Of the noise where it is measured and accounts for the residual of every joint; by the jackknife otherwise, with no deviation
/// below that of noise of the size that the rows were weighted with.
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
