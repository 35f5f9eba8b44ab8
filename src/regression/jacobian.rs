//! What the augmented model predicts along a motion, and how that changes with every parameter.

use super::dataset::{ShapedRows, Stretch};
use super::model::{AugmentedModel, Term};
use super::present::KnownTorque;
use crate::dynamics::{Coulomb, Motion};
use crate::effects::{Column, Motions, Scene};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A model's rows over one stretch.
#[derive(Clone)]
pub(crate) struct Evaluated {
    /// The motion of the motors after all distortions.
    pub motion: Motion,
    /// n × M, shaped.
    pub torque: Vec<Vec<f64>>,
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
    pub gain: Vec<f64>,
    /// Per joint, `(parameter, values)` of every column that is not zero there; shaped.
    pub jacobian: ShapedRows,
}

impl AugmentedModel {
    /// Torque of every joint over the rows of a stretch; n × M [N·m or N].
    pub fn predict(&self, stretch: &Stretch) -> Vec<Vec<f64>> {
        self.evaluate(stretch, None).torque
    }

    /// How the torque along a motion changes with every parameter of the effects, per joint:
    /// `(parameter, values over the samples)` of every column that is not zero there, parameters counted over the terms from 0
    /// (coefficients, then free shapes) [N·m or N per unit of it]. For designing a motion that determines the effects beside the
    /// base parameters: their columns stand next to the regressor's. The columns of a distortion are those of the declared
    /// torque.
    ///
    /// `interval` is the time between samples (s); `periodic` says whether the sample after the last is the first.
    pub fn effect_columns(&self, motion: &Motion, interval: f64, periodic: bool) -> Vec<Vec<(usize, Vec<f64>)>> {
        let stretch = Stretch::of_motion(motion.clone(), interval, periodic);
        let nothing = vec![Vec::new(); self.robot.joint_count()];
        let base = self.values.len();
        let derivatives = self.evaluate(&stretch, Some(&nothing)).jacobian;
        let own = |columns: Vec<(usize, Vec<f64>)>| {
            let effects = columns.into_iter().filter(|(at, _)| *at >= base);
            effects.map(|(at, values)| (at - base, values)).collect()
        };
        derivatives.into_iter().map(own).collect()
    }

    /// Torque over the rows of a stretch, and, where the base parameters' rows along its undistorted motion are handed in, the
    /// derivatives; without those of the base parameters where the rows are empty.
    pub(crate) fn evaluate(&self, stretch: &Stretch, base: Option<&ShapedRows>) -> Evaluated {
        let distorted = self.terms.iter().any(Term::is_distortion);
        // Along the measured motion of a distorted model they are asked for by what bends with the load alone.
        let needed = !distorted || self.terms.iter().any(|t| t.effect.distorts_by_load());
        let plain = match needed {
            true => self.torques(Motions::stiff(&stretch.motion), &self.robot, None),
            false => Default::default(),
        };
        let world = self.world(stretch, &plain, None);
        let robot = self.robot.with_gravity(world.gravity);
        let (mut jacobian, here) = match base {
            Some(rows) if !distorted => (rows.clone(), plain.clone()),
            Some(_) => {
                let (set, rows) = self.fill(&robot, world.motions());
                let block = |j: usize| {
                    let mut columns = stretch.shaped_block(&rows, j, set.row(j));
                    let values = columns.iter_mut().flat_map(|c| &mut c.1);
                    values.for_each(|v| *v *= world.gain[j]);
                    columns
                };
                let jacobian = (0..self.robot.joint_count()).into_par_iter().map(block).collect();
                (jacobian, self.torques(world.motions(), &robot, Some((&set, &rows))))
            }
            None if distorted => (Vec::new(), self.torques(world.motions(), &robot, None)),
            None => (Vec::new(), plain.clone()),
        };
        let scene = Scene {
            robot: &robot,
            motion: &world.motion,
            rigid: &here.rigid,
            declared: &here.declared,
            interval: stretch.interval,
            periodic: stretch.periodic,
            coulomb: Coulomb::Sign,
        };
        let mut torque = here.declared.clone();
        let effects: Vec<usize> = (0..self.terms.len()).filter(|&t| !self.terms[t].is_distortion()).collect();
        let of = |&t: &usize| self.contribution(t, &scene, stretch, base.map(|_| &world.gain[..]));
        let contributions: Vec<Contribution> = effects.par_iter().map(of).collect();
        for (t, (columns, derivatives)) in effects.into_iter().zip(contributions) {
            add_columns(&mut torque, &columns, &self.terms[t].coefficients);
            for (j, at, values) in derivatives {
                jacobian[j].push((at, values));
            }
        }
        if base.is_some_and(|rows| rows.iter().any(|r| !r.is_empty())) {
            self.push_torque_derivatives(&mut jacobian, stretch, &scene, &world);
        }
        let gained = torque.into_iter().zip(&world.gain);
        let torque = stretch.shaped(gained.map(|(row, g)| row.into_iter().map(|v| v * g).collect()).collect());
        if base.is_some() && distorted {
            let known = KnownTorque {
                world: &world,
                declared: &here.declared,
            };
            self.push_distortions(&mut jacobian, stretch, &plain, known);
        }
        Evaluated {
            motion: world.motion,
            torque,
            rigid: here.rigid,
            declared: here.declared,
            gain: world.gain,
            jacobian,
        }
    }
}

