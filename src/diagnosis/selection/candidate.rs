//! Every effect on every place it can sit, and its columns there.

use crate::effects::{self, AnyEffect, Column, Effect, EffectKind, OwnEffect, Shape, Span};
use crate::regression::{AugmentedModel, ColumnKey, Data, Present, Shaped, Stretch, System, Term, Thinned, Whitened};
use std::sync::Arc;

/// An effect on a place, in one of its forms.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub effect: AnyEffect,
    pub form: usize,
    pub joints: Vec<usize>,
    pub shapes: Vec<Shape>,
    /// Of the parameters of a distortion.
    pub bounds: Vec<[f64; 2]>,
}

/// All candidates for this model and data.
pub(crate) fn candidates(model: &AugmentedModel, spans: &[Span], against_model: bool) -> Vec<Candidate> {
    let mut list = Vec::new();
    for &effect in effects::all() {
        let wanted = match effect.kind() {
            EffectKind::Additive | EffectKind::Distortion => true,
            EffectKind::AgainstModel => against_model,
            EffectKind::BetweenPeriods => false,
        };
        if !wanted {
            continue;
        }
        for joints in effect.places(&model.robot) {
            for form in 0..effect.forms() {
                let bounds = effect.ranges(form, &model.robot, &joints);
                let shapes = within(effect.shapes(form, &joints, spans), &bounds);
                if shapes.iter().all(|s| !s.grid.is_empty()) {
                    list.push(Candidate {
                        effect: effect.into(),
                        form,
                        joints: joints.clone(),
                        shapes,
                        bounds,
                    });
                }
            }
        }
    }
    list
}

/// An own effect where it was defined, in all of its range.
pub(crate) fn own_candidate(own: &Arc<OwnEffect>, spans: &[Span]) -> Candidate {
    let joints = vec![own.joint()];
    Candidate {
        shapes: own.shapes(0, &joints, spans),
        effect: own.clone().into(),
        form: 0,
        joints,
        bounds: Vec::new(),
    }
}

/// Shapes searched only where they lie on robots. A grid that has no point left there gets the middle of what is left, by ratio;
/// nothing is left of one that cannot be seen there.
fn within(mut shapes: Vec<Shape>, ranges: &[[f64; 2]]) -> Vec<Shape> {
    for (shape, [low, high]) in shapes.iter_mut().zip(ranges) {
        (shape.low, shape.high) = (shape.low.max(*low), shape.high.min(*high));
        let inside = shape.low..=shape.high;
        shape.grid.retain(|v| inside.contains(v));
        if shape.grid.is_empty() && shape.low < shape.high {
            shape.grid = vec![(shape.low * shape.high).sqrt()];
        }
    }
    shapes
}

impl Candidate {
    /// Number of shapes that are estimated; the fixed ones come after them.
    pub fn free_shapes(&self) -> usize {
        self.shapes.iter().filter(|s| !s.is_fixed()).count()
    }

    /// What the columns at `shape` are kept under.
    fn key(&self, shape: &[f64]) -> ColumnKey {
        let bits = shape.iter().map(|v| v.to_bits()).collect();
        (self.effect.code().into(), self.form, self.joints.clone(), bits)
    }

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

    pub fn is_distortion(&self) -> bool {
        self.effect.kind() == EffectKind::Distortion
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
            let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
            (0..shape.len())
                .map(|i| self.bounds.get(i).copied().unwrap_or(unlimited))
                .collect()
        } else {
            self.shapes.iter().map(|s| [s.low, s.high]).collect()
        };
        Term {
            effect: self.effect.clone(),
            form: self.form,
            joints: self.joints.clone(),
            coefficients: coefficients.to_vec(),
            shape: shape.to_vec(),
            free_shapes: if distortion { shape.len() } else { self.free_shapes() },
            bounds,
        }
    }
}

/// Columns of a candidate at a shape over all stretches, whitened; from the coarse forms of the stretches, whose torques are good
/// enough to find what is worth fitting.
pub(crate) fn columns_of(data: &Data, system: &System, candidate: &Candidate, shapes: &[Vec<f64>]) -> Whitened {
    data.cancel.leave_if_set();
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let made: Vec<Shaped> = shapes
        .iter()
        .map(|shape| shaped(data, system, &coarse, candidate, shape))
        .collect();
    system.whitened_shaped(data, &coarse, &side_by_side(made.iter(), coarse.len()))
}

/// The same of the grid's shapes, which every scan asks for again: what the measured motion alone decides is kept.
pub(crate) fn columns_on_grid(data: &Data, system: &System, candidate: &Candidate, shapes: &[Vec<f64>]) -> Whitened {
    data.cancel.leave_if_set();
    let lasting = !candidate.is_distortion() && !candidate.effect.reads_torques();
    if !lasting || system.thinned(data).iter().any(|t| t.moved) {
        return columns_of(data, system, candidate, shapes);
    }
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let kept: Vec<Arc<Shaped>> = shapes
        .iter()
        .map(|shape| {
            data.columns
                .get(candidate.key(shape), || shaped(data, system, &coarse, candidate, shape))
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
    let of = |(i, (stretch, e)): (usize, (&&Stretch, &Thinned))| {
        let columns = if candidate.is_distortion() {
            distortion(system, stretch, &system.present(data)[i], candidate)
        } else {
            let scene = e.scene(system, stretch);
            candidate.effect.columns(candidate.form, &scene, &candidate.joints, shape)
        };
        stretch.shaped_columns(columns)
    };
    coarse.iter().zip(system.thinned(data)).enumerate().map(of).collect()
}

fn distortion(system: &System, stretch: &Stretch, present: &Present, candidate: &Candidate) -> Vec<Column> {
    let zero = candidate.term(&vec![0.0; candidate.effect.steps().len()], &[]);
    let known = Some(present.known());
    let derivative = system
        .model
        .distortion_columns(stretch, &present.undistorted, &zero, None, known);
    let column = |rows: Vec<Vec<f64>>| Column {
        rows: rows
            .into_iter()
            .enumerate()
            .filter(|(_, r)| r.iter().any(|v| *v != 0.0))
            .collect(),
    };
    derivative.into_iter().map(column).collect()
}

/// Joints whose rows a candidate reaches.
pub(crate) fn reach(candidate: &Candidate, joints: usize) -> Vec<usize> {
    match candidate.effect.kind() {
        EffectKind::Additive if candidate.effect.code() == "torque_crosstalk" || candidate.effect.code() == "unexplained" => {
            vec![candidate.joints[0]]
        }
        EffectKind::Additive => candidate.effect.acts_on(candidate.form, &candidate.joints),
        _ if candidate.effect.code() == "friction_drift" || candidate.effect.code() == "torque_gain" => candidate.joints.clone(),
        _ => (0..joints).collect(),
    }
}
