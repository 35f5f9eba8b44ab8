//! Whether a direction that leaves less is one that the data have, or only the better of two that they contradict.
//!
//! What the model lacks is no noise: it goes with the motion, and one direction of gravity hides more of it than another. A
//! direction is therefore held against a model that knows more than any direction: the torques of gravity along x, y and z and
//! those of inertia have first moments each of their own. It contains all directions. The true one leaves hardly more than it;
//! where both leave much more, the data are not those of this arm under either. And the gain has to show all along the logs:
//! block by block, each predicted from the others (see [`held_out`](super::super::held_out)).

use super::direction::Fitted;
use super::form::{Form, factorised, powers};
use crate::diagnosis::held_out::paired_test;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{SETTINGS as REGRESSION_SETTINGS, time_blocks};
use nalgebra::{DMatrix, DVector, Vector3};

/// A gain of one direction over another.
pub(crate) struct Gain {
    /// Chance of it where misfit alone decides: two parameters gain so much more than k others do, of F with 2 and k degrees of
    /// freedom.
    pub by_misfit: f64,
    /// Chance of it on held-out blocks, to one side.
    pub in_blocks: f64,
}

impl Gain {
    pub fn of(form: &Form, better: &Fitted, worse: &Fitted) -> Self {
        let (free, freedom) = free(form, &better.signs);
        let rows = form.weight.iter().filter(|w| **w > 0.0).count() * form.samples;
        let noise = free / (rows as f64 - freedom).max(1.0);
        let more = (freedom - effective_rank(&form.normal_along(better.direction))).max(0.0);
        let expected = noise * (more + SETTINGS.mounting.noise_deviations * (2.0 * more).sqrt());
        let misfit = (better.rest - free - expected).max(f64::MIN_POSITIVE);
        let [before, after] = [worse, better].map(|f| held_out(form, f));
        let blocks: Vec<[f64; 2]> = before.into_iter().zip(after).map(|(b, a)| [b, a]).collect();
        let (sum, p_value) = paired_test(&blocks);
        let ratio = (worse.rest - better.rest).max(0.0) / misfit;
        Self {
            by_misfit: (1.0 + ratio).powf(-0.5 * more.min(SETTINGS.mounting.independent_misfits)),
            in_blocks: if sum > 0.0 { 0.5 * p_value } else { 1.0 },
        }
    }

    pub fn is_no_accident(&self) -> bool {
        self.by_misfit < SETTINGS.mounting.chance_by_misfit && self.in_blocks < SETTINGS.mounting.chance_in_blocks
    }
}

/// Sum of squares that the free model leaves, and its rank.
fn free(form: &Form, signs: &[f64]) -> (f64, f64) {
    let p = form.normal[0][0].nrows();
    let (mut normal, mut right) = (DMatrix::zeros(4 * p, 4 * p), DVector::zeros(4 * p));
    for a in 0..4 {
        for b in 0..4 {
            normal.view_mut((a * p, b * p), (p, p)).copy_from(&form.normal[a][b]);
        }
        right.rows_mut(a * p, p).copy_from(&signed(&form.right[a], signs));
    }
    let (factor, scale) = factorised(&normal);
    let along = factor
        .l()
        .solve_lower_triangular(&right.component_mul(&scale))
        .map_or(0.0, |v| v.norm_squared());
    (
        (form.total() - along).max(SETTINGS.mounting.no_column * form.total()),
        effective_rank(&normal),
    )
}

/// Columns j n + j of a right side, added with these signs.
fn signed(right: &DMatrix<f64>, signs: &[f64]) -> DVector<f64> {
    let n = signs.len();
    (0..n).fold(DVector::zeros(right.nrows()), |v, j| v + right.column(j * n + j) * signs[j])
}

/// Trace of the hat matrix of a ridge: `p − ridge tr (G + ridge)⁻¹` of the scaled matrix, less the columns that are zero.
fn effective_rank(normal: &DMatrix<f64>) -> f64 {
    let (factor, scale) = factorised(normal);
    let zero = scale.iter().filter(|s| **s == 0.0).count() as f64;
    normal.nrows() as f64 - zero - SETTINGS.mounting.ridge * (factor.inverse().trace() - zero)
}

/// Sums of squares of every block of time about its prediction from all others.
fn held_out(form: &Form, fitted: &Fitted) -> Vec<f64> {
    let rows: Vec<DMatrix<f64>> = form.rows.iter().map(|parts| along(parts, fitted.direction)).collect();
    let normal = form.normal_along(fitted.direction);
    let right = signed(&form.right_side(fitted.direction), &fitted.signs);
    let of = |range: std::ops::Range<usize>| {
        let (from, count) = (range.start, range.len());
        let (mut others, mut moment) = (normal.clone(), right.clone());
        let own: Vec<(DMatrix<f64>, DVector<f64>)> = (0..form.joints)
            .map(|j| {
                let torque = form.torque.view((from, j), (count, 1)) * (fitted.signs[j] * form.weight[j]);
                (rows[j].rows(from, count).into_owned(), torque.column(0).into_owned())
            })
            .collect();
        for (matrix, torque) in &own {
            // What only the block determines is not extrapolated into it without limit.
            let leave = 1.0 - SETTINGS.mounting.least_outside;
            others -= matrix.tr_mul(matrix) * leave;
            moment -= matrix.tr_mul(torque);
        }
        let (factor, scale) = factorised(&others);
        let values = factor.solve(&moment.component_mul(&scale)).component_mul(&scale);
        own.iter()
            .map(|(matrix, torque)| (torque - matrix * &values).norm_squared())
            .sum()
    };
    time_blocks(&[form.samples], REGRESSION_SETTINGS.jackknife_blocks)
        .into_iter()
        .map(|b| of(b.rows))
        .collect()
}

/// Rows of a joint under this direction.
fn along(parts: &[DMatrix<f64>; 4], direction: Vector3<f64>) -> DMatrix<f64> {
    let c = powers(direction);
    (1..4).fold(parts[0].clone(), |m, a| m + &parts[a] * c[a])
}
