//! Every effect on every place it can sit, and what it would explain of what is left.

use super::projection::{Thinned, Whitened, reduce};
use super::store::Shaped;
use super::system::{Data, System};
use super::{AugmentedModel, Stretch, Term};
use crate::dynamics::Coulomb;
use crate::effects::{self, Column, Effect, Kind, Scene, Shape, Span};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::sync::Arc;

/// An effect on a place, in one of its forms.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub effect: &'static dyn Effect,
    pub form: usize,
    pub joints: Vec<usize>,
    pub shapes: Vec<Shape>,
}

/// A candidate at its best shape on the grid.
#[derive(Clone)]
pub(crate) struct Scored {
    pub candidate: Candidate,
    pub term: Term,
    /// Decrease of the weighted sum of squares.
    pub gain: f64,
    /// Parameters that pay for it: rank of the columns plus shapes.
    pub cost: usize,
    /// Shapes tried.
    pub tried: usize,
    /// Gain divided by what is left after it per degree of freedom, where that is more than noise.
    pub fair_gain: f64,
    /// Two log evidence ratios: fair gain less what the parameters and the shapes tried cost.
    pub evidence: f64,
}

/// Part of the true gain that the linearised one of [`scan`] shows at least.
pub(crate) const LINEAR_GAIN: f64 = 0.6;

/// All candidates for this model and data.
pub(crate) fn candidates(model: &AugmentedModel, spans: &[Span], against_model: bool) -> Vec<Candidate> {
    let mut list = Vec::new();
    for &effect in effects::all() {
        let wanted = match effect.kind() {
            Kind::Additive | Kind::Distortion => true,
            Kind::AgainstModel => against_model,
            Kind::BetweenPeriods => false,
        };
        if !wanted {
            continue;
        }
        for joints in effect.places(&model.robot) {
            for form in 0..effect.forms() {
                let shapes = effect.shapes(form, &joints, spans);
                if shapes.iter().all(|s| !s.grid.is_empty()) {
                    list.push(Candidate {
                        effect,
                        form,
                        joints: joints.clone(),
                        shapes,
                    });
                }
            }
        }
    }
    list
}

impl Candidate {
    /// All combinations of the shapes' grids.
    pub fn grid(&self) -> Vec<Vec<f64>> {
        self.shapes.iter().fold(vec![Vec::new()], |points, shape| {
            let longer = |point: &Vec<f64>| {
                let point = point.clone();
                shape
                    .grid
                    .iter()
                    .map(move |&v| [point.clone(), vec![v]].concat())
                    .collect::<Vec<_>>()
            };
            points.iter().flat_map(longer).collect()
        })
    }

    pub fn is_same_effect(&self, term: &Term) -> bool {
        self.effect.code() == term.effect.code() && self.joints == term.joints
    }

    fn is_distortion(&self) -> bool {
        self.effect.kind() == Kind::Distortion
    }

    /// The term with these coefficients at this shape; for a distortion the coefficients are its parameters.
    pub fn term(&self, coefficients: &[f64], shape: &[f64]) -> Term {
        let distortion = self.is_distortion();
        let (coefficients, shape) = if distortion {
            (&[][..], coefficients)
        } else {
            (coefficients, shape)
        };
        let bounds = if distortion {
            vec![[f64::NEG_INFINITY, f64::INFINITY]; shape.len()]
        } else {
            self.shapes.iter().map(|s| [s.low, s.high]).collect()
        };
        Term {
            effect: self.effect,
            form: self.form,
            joints: self.joints.clone(),
            coefficients: coefficients.to_vec(),
            shape: shape.to_vec(),
            free_shapes: if distortion { shape.len() } else { self.shapes.len() },
            bounds,
        }
    }
}

/// Columns of a candidate at a shape over all stretches, whitened; from the coarse forms of the stretches, whose torques are good enough to
/// find what is worth fitting.
pub(crate) fn columns_of(data: &Data, system: &System, candidate: &Candidate, shapes: &[Vec<f64>]) -> Whitened {
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let made: Vec<Shaped> = shapes
        .iter()
        .map(|shape| shaped(data, system, &coarse, candidate, shape))
        .collect();
    system.whitened_shaped(data, &coarse, &side_by_side(made.iter(), coarse.len()))
}

