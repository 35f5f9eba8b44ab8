//! Effects of size one along the planned motion.

use super::planned::Planned;
use crate::diagnosis::selection::columns_of;
use crate::regression::{System, width};
use nalgebra::DVector;
use rayon::prelude::*;

/// An effect of size one in one of its parameters, whitened.
pub(super) struct Signal {
    /// Which of the candidates: the first form of the effect on its place.
    pub candidate: usize,
    /// Which of its coefficients (of a distortion: parameters) has the size.
    pub parameter: usize,
    /// Coefficients of size one.
    pub unit: Vec<f64>,
    pub shape: Vec<f64>,
    /// Per stretch, `(joint, rows)`.
    pub rows: Vec<Vec<(usize, DVector<f64>)>>,
    /// `Jᵀ` times it.
    pub cross: DVector<f64>,
    /// Its square, and what the base parameters cannot imitate of it.
    pub own: f64,
    pub left: f64,
}

/// Of every effect on every place, in its first form and at the shape in the middle of those that a search tries.
pub(super) fn signals(planned: &Planned) -> Vec<Signal> {
    let first = (0..planned.candidates.len()).filter(|&at| planned.candidates[at].form == 0);
    let places: Vec<usize> = first.collect();
    places.into_par_iter().flat_map_iter(|at| of_candidate(planned, at)).collect()
}

fn of_candidate(planned: &Planned, at: usize) -> Vec<Signal> {
    let candidate = &planned.candidates[at];
    let shape: Vec<f64> = candidate.shapes.iter().map(|s| s.grid[s.grid.len() / 2]).collect();
    let columns = columns_of(planned.data, &planned.system, candidate, std::slice::from_ref(&shape));
    let count = width(&columns);
    let middle = candidate.joints.first().map_or(0.0, |&j| middle(&planned.system, j));
    let of = |(parameter, unit): (usize, Vec<f64>)| {
        let along = DVector::from_column_slice(&unit);
        let of_stretch = |parts: &Vec<(usize, nalgebra::DMatrix<f64>)>| parts.iter().map(|(j, m)| (*j, m * &along)).collect();
        let rows: Vec<Vec<(usize, DVector<f64>)>> = columns.iter().map(of_stretch).collect();
        let own = rows.iter().flatten().map(|(_, v)| v.norm_squared()).sum::<f64>();
        let cross = cross(&planned.system, &rows);
        let left = own - cross.dot(&(&planned.system.covariance * &cross));
        Signal {
            candidate: at,
            parameter,
            unit,
            shape: shape.clone(),
            rows,
            cross,
            own,
            left,
        }
    };
    let units = candidate.effect.units(candidate.form, count, middle);
    units.into_iter().enumerate().map(of).collect()
}

/// `Jᵀ` times a signal.
fn cross(system: &System, rows: &[Vec<(usize, DVector<f64>)>]) -> DVector<f64> {
    let mut sum = DVector::zeros(system.covariance.nrows());
    for (blocks, parts) in system.blocks.iter().zip(rows) {
        for (j, values) in parts {
            sum += blocks[*j].jacobian.tr_mul(values);
        }
    }
    sum
}

/// Middle of where a joint moves.
fn middle(system: &System, joint: usize) -> f64 {
    let positions = system
        .evaluated
        .iter()
        .flat_map(|e| e.motion.positions(joint).iter().copied());
    let [low, high] = positions.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], q| [l.min(q), h.max(q)]);
    0.5 * (low + high)
}