/// Columns of a term over the samples, and per joint and parameter its derivatives over the rows.
type Contribution = (Vec<Column>, Vec<(usize, usize, Vec<f64>)>);

impl AugmentedModel {
    /// Columns of term `at`, and with the `gain` of every joint their derivatives.
    fn contribution(&self, at: usize, scene: &Scene, stretch: &Stretch, gain: Option<&[f64]>) -> Contribution {
        let term = &self.terms[at];
        let columns = term.effect.columns(term.form, scene, &term.joints, &term.shape);
        let derivatives = gain.map_or(Vec::new(), |gain| {
            let shapes = shape_derivatives(term, scene);
            let all = columns.iter().chain(&shapes).zip(self.offset_of(at)..);
            let rows = all.flat_map(|(column, at)| column.rows.iter().map(move |(j, values)| (*j, at, values)));
            let gained = |(j, at, values): (usize, usize, &Vec<f64>)| ((j, at), values.iter().map(|v| v * gain[j]).collect());
            let shaped = stretch.shaped_with(rows.map(gained)).into_iter();
            shaped.map(|((j, at), values)| (j, at, values)).collect()
        });
        (columns, derivatives)
    }
}

fn add_columns(torque: &mut [Vec<f64>], columns: &[Column], coefficients: &[f64]) {
    for (column, &c) in columns.iter().zip(coefficients) {
        for (j, values) in &column.rows {
            torque[*j].iter_mut().zip(values).for_each(|(t, v)| *t += c * v);
        }
    }
}

/// `C c` on the joints that the columns reach.
pub(super) fn summed(columns: Vec<Column>, coefficients: &[f64]) -> BTreeMap<usize, Vec<f64>> {
    let mut rows: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (column, c) in columns.into_iter().zip(coefficients) {
        for (j, values) in column.rows {
            let sum = rows.entry(j).or_insert_with(|| vec![0.0; values.len()]);
            sum.iter_mut().zip(values).for_each(|(t, v)| *t += c * v);
        }
    }
    rows
}

/// `∂(C c)/∂shape` by central differences; a thousandth of the value is far above rounding and far below the curvature of any
/// column.
pub(crate) fn shape_derivatives(term: &Term, scene: &Scene) -> Vec<Column> {
    (0..term.free_shapes)
        .map(|i| {
            let step = 1e-4 * term.shape[i].abs().max(1e-6);
            let torque = |sign: f64| {
                let mut shape = term.shape.clone();
                shape[i] += sign * step;
                let columns = term.effect.columns(term.form, scene, &term.joints, &shape);
                summed(columns, &term.coefficients)
            };
            let (up, down) = (torque(1.0), torque(-1.0));
            let values = |(u, d): (Vec<f64>, Vec<f64>)| u.iter().zip(d).map(|(u, d)| (u - d) / (2.0 * step)).collect();
            let rows = up.into_iter().zip(down.into_values());
            Column {
                rows: rows.map(|((j, u), d)| (j, values((u, d)))).collect(),
            }
        })
        .collect()
}