/// The same of the grid's shapes, which every scan asks for again: what the measured motion alone decides is kept.
fn columns_on_grid(data: &Data, system: &System, candidate: &Candidate, shapes: &[Vec<f64>]) -> Whitened {
    let lasting = !candidate.is_distortion() && !candidate.effect.reads_torques();
    if !lasting || system.thinned(data).iter().any(|t| t.moved) {
        return columns_of(data, system, candidate, shapes);
    }
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let kept: Vec<Arc<Shaped>> = shapes
        .iter()
        .map(|shape| {
            data.columns
                .get(candidate, shape, || shaped(data, system, &coarse, candidate, shape))
        })
        .collect();
    system.whitened_shaped(data, &coarse, &side_by_side(kept.iter().map(Arc::as_ref), coarse.len()))
}

/// Columns of several shapes in one list per stretch.
fn side_by_side<'a>(shapes: impl Iterator<Item = &'a Shaped> + Clone, stretches: usize) -> Vec<Vec<&'a Column>> {
    (0..stretches).map(|i| shapes.clone().flat_map(|s| &s[i]).collect()).collect()
}

/// Columns of one shape as they enter the rows, per stretch.
fn shaped(data: &Data, system: &System, coarse: &[&Stretch], candidate: &Candidate, shape: &[f64]) -> Shaped {
    let of = |(stretch, e): (&&Stretch, &Thinned)| {
        let columns = if candidate.is_distortion() {
            distortion(system, stretch, candidate)
        } else {
            let scene = Scene {
                robot: &system.model.robot,
                motion: &e.motion,
                rigid: &e.rigid,
                declared: &e.declared,
                interval: stretch.interval,
                periodic: stretch.periodic,
                coulomb: Coulomb::Sign,
            };
            candidate.effect.columns(candidate.form, &scene, &candidate.joints, shape)
        };
        columns.into_iter().map(|c| stretch.shaped_column(c)).collect()
    };
    coarse.iter().zip(system.thinned(data)).map(of).collect()
}

fn distortion(system: &System, stretch: &Stretch, candidate: &Candidate) -> Vec<Column> {
    let zero = candidate.term(&vec![0.0; candidate.effect.steps().len()], &[]);
    let plain = system.model.torques(&stretch.motion, &system.model.robot, None);
    let known = (&stretch.motion, system.model.robot.gravity(), &plain.declared[..]);
    let derivative = system.model.distortion_columns(stretch, &plain, &zero, None, known);
    let column = |rows: Vec<Vec<f64>>| Column {
        rows: rows
            .into_iter()
            .enumerate()
            .filter(|(_, r)| r.iter().any(|v| *v != 0.0))
            .collect(),
    };
    derivative.into_iter().map(column).collect()
}

/// Shapes whose columns are multiplied with the model's in one go.
const BATCH: usize = 16;

/// The best shape of a candidate on its grid.
pub(crate) fn score(data: &Data, system: &System, candidate: &Candidate) -> Option<Scored> {
    let grid = candidate.grid();
    let mut best: Option<(f64, usize, DVector<f64>, &Vec<f64>)> = None;
    for batch in grid.chunks(BATCH) {
        let columns = columns_on_grid(data, system, candidate, batch);
        let (own, rest, right) = system.projected(&columns);
        let k = own.nrows() / batch.len();
        if k == 0 {
            return None;
        }
        for (i, shape) in batch.iter().enumerate() {
            let part = |m: &DMatrix<f64>| m.view((i * k, i * k), (k, k)).into_owned();
            let reduced = reduce(&part(&own), &part(&rest), &right.rows(i * k, k).into_owned());
            if best.as_ref().is_none_or(|b| reduced.gain > b.0) {
                best = Some((reduced.gain, reduced.rank, reduced.coefficients, shape));
            }
        }
    }
    let (gain, rank, coefficients, shape) = best?;
    (rank > 0).then(|| {
        appraise(
            system,
            candidate,
            candidate.term(coefficients.as_slice(), shape),
            gain,
            rank,
            grid.len(),
            None,
        )
    })
}

