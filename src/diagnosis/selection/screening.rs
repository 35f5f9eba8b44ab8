//! The search over all candidates: the best shape of each on its grid, refined, and what it would explain of what is left.

use super::candidate::{Candidate, columns_of, columns_on_grid};
use super::score::{Scored, appraise};
use crate::diagnosis::golden_section::golden_section;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Shape;
use crate::regression::{Data, Reduced, System, reduce};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Scores of all candidates that the model does not have already, best evidence first.
pub(crate) fn scan(data: &Data, system: &System, candidates: &[Candidate]) -> Vec<Scored> {
    let mut scored = scan_on_grid(data, system, candidates);
    let refined: Vec<Scored> = scored
        .par_iter()
        .take(SETTINGS.selection.refined)
        .map(|s| refine(data, system, s))
        .collect();
    scored.splice(..refined.len(), refined);
    scored.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    scored
}

/// The same with shapes from the grid alone.
pub(crate) fn scan_on_grid(data: &Data, system: &System, candidates: &[Candidate]) -> Vec<Scored> {
    let open: Vec<&Candidate> = candidates
        .iter()
        .filter(|c| !system.model.terms.iter().any(|t| c.is_same_effect(t)))
        .collect();
    let mut scored: Vec<Scored> = open
        .par_iter()
        .filter_map(|c| best_on_grid(data, system, c, c.grid().len()))
        .collect();
    scored.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    scored
}

/// The best shape of a candidate on its grid; the candidate is one of `tried`.
pub(crate) fn best_on_grid(data: &Data, system: &System, candidate: &Candidate, tried: usize) -> Option<Scored> {
    let grid = candidate.grid();
    let batches: Vec<Vec<Reduced>> = grid
        .par_chunks(SETTINGS.selection.batch)
        .map(|batch| reduced_on_grid(data, system, candidate, batch))
        .collect();
    let reduced = batches.into_iter().flatten().zip(&grid);
    let (best, shape) = reduced.reduce(|best, next| if next.0.gain > best.0.gain { next } else { best })?;
    (best.rank > 0).then(|| {
        appraise(
            system,
            candidate,
            candidate.term(best.coefficients.as_slice(), shape),
            best.gain,
            best.rank,
            tried,
            None,
        )
    })
}

/// What a candidate would explain at each of some shapes; nothing of a candidate without columns.
fn reduced_on_grid(data: &Data, system: &System, candidate: &Candidate, shapes: &[Vec<f64>]) -> Vec<Reduced> {
    let columns = columns_on_grid(data, system, candidate, shapes);
    let (own, rest, right) = system.projected(&columns);
    let k = own.nrows() / shapes.len();
    let of = |i: usize| {
        let part = |m: &DMatrix<f64>| m.view((i * k, i * k), (k, k)).into_owned();
        reduce(&part(&own), &part(&rest), &right.rows(i * k, k).into_owned())
    };
    let count = if k == 0 { 0 } else { shapes.len() };
    (0..count).map(of).collect()
}

/// Golden-section steps of a shape: sixteen narrow the bracket to a two-thousandth; Gauss-Newton does the rest.
const STEPS: usize = 16;

/// Refines the shape of a scored candidate: golden section along each shape in turn, between the neighbours on the grid.
pub(crate) fn refine(data: &Data, system: &System, scored: &Scored) -> Scored {
    if scored.candidate.shapes.is_empty() {
        return scored.clone();
    }
    let gain_at = |shape: &[f64]| system.reduced(&columns_of(data, system, &scored.candidate, &[shape.to_vec()]));
    let mut shape = scored.term.shape.clone();
    for _ in 0..SETTINGS.selection.refinement_rounds {
        for i in 0..scored.candidate.free_shapes() {
            let (low, high) = neighbours(&scored.candidate.shapes[i], shape[i]);
            let along = |v: f64| {
                let mut there = shape.clone();
                there[i] = v;
                gain_at(&there).gain
            };
            let best = golden_section(along, [low, high], STEPS);
            if along(best) > along(shape[i]) {
                shape[i] = best;
            }
        }
    }
    let reduced = gain_at(&shape);
    if reduced.gain < scored.gain {
        return scored.clone();
    }
    let term = scored.candidate.term(reduced.coefficients.as_slice(), &shape);
    appraise(
        system,
        &scored.candidate,
        term,
        reduced.gain,
        reduced.rank,
        scored.tried,
        None,
    )
}

fn neighbours(shape: &Shape, value: f64) -> (f64, f64) {
    let below = shape
        .grid
        .iter()
        .copied()
        .filter(|&g| g < value * (1.0 - 1e-12 * value.signum()))
        .fold(shape.low, f64::max);
    let above = shape
        .grid
        .iter()
        .copied()
        .filter(|&g| g > value * (1.0 + 1e-12 * value.signum()))
        .fold(shape.high, f64::min);
    (below, above)
}
