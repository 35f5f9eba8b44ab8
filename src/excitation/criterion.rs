//! Criteria as functions of the Gram matrix `M = Y_bᵀ Y_b`, with derivatives.

use super::eigen::symmetric_eigen;
use super::problem::Criterion;
use super::rivals::Rivals;
use nalgebra::{DMatrix, DVector};

/// A criterion made differentiable, as the logarithm of what is reported.
#[derive(Debug, Clone)]
pub(super) enum SmoothCriterion<'a> {
    /// `1/(2p) [ln Σ λ^p + ln Σ λ^−p]`: approaches `ln cond(Y_b)` from above as p grows. Where extreme singular values meet, the
    /// condition number has a kink, and this has none.
    ConditionNumber { power: f64 },
    /// The same of `S = D^−½ M D^−½`, D the diagonal of M.
    ScaledConditionNumber { power: f64 },
    /// `−1/(2b) ln det M`
    DOptimality,
    /// `½ ln (tr(M⁻¹)/b)`
    AOptimality,
    /// `½ ln (tr(M⁻¹ C)/n)`
    IOptimality { workspace: &'a DMatrix<f64>, joints: usize },
    /// `−½ ln` of a soft minimum (power p) of the expected evidence in both directions.
    RivalEvidence { rivals: &'a Rivals, base: usize, power: f64 },
}

impl SmoothCriterion<'_> {
    /// Value, and the symmetric G with `dF = tr(G dM)`.
    /// A matrix that is not finite has an infinite value: decompositions would not end on it.
    pub fn evaluate(&self, gram: DMatrix<f64>) -> (f64, DMatrix<f64>) {
        if !is_finite(&gram) {
            return (f64::INFINITY, DMatrix::zeros(gram.nrows(), gram.ncols()));
        }
        if let Self::ScaledConditionNumber { power } = *self {
            return through_scaling(gram, |scaled| Self::ConditionNumber { power }.evaluate(scaled));
        }
        if let Self::RivalEvidence { rivals, base, power } = *self {
            return rivals.smooth(&gram, base, power);
        }
        let (eigenvalues, eigenvectors) = symmetric_eigen(gram);
        let size = eigenvalues.len() as f64;
        // Rounding can push the eigenvalues of a singular M below zero; the floor keeps logarithms finite and the search moving.
        let floor = eigenvalues.max() * f64::EPSILON;
        let lambda = eigenvalues.map(|v| v.max(floor));
        match self {
            Self::ConditionNumber { power } | Self::ScaledConditionNumber { power } => {
                let (value, slopes) = smoothed_log_condition(&lambda, *power);
                (value, scaled_gram(&eigenvectors, &slopes))
            }
            Self::DOptimality => {
                let value = -lambda.map(f64::ln).sum() / (2.0 * size);
                (value, scaled_gram(&eigenvectors, &lambda.map(|v| -0.5 / (size * v))))
            }
            Self::AOptimality => {
                let trace: f64 = lambda.map(|v| 1.0 / v).sum();
                let slopes = lambda.map(|v| -0.5 / (trace * v * v));
                (0.5 * (trace / size).ln(), scaled_gram(&eigenvectors, &slopes))
            }
            Self::IOptimality { workspace, joints } => {
                let inverse = scaled_gram(&eigenvectors, &lambda.map(|v| 1.0 / v));
                let product = &inverse * *workspace;
                let trace = product.trace();
                let gradient = (&product * &inverse) * (-0.5 / trace);
                let symmetric = (&gradient + gradient.transpose()) * 0.5;
                (0.5 * (trace / *joints as f64).ln(), symmetric)
            }
            Self::RivalEvidence { .. } => unreachable!("needs no eigenvalues"),
        }
    }
}

/// The logarithm of the criterion itself, nothing smoothed.
pub(super) fn true_log_value(criterion: &SmoothCriterion, gram: DMatrix<f64>) -> f64 {
    if !is_finite(&gram) {
        return f64::INFINITY;
    }
    match criterion {
        SmoothCriterion::ScaledConditionNumber { power } => {
            let roots = scaling(&gram);
            true_log_value(&SmoothCriterion::ConditionNumber { power: *power }, scaled_by(gram, &roots))
        }
        SmoothCriterion::ConditionNumber { .. } => {
            let lambda = gram.symmetric_eigenvalues();
            0.5 * (lambda.max() / lambda.min().max(lambda.max() * f64::EPSILON)).ln()
        }
        SmoothCriterion::RivalEvidence { rivals, base, .. } => rivals.true_log_value(&gram, *base),
        smooth => smooth.evaluate(gram).0,
    }
}