/// Refines the shape of a scored candidate: golden section along each shape in turn, between the neighbours on the grid.
pub(crate) fn refine(data: &Data, system: &System, scored: &Scored) -> Scored {
    if scored.candidate.shapes.is_empty() {
        return scored.clone();
    }
    let gain_at = |shape: &[f64]| system.reduced(&columns_of(data, system, &scored.candidate, &[shape.to_vec()]));
    let mut shape = scored.term.shape.clone();
    for _ in 0..ROUNDS {
        for i in 0..shape.len() {
            let (low, high) = neighbours(&scored.candidate.shapes[i], shape[i]);
            let along = |v: f64| {
                let mut there = shape.clone();
                there[i] = v;
                gain_at(&there).gain
            };
            let best = golden_section(along, low, high);
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

/// One shape needs one round; of two, the second round catches the turn of the first.
const ROUNDS: usize = 2;

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

/// Sixteen steps narrow the bracket to a two-thousandth; Gauss-Newton does the rest.
fn golden_section(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..16 {
        if fa > fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    if fa > fb { a } else { b }
}

/// Weighs a gain against what it costs.
pub(crate) fn appraise(
    system: &System,
    candidate: &Candidate,
    term: Term,
    gain: f64,
    rank: usize,
    tried: usize,
    after: Option<&System>,
) -> Scored {
    let cost = rank
        + if candidate.is_distortion() {
            0
        } else {
            candidate.shapes.len()
        };
    let joints = reach(candidate, system.model.robot.joint_count());
    let (fair_gain, rows) = if system.noise_is_measured {
        let rows = (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum::<usize>() as f64;
        (gain / dispersion(system, &joints, gain, after), rows)
    } else {
        likelihood_gain(system, &joints, gain, after)
    };
    let evidence = fair_gain - cost as f64 * rows.ln() - 2.0 * (tried as f64).ln();
    Scored {
        candidate: candidate.clone(),
        term,
        gain,
        cost,
        tried,
        fair_gain,
        evidence,
    }
}

/// Joints whose rows a candidate reaches.
pub(crate) fn reach(candidate: &Candidate, joints: usize) -> Vec<usize> {
    match candidate.effect.kind() {
        Kind::Additive if candidate.effect.code() == "torque_crosstalk" || candidate.effect.code() == "unexplained" => {
            vec![candidate.joints[0]]
        }
        Kind::Additive => candidate.joints.clone(),
        _ if candidate.effect.code() == "friction_drift" || candidate.effect.code() == "torque_gain" => candidate.joints.clone(),
        _ => (0..joints).collect(),
    }
}

/// What a gain is measured against, on the joints reached: the mean square of the whitened residual once the gain is taken off, where the part
/// that is not noise counts for as many rows as go together in it, because a misfit is smooth and its rows are no independent witnesses.
/// `after` is the model with the candidate, where it has been fitted.
fn dispersion(system: &System, joints: &[usize], gain: f64, after: Option<&System>) -> f64 {
    let rows: usize = joints.iter().map(|&j| system.rows(j)).sum();
    let left = system.mean_square(joints) - gain / rows.max(1) as f64;
    if left <= 1.0 {
        1.0
    } else {
        1.0 + (left - 1.0) * after.unwrap_or(system).persistence(joints)
    }
}

/// Without measured noise: `n ln(χ₀²/χ²)`, twice the log of the likelihood ratio with unknown variance, n the rows that are worth something of
/// their own; and n.
fn likelihood_gain(system: &System, joints: &[usize], gain: f64, after: Option<&System>) -> (f64, f64) {
    let before: f64 = joints.iter().map(|&j| system.joint_chi_square(j)).sum();
    let rows: f64 = joints.iter().map(|&j| after.unwrap_or(system).effective_rows(j)).sum();
    let share = (gain / before.max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
    (-rows * (-share).ln_1p(), rows.max(2.0))
}

/// How likely a gain as large as this is without the effect: χ² of as many degrees of freedom as parameters.
pub(crate) fn chance(fair_gain: f64, parameters: usize) -> f64 {
    let distribution = ChiSquared::new(parameters.max(1) as f64).expect("degrees of freedom are positive");
    distribution.sf(fair_gain.max(0.0))
}

/// Scores of all candidates that the model does not have already, best evidence first.
pub(crate) fn scan(data: &Data, system: &System, candidates: &[Candidate]) -> Vec<Scored> {
    let open: Vec<&Candidate> = candidates
        .iter()
        .filter(|c| !system.model.terms.iter().any(|t| c.is_same_effect(t)))
        .collect();
    let mut scored: Vec<Scored> = open.par_iter().filter_map(|c| score(data, system, c)).collect();
    scored.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let refined: Vec<Scored> = scored.par_iter().take(REFINED).map(|s| refine(data, system, s)).collect();
    scored.splice(..refined.len(), refined);
    scored.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    scored
}

/// The best on the grid are within a tenth of their best shape: a dozen is enough to hold the right one.
const REFINED: usize = 12;

/// What the chance of a gain is multiplied with: number of effects, times the places, forms and shapes that this one was tried with. Every
/// effect has the same share of false findings (weighted Bonferroni); a fine grid of one does not make the others harder to find.
pub(crate) fn hypotheses(candidates: &[Candidate], code: &str) -> f64 {
    let own: usize = candidates
        .iter()
        .filter(|c| c.effect.code() == code)
        .map(|c| c.grid().len())
        .sum();
    (own.max(1) * effects::all().len()) as f64
}
