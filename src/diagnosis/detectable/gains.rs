//! What every candidate of the search would gain on every effect of size one.

use super::planned::Planned;
use super::signals::Signal;
use crate::diagnosis::selection::{Candidate, columns_of};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Whitened, directions, transposed_product, width};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// The best fit of a candidate to one signal, over the shapes of its grid.
#[derive(Debug, Clone)]
pub(super) struct Gain {
    /// Sum of squares that it takes off.
    pub gain: f64,
    /// Parameters that pay for it.
    pub cost: usize,
    /// The shape with which it gains most.
    pub shape: Vec<f64>,
    /// Its coefficients, or parameters of a distortion, and their covariance.
    pub coefficients: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// Whether the best shape is at an end of its range, where the diagnosis refuses it.
    pub at_an_end: bool,
}

/// Per candidate, per signal; `None` where the base parameters hide the candidate, or where it gains too little to be found
/// first.
pub(super) type Gains = Vec<Vec<Option<Gain>>>;

pub(super) fn gains(planned: &Planned, signals: &[Signal]) -> Gains {
    // C⊥ᵀ s = Cᵀ s − (JᵀC)ᵀ (JᵀJ)⁺ Jᵀ s.
    let crosses: Vec<DVector<f64>> = signals.iter().map(|s| s.cross.clone()).collect();
    let hidden = match crosses.is_empty() {
        true => DMatrix::zeros(planned.system.covariance.nrows(), 0),
        false => &planned.system.covariance * DMatrix::from_columns(&crosses),
    };
    (0..planned.candidates.len())
        .into_par_iter()
        .map(|at| of_candidate(planned, at, signals, &hidden))
        .collect()
}

fn of_candidate(planned: &Planned, at: usize, signals: &[Signal], hidden: &DMatrix<f64>) -> Vec<Option<Gain>> {
    let candidate = &planned.candidates[at];
    let mut best: Vec<Option<Gain>> = vec![None; signals.len()];
    for batch in grid(candidate, at, signals).chunks(SETTINGS.selection.batch) {
        let columns = columns_of(planned.data, &planned.system, candidate, batch);
        let (own, cross) = products(planned, &columns);
        let k = own.nrows() / batch.len();
        if k == 0 {
            return best;
        }
        let rest = &own - cross.tr_mul(&(&planned.system.covariance * &cross));
        let right = met(&columns, signals) - cross.tr_mul(hidden);
        for (i, shape) in batch.iter().enumerate() {
            let part = |m: &DMatrix<f64>| m.view((i * k, i * k), (k, k)).into_owned();
            let base = directions(&part(&own), &part(&rest));
            if base.ncols() == 0 {
                continue;
            }
            let along = base.tr_mul(&right.rows(i * k, k));
            for (s, best) in best.iter_mut().enumerate() {
                let gain = along.column(s).norm_squared();
                let counts = gain > SETTINGS.detectable.least_share * signals[s].left;
                if counts && best.as_ref().is_none_or(|b| gain > b.gain) {
                    *best = Some(fitted(candidate, shape, &base, gain, along.column(s).into_owned()));
                }
            }
        }
    }
    best
}

/// The shapes that the search tries, and those that the signals of this candidate have.
fn grid(candidate: &Candidate, at: usize, signals: &[Signal]) -> Vec<Vec<f64>> {
    let mut grid = candidate.grid();
    // Waves are looked for one by one: a fine comb of them imitates nothing that a coarse one does not, and the effect itself is
    // met by its own shape.
    let stride = grid.len().div_ceil(SETTINGS.detectable.most_shapes).max(1);
    grid = grid.into_iter().step_by(stride).collect();
    let own = signals.iter().filter(|s| s.candidate == at).map(|s| s.shape.clone()).next();
    grid.extend(own.filter(|shape| !grid.contains(shape)));
    grid
}

fn fitted(candidate: &Candidate, shape: &[f64], base: &DMatrix<f64>, gain: f64, along: DVector<f64>) -> Gain {
    let free = if candidate.is_distortion() {
        0
    } else {
        candidate.free_shapes()
    };
    let at_an_end = |(shape, value): (&crate::effects::Shape, &f64)| *value <= shape.low || *value >= shape.high;
    Gain {
        gain,
        cost: base.ncols() + free,
        shape: shape.to_vec(),
        coefficients: base * along,
        covariance: base * base.transpose(),
        at_an_end: candidate.shapes.iter().zip(shape).any(at_an_end),
    }
}

/// `(CᵀC, JᵀC)`.
fn products(planned: &Planned, columns: &Whitened) -> (DMatrix<f64>, DMatrix<f64>) {
    let k = width(columns);
    let p = planned.system.covariance.nrows();
    let (mut own, mut cross) = (DMatrix::zeros(k, k), DMatrix::zeros(p, k));
    for (blocks, parts) in planned.system.blocks.iter().zip(columns) {
        for (j, m) in parts {
            own += transposed_product(m, m);
            cross += transposed_product(&blocks[*j].jacobian, m);
        }
    }
    (own, cross)
}

/// `Cᵀ s` of every signal.
fn met(columns: &Whitened, signals: &[Signal]) -> DMatrix<f64> {
    let k = width(columns);
    let mut right = DMatrix::zeros(k, signals.len());
    for (stretch, parts) in columns.iter().enumerate() {
        for (j, m) in parts {
            for (s, signal) in signals.iter().enumerate() {
                for (_, values) in signal.rows[stretch].iter().filter(|r| r.0 == *j) {
                    let mut column = right.column_mut(s);
                    column += m.tr_mul(values);
                }
            }
        }
    }
    right
}