pub(super) fn is_finite(matrix: &DMatrix<f64>) -> bool {
    matrix.iter().all(|v| v.is_finite())
}

/// Value and derivative by every eigenvalue, with the extreme eigenvalues factored out so that no power overflows.
fn smoothed_log_condition(lambda: &DVector<f64>, power: f64) -> (f64, DVector<f64>) {
    let (low, high) = (lambda.min(), lambda.max());
    let up = lambda.map(|v| (v / high).powf(power));
    let down = lambda.map(|v| (low / v).powf(power));
    let (sum_up, sum_down) = (up.sum(), down.sum());
    let value = 0.5 * (high / low).ln() + (sum_up.ln() + sum_down.ln()) / (2.0 * power);
    let slopes = DVector::from_fn(lambda.len(), |i, _| 0.5 * (up[i] / sum_up - down[i] / sum_down) / lambda[i]);
    (value, slopes)
}

/// `D^−½`; a column that is zero stays so.
fn scaling(gram: &DMatrix<f64>) -> DVector<f64> {
    gram.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt())
}

fn scaled_by(mut gram: DMatrix<f64>, roots: &DVector<f64>) -> DMatrix<f64> {
    for (c, mut column) in gram.column_iter_mut().enumerate() {
        column.component_mul_assign(&(roots * roots[c]));
    }
    gram
}

/// A function F of `S = D^−½ M D^−½` with its derivative G, as one of M: `dF = tr(H dM)` with
/// `H = D^−½ G D^−½ − diag(Σ_j G_ij S_ij / M_ii)`.
fn through_scaling(gram: DMatrix<f64>, f: impl FnOnce(DMatrix<f64>) -> (f64, DMatrix<f64>)) -> (f64, DMatrix<f64>) {
    let roots = scaling(&gram);
    let scaled = scaled_by(gram, &roots);
    let (value, slope) = f(scaled.clone());
    let lost = DVector::from_fn(roots.len(), |i, _| {
        slope.column(i).dot(&scaled.column(i)) * roots[i] * roots[i]
    });
    let mut back = scaled_by(slope, &roots);
    for i in 0..lost.len() {
        back[(i, i)] -= lost[i];
    }
    (value, back)
}

/// `V diag(d) Vᵀ`, without the d that are lost beside the largest in rounding: of the sharp condition number all but a few.
fn scaled_gram(v: &DMatrix<f64>, d: &DVector<f64>) -> DMatrix<f64> {
    let least = d.amax() * f64::EPSILON / d.len() as f64;
    let seen: Vec<usize> = (0..d.len()).filter(|&i| d[i].abs() > least).collect();
    let kept = v.select_columns(&seen);
    let mut scaled = kept.clone();
    for (mut column, &i) in scaled.column_iter_mut().zip(&seen) {
        column *= d[i];
    }
    scaled * kept.transpose()
}

/// Every criterion of one design, none smoothed. The optimality criteria are in units of torque noise: with the noise given per
/// joint they are standard deviations to expect from one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criteria {
    /// Condition number of the observation matrix of the base parameters.
    pub condition_number: f64,
    /// Condition number after scaling every column of Y_b to length one: what remains when units are chosen freely.
    pub scaled_condition_number: f64,
    /// `det(M)^(−1/(2b))`
    pub d_optimality: f64,
    /// `sqrt(tr(M⁻¹)/b)`
    pub a_optimality: f64,
    /// `sqrt(tr(M⁻¹ C)/n)`
    pub i_optimality: f64,
    /// Least expected BIC difference between two rivals, where there are two: the larger the better.
    pub rival_evidence: Option<f64>,
}

