//! What rows are worth that go together: tests and deviations where the residual is not white.
//!
//! Without replicates the noise is what the model leaves, and that is smooth: rows next to each other say the same. How much this
//! costs depends on the column: a constant meets all of a slow misfit, an acceleration hardly any. So every block of columns is
//! tested against the scatter of its own scores over stretches of time (Newey & West 1987), not against one number of effective
//! rows for all.

use super::block_jackknife::{TimeBlock, time_blocks};
use super::normal_equations::{Block, System};
use super::partial_regression::Whitened;
use super::rank::directions;
use super::tail::f_tail;
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Degrees of freedom of a covariance from `SETTINGS.score_blocks` sums with Bartlett's weights 1 and 1/2 on neighbours: `3/2` of
/// their number over the two.
const FREEDOM: f64 = 0.75 * SETTINGS.score_blocks as f64;

/// Sum of `zₐ zₐᵀ` with half of the products of neighbours of the same log.
fn covariance(scores: &[(usize, DVector<f64>)], size: usize) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(size, size);
    for (i, (log, z)) in scores.iter().enumerate() {
        sum += z * z.transpose();
        if let Some((_, next)) = scores.get(i + 1).filter(|(other, _)| other == log) {
            let cross = z * next.transpose() * 0.5;
            sum += &cross + cross.transpose();
        }
    }
    sum
}

/// Chance of what the columns gain if they were nothing: Hotelling's T² of their scores over stretches of time.
pub(crate) fn chance_of(system: &System, columns: &Whitened) -> f64 {
    let (own, rest, right) = system.projected(columns);
    let base = directions(&own, &rest);
    let k = base.ncols();
    if k == 0 {
        return 1.0;
    }
    let along = base.tr_mul(&right);
    let scores = scores(system, columns, &base, &along);
    let Some(inverse) = covariance(&scores, k).try_inverse() else {
        return 1.0;
    };
    let hotelling = along.dot(&(inverse * &along));
    let second = FREEDOM - k as f64 + 1.0;
    let f = hotelling * second / (k as f64 * FREEDOM);
    f_tail(f, [k as f64, second])
}

/// Scores of the directions `base` over every stretch of time, at what the columns gain `along` them.
fn scores(system: &System, columns: &Whitened, base: &DMatrix<f64>, along: &DVector<f64>) -> Vec<(usize, DVector<f64>)> {
    let hidden = &system.covariance * system.cross(columns);
    let of = |TimeBlock { stretch: log, rows }: TimeBlock| {
        let sum = (0..system.blocks[log].len())
            .filter_map(|j| score(&system.blocks[log][j], part(columns, log, j), &hidden, base, along, &rows))
            .fold(DVector::zeros(base.ncols()), |a, b| a + b);
        (log, sum)
    };
    let rows: Vec<usize> = system.blocks.iter().map(|b| b[0].residual.len()).collect();
    time_blocks(&rows, SETTINGS.score_blocks).into_par_iter().map(of).collect()
}

/// Coefficient of a single column on the row of `joint` beside the model, and its standard deviation; `None` where the model
/// hides it. Where rows go together it is by the scatter over stretches of time, and what the joint keeps beyond measured noise
/// widens it by `doubt`.
pub(crate) fn single_estimate(system: &System, columns: &Whitened, joint: usize, doubt: f64) -> Option<(f64, f64)> {
    let (own, rest, right) = system.projected(columns);
    let base = directions(&own, &rest);
    if base.shape() != (1, 1) {
        return None;
    }
    let along = base.tr_mul(&right);
    let variance = if system.noise_is_measured {
        doubt
    } else {
        covariance(&scores(system, columns, &base, &along), 1)[0].max(system.mean_square(&[joint]))
    };
    Some((base[0] * along[0], base[0].abs() * variance.sqrt()))
}

fn part(columns: &Whitened, log: usize, joint: usize) -> Option<&DMatrix<f64>> {
    columns[log].iter().find(|(j, _)| *j == joint).map(|(_, m)| m)
}

/// `Dᵀ C_⊥ᵀ (r − C_⊥ D d)` over some rows of a joint; `None` where nothing was measured.
fn score(
    block: &Block,
    own: Option<&DMatrix<f64>>,
    hidden: &DMatrix<f64>,
    base: &DMatrix<f64>,
    along: &DVector<f64>,
    rows: &std::ops::Range<usize>,
) -> Option<DVector<f64>> {
    let (from, count) = (rows.start, rows.len());
    let jacobian = block.jacobian.rows(from, count);
    let mut free = -(jacobian * hidden);
    if let Some(m) = own {
        free += m.rows(from, count);
    }
    let free = free * base;
    let left = block.residual.rows(from, count) - &free * along;
    (count > 0).then(|| free.tr_mul(&left))
}

/// Mean square of that many whitened rows from which they keep more than noise.
pub(crate) fn misfit_from(rows: usize) -> f64 {
    1.0 + 4.0 * (2.0 / rows.max(1) as f64).sqrt()
}

impl System {
    /// Independent values that the rows of a joint are worth for a question about variance: `n / (1 + 2 Σ ρ²)`.
    pub fn effective_rows(&self, joint: usize) -> f64 {
        let all = || {
            (0..self.model.robot.joint_count())
                .map(|j| self.count_effective_rows(j))
                .collect()
        };
        self.effective_rows.get(all)[joint]
    }

    fn count_effective_rows(&self, joint: usize) -> f64 {
        let lags = (self.blocks.iter().map(|b| b[joint].residual.len()).sum::<usize>() / SETTINGS.score_blocks).max(1);
        let product = |lag: usize| {
            self.blocks
                .iter()
                .map(|b| {
                    let r = b[joint].residual.as_slice();
                    r.iter().zip(&r[lag.min(r.len())..]).map(|(a, b)| a * b).sum::<f64>()
                })
                .sum::<f64>()
        };
        let own = product(0).max(f64::MIN_POSITIVE);
        let together: f64 = (1..=lags).map(|lag| (product(lag) / own).powi(2)).sum();
        self.rows(joint) as f64 / (1.0 + 2.0 * together)
    }

    /// Mean square of the whitened residual over these joints.
    pub fn mean_square(&self, joints: &[usize]) -> f64 {
        let rows: usize = joints.iter().map(|&j| self.rows(j)).sum();
        joints.iter().map(|&j| self.joint_chi_square(j)).sum::<f64>() / rows.max(1) as f64
    }

    /// Whether these joints keep more than the measured noise, by four standard deviations of χ²; without measured noise always.
    pub fn has_misfit(&self, joints: &[usize]) -> bool {
        let rows: usize = joints.iter().map(|&j| self.rows(j)).sum();
        !self.noise_is_measured || self.mean_square(joints) > misfit_from(rows)
    }
}
