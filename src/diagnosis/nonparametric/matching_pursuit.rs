//! Smooth functions of one or two variables on the row of a joint, by matching pursuit over products.

use crate::diagnosis::selection::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{AnyEffect, Effect, Unexplained, products, variable};
use crate::regression::{AugmentedModel, Data, Stretch, System, Term, Whitened, reduce};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A smooth dependence tried on one joint's row.
#[derive(Clone)]
pub(crate) struct Smooth {
    term: Term,
    pub gain: f64,
    evidence: f64,
}

/// Adds smooth functions while they earn their place; `None` when not even one does.
pub(crate) fn with_functions(data: &Data, system: &System) -> Option<System> {
    let mut now: Option<System> = None;
    for _ in 0..SETTINGS.nonparametric.most_functions {
        let here = now.as_ref().unwrap_or(system);
        let Some(best) = best_function(data, here) else { break };
        let mut model: AugmentedModel = here.model.clone();
        model.terms.push(best.term);
        now = Some(data.fit(model));
    }
    now
}

/// χ² of a joint above what noise alone leaves.
pub(crate) fn excess(system: &System, joint: usize) -> f64 {
    system.joint_chi_square(joint) - system.rows(joint) as f64 + system.spent(joint)
}

/// Joints on which more is left than measured noise explains, the most first: χ² is five standard deviations above its mean,
/// because the noise's own correlation is an estimate, and what is left is large enough to act on.
pub(crate) fn left_over(data: &Data, system: &System) -> Vec<usize> {
    let repetitions = data.stretches.iter().map(Stretch::repetitions).max().unwrap_or(1) as f64;
    let least = |j: usize| {
        (5.0 * (2.0 * system.rows(j) as f64).sqrt())
            .max(SETTINGS.nonparametric.least_size * SETTINGS.nonparametric.least_size * repetitions * system.rows(j) as f64)
    };
    let mut joints: Vec<usize> = (0..system.model.robot.joint_count())
        .filter(|&j| excess(system, j) > least(j))
        .collect();
    joints.sort_by(|&a, &b| excess(system, b).total_cmp(&excess(system, a)));
    joints
}

/// The smooth function with the best evidence, if it is beyond chance, on joints with a [residual above the noise](left_over).
fn best_function(data: &Data, system: &System) -> Option<Smooth> {
    let n = system.model.robot.joint_count();
    let mut rows = left_over(data, system);
    rows.truncate(3);
    let jobs = function_jobs(n, &rows);
    let scored: Vec<Smooth> = jobs
        .par_iter()
        .filter_map(|job| score(data, system, job, jobs.len() as f64))
        .collect();
    let best = scored.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))?.clone();
    // Each product was the best of a dictionary, the function the best of all jobs.
    let products = best.term.coefficients.len();
    let beyond_chance =
        chance(best.gain, products).ln() + products as f64 * SETTINGS.nonparametric.dictionary.ln() + (jobs.len() as f64).ln()
            < 1e-3f64.ln();
    let share = best.gain > 0.05 * excess(system, best.term.joints[0]);
    (best.evidence > SETTINGS.nonparametric.preference && beyond_chance && share).then_some(best)
}

/// Rows and variables tried: every position, speed and the load; pairs of positions; a position or the load with the joint's own
/// speed.
pub(crate) fn function_jobs(n: usize, rows: &[usize]) -> Vec<Vec<usize>> {
    let mut jobs = Vec::new();
    for &row in rows {
        jobs.extend((0..2 * n).chain([2 * n + row]).map(|v| vec![row, v]));
        jobs.extend((0..n).flat_map(|a| (a + 1..n).map(move |b| vec![row, a, b])));
        jobs.extend((0..n).chain([2 * n + row]).map(|a| vec![row, a, n + row]));
        // Two joints that act on each other: both rows, a function of both positions.
        jobs.extend(
            (0..n)
                .filter(|&other| other != row)
                .map(|other| vec![row, row.min(other), row.max(other), other]),
        );
    }
    jobs
}