impl Criteria {
    /// From the observation matrix Y_b (rows × b), the same with every row over its joint's noise, and the mean of `Y_bᵀ Y_b`
    /// over the workspace; by singular values of the triangular factor.
    pub fn from_regressor(y_b: &DMatrix<f64>, whitened: &DMatrix<f64>, workspace: &DMatrix<f64>, joints: usize) -> Self {
        if ![y_b, whitened, workspace].into_iter().all(is_finite) {
            return Self {
                condition_number: f64::INFINITY,
                scaled_condition_number: f64::INFINITY,
                d_optimality: f64::INFINITY,
                a_optimality: f64::INFINITY,
                i_optimality: f64::INFINITY,
                rival_evidence: None,
            };
        }
        let mut r = y_b.clone().qr().r();
        let condition_number = ratio(&r.singular_values());
        for mut column in r.column_iter_mut() {
            let norm = column.norm();
            column /= norm.max(f64::MIN_POSITIVE);
        }
        let size = r.ncols() as f64;
        let svd = whitened.clone().qr().r().svd(false, true);
        let (s, v_t) = (&svd.singular_values, svd.v_t.as_ref().expect("asked for"));
        let rotated = v_t * workspace * v_t.transpose();
        let squared_error: f64 = s.iter().enumerate().map(|(i, s)| rotated[(i, i)] / (s * s)).sum();
        Self {
            condition_number,
            scaled_condition_number: ratio(&r.singular_values()),
            d_optimality: (-s.map(f64::ln).sum() / size).exp(),
            a_optimality: (s.map(|s| 1.0 / (s * s)).sum() / size).sqrt(),
            i_optimality: (squared_error / joints as f64).sqrt(),
            rival_evidence: None,
        }
    }

    /// What is minimised; of rivals one over the root of their evidence, the noise over what tells them apart.
    pub fn value(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::ConditionNumber => self.condition_number,
            Criterion::ScaledConditionNumber => self.scaled_condition_number,
            Criterion::DOptimality => self.d_optimality,
            Criterion::AOptimality => self.a_optimality,
            Criterion::IOptimality => self.i_optimality,
            Criterion::RivalEvidence => self.rival_evidence.map_or(f64::INFINITY, |e| 1.0 / e.sqrt()),
        }
    }
}

fn ratio(singular_values: &DVector<f64>) -> f64 {
    singular_values.max() / singular_values.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gram(seed: f64) -> DMatrix<f64> {
        let w = DMatrix::from_fn(30, 6, |r, c| ((3 * r * r + 5 * c * c + 7 * r * c) as f64 * seed).sin());
        w.tr_mul(&w)
    }

    #[test]
    fn prop_derivatives_equal_differences() {
        let workspace = gram(0.77);
        let all = [
            SmoothCriterion::ConditionNumber { power: 3.0 },
            SmoothCriterion::ScaledConditionNumber { power: 3.0 },
            SmoothCriterion::DOptimality,
            SmoothCriterion::AOptimality,
            SmoothCriterion::IOptimality {
                workspace: &workspace,
                joints: 2,
            },
        ];
        let direction = gram(0.31);
        for criterion in all {
            let (_, g) = criterion.evaluate(gram(1.0));
            let h = 1e-6;
            let at = |s: f64| criterion.evaluate(gram(1.0) + &direction * s).0;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            let exact = g.dot(&direction);
            // Central differences with h = 1e-6: rounding 1e-16/h and truncation h², both below 1e-9 of values of order one.
            assert!(
                (difference - exact).abs() < 1e-8 * exact.abs().max(1.0),
                "{criterion:?} {difference} {exact}"
            );
        }
    }

    #[test]
    fn prop_smoothed_condition_approaches_the_true_one_from_above() {
        let lambda = DVector::from_vec(vec![1.0, 1.01, 3.0, 8.0, 8.1]);
        let truth = 0.5 * 8.1f64.ln();
        let mut before = f64::INFINITY;
        for power in [1.0, 3.0, 12.0, 100.0, 1000.0] {
            let (value, _) = smoothed_log_condition(&lambda, power);
            assert!(value >= truth && value < before);
            before = value;
        }
        // At most ln(5)/p above it: five eigenvalues, both sums.
        assert!(before - truth <= 5f64.ln() / 1000.0);
    }
}
