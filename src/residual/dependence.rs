//! What rows are worth that go together: tests and deviations where the residual is not white.
//!
//! Without replicates the noise is what the model leaves, and that is smooth: rows next to each other say the same. How much this costs
//! depends on the column: a constant meets all of a slow misfit, an acceleration hardly any. So every block of columns is tested against
//! the scatter of its own scores over stretches of time (Newey & West 1987), not against one number of effective rows for all.

use super::product::transposed_product;
use super::projection::{Whitened, directions};
use super::system::{Block, System};
use super::without_periods::RIDGE;
use crate::identification::f_tail;
use nalgebra::{DMatrix, DVector};

/// Stretches of time that scores are summed over. Each has to be longer than the residual's memory (a tenth to half a second of logs of some
/// twenty seconds) and there have to be enough of them for a test at one in a million.
const BLOCKS: usize = 40;
/// Degrees of freedom of a covariance from `BLOCKS` sums with Bartlett's weights 1 and 1/2 on neighbours: `3/2` of their number over the two.
const FREEDOM: f64 = 0.75 * BLOCKS as f64;

/// Stretches of time that the jackknife leaves out one by one. On measured logs estimates from two parts differ by 0.9 to 1.4 of its deviations with sixteen; the
/// sandwich over shorter ones says up to 2.3 times too little.
const LEFT_OUT: usize = 16;

/// Rows of `count` stretches of time over all logs, per log.
fn pieces(system: &System, count: usize) -> Vec<(usize, std::ops::Range<usize>)> {
    let rows: Vec<usize> = system.blocks.iter().map(|b| b[0].residual.len()).collect();
    let total: usize = rows.iter().sum();
    let mut list = Vec::new();
    for (log, &own) in rows.iter().enumerate() {
        let parts = ((count * own) as f64 / total.max(1) as f64).round().max(1.0) as usize;
        list.extend((0..parts).map(|b| (log, b * own / parts..(b + 1) * own / parts)));
    }
    list
}

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
    let of = |(log, rows): (usize, std::ops::Range<usize>)| {
        let sum = (0..system.blocks[log].len())
            .filter_map(|j| score(&system.blocks[log][j], part(columns, log, j), &hidden, base, along, &rows))
            .fold(DVector::zeros(base.ncols()), |a, b| a + b);
        (log, sum)
    };
    pieces(system, BLOCKS).into_iter().map(of).collect()
}

/// Coefficient of a single column on the row of `joint` beside the model, and its standard deviation; `None` where the model hides it. Where rows go together
/// it is by the scatter over stretches of time, and what the joint keeps beyond measured noise widens it by `doubt`.
pub(crate) fn estimate(system: &System, columns: &Whitened, joint: usize, doubt: f64) -> Option<(f64, f64)> {
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
pub(super) fn misfit_from(rows: usize) -> f64 {
    1.0 + 4.0 * (2.0 / rows.max(1) as f64).sqrt()
}

impl System {
    /// Covariance of term `at` by the jackknife: each of sixteen stretches of time is left out in turn. Without stretch b the linearised fit moves by
    /// `−(G − G_b)⁻¹ g_b`, which is `−C (1 − G_b C)⁻¹ g_b` with the covariance C of all.
    pub fn jackknife(&self, at: usize) -> DMatrix<f64> {
        let (from, k) = (self.model.offset_of(at), self.model.terms[at].parameters());
        let p = self.covariance.nrows();
        let moved: Vec<DVector<f64>> = pieces(self, LEFT_OUT)
            .into_iter()
            .map(|(log, rows)| {
                let (mut normal, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
                for block in &self.blocks[log] {
                    let part = block.jacobian.rows(rows.start, rows.len()).into_owned();
                    normal += transposed_product(&part, &part);
                    gradient += part.tr_mul(&block.residual.rows(rows.start, rows.len()));
                }
                // What this stretch determines nearly alone is not extrapolated from the others without bound.
                let others = DMatrix::identity(p, p) * (1.0 + RIDGE) - normal * &self.covariance;
                let pull = others.lu().solve(&gradient).unwrap_or(gradient);
                -(&self.covariance * pull).rows(from, k).into_owned()
            })
            .collect();
        let count = moved.len() as f64;
        let mean = moved.iter().fold(DVector::zeros(k), |sum, m| sum + m) / count;
        let spread = moved.iter().fold(DMatrix::zeros(k, k), |sum, m| {
            let off = m - &mean;
            sum + &off * off.transpose()
        });
        self.no_less_than_independent(at, &(spread * ((count - 1.0) / count)))
    }

    /// `robust`, no deviation smaller than independent rows of what is left would give.
    fn no_less_than_independent(&self, at: usize, robust: &DMatrix<f64>) -> DMatrix<f64> {
        let k = robust.nrows();
        let joints = (0..self.model.robot.joint_count()).collect::<Vec<_>>();
        let reached = if self.model.terms[at].joints.is_empty() {
            &joints
        } else {
            &self.model.terms[at].joints
        };
        let plain = self.term_covariance(at) * self.mean_square(reached).max(1e-300);
        let grow = |i: usize| (plain[(i, i)] / robust[(i, i)].max(f64::MIN_POSITIVE)).max(1.0).sqrt();
        DMatrix::from_fn(k, k, |r, c| robust[(r, c)] * grow(r) * grow(c))
    }

    /// Independent values that the rows of a joint are worth for a question about variance: `n / (1 + 2 Σ ρ²)`.
    pub fn effective_rows(&self, joint: usize) -> f64 {
        let lags = (self.blocks.iter().map(|b| b[joint].residual.len()).sum::<usize>() / BLOCKS).max(1);
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