/// Centre and half range of the variables of a job, and its products as columns; `None` where a variable does not vary.
pub(crate) fn function_columns(data: &Data, system: &System, job: &[usize]) -> Option<(Vec<f64>, Whitened)> {
    let shape = scaling(data, system, &job[1..job.len().min(3)])?;
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let columns: Vec<_> = coarse
        .iter()
        .zip(system.thinned(data))
        .map(|(stretch, e)| Unexplained.columns(0, &e.scene(system, stretch), job, &shape))
        .collect();
    let columns = system.whitened(data, &coarse, columns);
    Some((shape, columns))
}

/// One function, by matching pursuit over its products.
pub(crate) fn score(data: &Data, system: &System, job: &[usize], jobs: f64) -> Option<Smooth> {
    let codes = &job[1..job.len().min(3)];
    let (mut shape, columns) = function_columns(data, system, job)?;
    let (own, rest, right) = system.projected(&columns);
    let rows: usize = (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum();
    let count = products(codes, system.model.robot.joint_count()) * if job.len() > 3 { 2 } else { 1 };
    let price = (rows as f64).ln() + 2.0 * (count as f64).ln();
    let (chosen, gain, coefficients) = pursue(&own, &rest, &right, price);
    if chosen.is_empty() {
        return None;
    }
    let evidence = gain - chosen.len() as f64 * price - 2.0 * jobs.ln();
    shape.extend(chosen.iter().map(|&k| k as f64));
    let term = Term {
        effect: AnyEffect::Listed(&Unexplained),
        form: 0,
        joints: job.to_vec(),
        coefficients: coefficients.as_slice().to_vec(),
        shape,
        free_shapes: 0,
        bounds: Vec::new(),
    };
    Some(Smooth { term, gain, evidence })
}

/// Takes the column that gains most beside those taken, until none pays its price: which, what they gain, and their coefficients.
pub(crate) fn pursue(
    own: &DMatrix<f64>,
    rest: &DMatrix<f64>,
    right: &DVector<f64>,
    price: f64,
) -> (Vec<usize>, f64, DVector<f64>) {
    let mut chosen: Vec<usize> = Vec::new();
    let mut best = (0.0, DVector::zeros(0));
    let with = |set: &[usize]| {
        let pick = |m: &DMatrix<f64>| DMatrix::from_fn(set.len(), set.len(), |r, c| m[(set[r], set[c])]);
        let target = DVector::from_fn(set.len(), |r, _| right[set[r]]);
        reduce(&pick(own), &pick(rest), &target)
    };
    while chosen.len() < SETTINGS.nonparametric.most_products {
        let options = (0..own.nrows()).filter(|k| !chosen.contains(k)).map(|k| {
            let set: Vec<usize> = chosen.iter().copied().chain([k]).collect();
            (k, with(&set))
        });
        let Some((k, reduced)) = options.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain)) else {
            break;
        };
        if reduced.gain - best.0 < price || reduced.rank <= chosen.len() {
            break;
        }
        chosen.push(k);
        best = (reduced.gain, reduced.coefficients);
    }
    (chosen, best.0, best.1)
}

/// Centre and half range of every variable over all stretches; `None` for one that does not vary.
fn scaling(data: &Data, system: &System, codes: &[usize]) -> Option<Vec<f64>> {
    let mut shape = Vec::new();
    for &code in codes {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (stretch, e) in data.stretches.iter().map(Stretch::coarse_form).zip(system.thinned(data)) {
            for v in variable(&e.scene(system, stretch), code) {
                (low, high) = (low.min(v), high.max(v));
            }
        }
        // A variable that moves by less than a thousandth of a radian predicts nothing.
        if high - low < 1e-3 {
            return None;
        }
        shape.extend([0.5 * (low + high), 0.5 * (high - low)]);
    }
    Some(shape)
}
