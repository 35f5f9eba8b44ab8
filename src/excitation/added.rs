//! Columns that stand beside the regressor's: of effects the declared model lacks.
//!
//! What they are is the business of whoever hands them in ([`AddedColumns`]); here they join `Y_b` in the Gram matrix, and its derivative is
//! taken back through them to the motion. Columns of one sample's state are differenced variable by variable, all samples at once;
//! columns that look at other samples are differenced coefficient by coefficient of the series.

use crate::dynamics::{ColumnSet, Coulomb, Motion, MotionGradient, RowBlocks};
use nalgebra::DMatrix;
use std::fmt::Debug;
use std::sync::Arc;

/// One stretch of motion that columns are evaluated along.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a> {
    pub motion: &'a Motion,
    /// Time between samples (s).
    pub interval: f64,
    /// Whether the sample after the last is the first.
    pub periodic: bool,
    pub coulomb: Coulomb,
}

/// The torque per unit of one parameter: rows of the joints named, zero on all others.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedColumn {
    /// From 0.
    pub at: usize,
    /// `(joint, value at every sample)` [N·m or N per unit of the parameter].
    pub rows: Vec<(usize, Vec<f64>)>,
}

/// A source of columns, in groups that are evaluated together.
pub trait AddedColumns: Debug + Send + Sync {
    /// Columns of all groups.
    fn count(&self) -> usize;

    fn groups(&self) -> usize;

    fn columns(&self, group: usize, course: &Course) -> Vec<AddedColumn>;

    /// Joints whose motion changes the columns of a group.
    fn joints(&self, group: usize) -> Vec<usize>;

    /// Whether a sample's values depend on that sample's state alone.
    fn is_local(&self, group: usize) -> bool;
}

/// A shared source of columns; equal when it is the same one.
#[derive(Debug, Clone)]
pub struct Added(pub Arc<dyn AddedColumns>);

impl PartialEq for Added {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Added {
    /// Every column along a motion.
    pub(super) fn along(&self, course: &Course) -> Vec<AddedColumn> {
        (0..self.0.groups()).flat_map(|g| self.0.columns(g, course)).collect()
    }

    /// Rows joint by joint within a sample, as [`RowBlocks::observation_matrix`] has them.
    pub(super) fn observation_matrix(&self, course: &Course) -> DMatrix<f64> {
        let joints = course.motion.joints();
        let mut matrix = DMatrix::zeros(joints * course.motion.samples(), self.0.count());
        for column in self.along(course) {
            for (j, values) in &column.rows {
                let rows = values.iter().enumerate();
                rows.for_each(|(s, v)| matrix[(s * joints + j, column.at)] = *v);
            }
        }
        matrix
    }
}

/// `[Y_b, C]` joint by joint, and derivatives with respect to it.
#[derive(Debug, Clone)]
pub(super) struct Beside {
    source: Added,
    /// Columns of `Y_b`.
    base: usize,
    interval: f64,
    stride: usize,
    /// Per joint: the base columns, then the added ones that are not zero there; `stride` values each.
    blocks: Vec<Vec<f64>>,
    /// Per joint, which column each of them is.
    outputs: Vec<Vec<usize>>,
    weights: Vec<Vec<f64>>,
}

/// Steps of central differences in q, in units of [rad or m]; the fastest ripple known (400 cycles a turn) errs by 3e-6 of its slope there.
const POSITION_STEP: f64 = 1e-5;
/// The step in velocity, as part of the width of the smooth sign: errs by 2e-7 of its slope.
const VELOCITY_STEP: f64 = 1e-3;
/// Columns are linear in accelerations or nearly so [rad/s² or m/s²].
const ACCELERATION_STEP: f64 = 1e-3;
/// Width of the sign where it is not smoothed [rad/s or m/s]; nobody differentiates there.
const TRUE_SIGN_WIDTH: f64 = 1e-2;

impl Beside {
    pub fn new(source: &Added, base: usize, joints: usize, interval: f64, stride: usize) -> Self {
        Self {
            source: source.clone(),
            base,
            interval,
            stride,
            blocks: vec![Vec::new(); joints],
            outputs: vec![Vec::new(); joints],
            weights: vec![Vec::new(); joints],
        }
    }

    pub fn block(&self, joint: usize) -> &[f64] {
        &self.blocks[joint]
    }

    pub fn outputs(&self, joint: usize) -> &[usize] {
        &self.outputs[joint]
    }

    fn course<'a>(&self, motion: &'a Motion, coulomb: Coulomb) -> Course<'a> {
        Course {
            motion,
            interval: self.interval,
            periodic: true,
            coulomb,
        }
    }

    pub fn fill(&mut self, columns: &ColumnSet, rows: &RowBlocks, motion: &Motion, coulomb: Coulomb) {
        for j in 0..self.blocks.len() {
            self.blocks[j].clear();
            self.blocks[j].extend_from_slice(rows.block(j));
            self.outputs[j].clear();
            self.outputs[j].extend_from_slice(columns.row(j));
        }
        for column in self.source.along(&self.course(motion, coulomb)) {
            for (j, values) in &column.rows {
                self.outputs[*j].push(self.base + column.at);
                self.blocks[*j].extend_from_slice(values);
                let full = self.outputs[*j].len() * self.stride;
                self.blocks[*j].resize(full, 0.0);
            }
        }
    }

    /// Room for the derivative by the block of a joint.
    pub fn weights_mut(&mut self, joint: usize) -> &mut Vec<f64> {
        let size = self.blocks[joint].len();
        self.weights[joint].resize(size, 0.0);
        &mut self.weights[joint]
    }

    /// The derivative by the values of an added column on a joint's rows; `None` where the column is zero.
    fn weights_of(&self, joint: usize, at: usize) -> Option<&[f64]> {
        let place = self.outputs[joint].iter().rposition(|&c| c == self.base + at)?;
        Some(&self.weights[joint][place * self.stride..(place + 1) * self.stride])
    }

    /// `Σ_columns w (above − below)` per sample.
    fn weighted(&self, above: &[AddedColumn], below: &[AddedColumn], samples: usize) -> Vec<f64> {
        let mut sum = vec![0.0; samples];
        for (a, b) in above.iter().zip(below) {
            for ((j, up), (_, down)) in a.rows.iter().zip(&b.rows) {
                let Some(w) = self.weights_of(*j, a.at) else { continue };
                let values = up.iter().zip(down).zip(w);
                sum.iter_mut().zip(values).for_each(|(s, ((u, d), w))| *s += w * (u - d));
            }
        }
        sum
    }

    /// Adds the derivative through columns of one sample's state.
    pub fn add_local(&self, motion: &Motion, coulomb: Coulomb, gradient: &mut MotionGradient) {
        for group in (0..self.source.0.groups()).filter(|g| self.source.0.is_local(*g)) {
            for joint in self.source.0.joints(group) {
                for variable in 0..3 {
                    let step = steps(coulomb)[variable];
                    let at = |by: f64| {
                        let moved = displaced(motion, joint, variable, |_| by);
                        self.source.0.columns(group, &self.course(&moved, coulomb))
                    };
                    let change = self.weighted(&at(step), &at(-step), motion.samples());
                    let to = match variable {
                        0 => &mut gradient.q,
                        1 => &mut gradient.qd,
                        _ => &mut gradient.qdd,
                    };
                    to[joint * self.stride..]
                        .iter_mut()
                        .zip(&change)
                        .for_each(|(g, c)| *g += c / (2.0 * step));
                }
            }
        }
    }

    /// Adds the derivative through columns that look at other samples, by the coefficients of the series (rows of `to`), whose parts of the
    /// motion are the columns of `basis`.
    pub fn add_course(&self, motion: &Motion, coulomb: Coulomb, basis: &[Vec<f64>; 3], to: &mut DMatrix<f64>) {
        for group in (0..self.source.0.groups()).filter(|g| !self.source.0.is_local(*g)) {
            for joint in self.source.0.joints(group) {
                for i in 0..to.nrows() {
                    let step = VELOCITY_STEP * width(coulomb);
                    let part = |d: usize, s: usize| basis[d][i * self.stride + s];
                    let at = |by: f64| {
                        let moved = (0..3).fold(motion.clone(), |m, d| displaced(&m, joint, d, |s| by * part(d, s)));
                        self.source.0.columns(group, &self.course(&moved, coulomb))
                    };
                    let change = self.weighted(&at(step), &at(-step), motion.samples());
                    to[(i, joint)] += change.iter().sum::<f64>() / (2.0 * step);
                }
            }
        }
    }
}

fn width(coulomb: Coulomb) -> f64 {
    match coulomb {
        Coulomb::Smooth(eps) => eps,
        Coulomb::Sign => TRUE_SIGN_WIDTH,
    }
}

fn steps(coulomb: Coulomb) -> [f64; 3] {
    [POSITION_STEP, VELOCITY_STEP * width(coulomb), ACCELERATION_STEP]
}

/// The motion with q, qd or qdd of one joint moved by something at every sample.
fn displaced(motion: &Motion, joint: usize, variable: usize, by: impl Fn(usize) -> f64) -> Motion {
    let mut moved = motion.clone();
    for s in 0..motion.samples() {
        let mut state = motion.get(joint, s);
        state[variable] += by(s);
        moved.set(joint, s, state);
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Chain;
    use crate::effects::{Effect, Kind, Span, all};
    use crate::model::{Friction, Joint, JointKind, Mdh, Robot};
    use crate::parameters::Layout;
    use crate::residual::{AugmentedModel, EffectColumns, Term};
    use crate::trajectory::harmonic;
    use nalgebra::{DVector, Vector3};
    use std::f64::consts::TAU;

    const JOINTS: usize = 3;
    const ORDER: usize = 3;
    const SIZE: usize = 2 * ORDER + 1;
    /// A multiple of the vector units' width: nothing is padded.
    const SAMPLES: usize = 40;
    const FUNDAMENTAL_HZ: f64 = 0.2;
    const INTERVAL: f64 = 1.0 / (FUNDAMENTAL_HZ * SAMPLES as f64);
    const SMOOTH: Coulomb = Coulomb::Smooth(0.1);
    /// Of the central differences that the gradient is held against, in coefficients [rad/s].
    const STEP: f64 = 1e-4;

    /// A sliding joint between two turning ones.
    fn arm() -> Robot {
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
        let joint = |(i, kind): (usize, JointKind)| {
            let mdh = Mdh {
                alpha: 0.8 * i as f64,
                d: 0.1,
                theta: 0.2,
                r: 0.3,
            };
            Joint::from_mdh(format!("j{i}"), kind, mdh)
        };
        let friction = Friction {
            viscous: true,
            coulomb: true,
        };
        let joints = kinds.into_iter().enumerate().map(joint).collect();
        Robot::new("test", Vector3::new(0.0, 2.0, -9.0), joints, friction).unwrap()
    }

    /// Every effect that has columns, in every form; on the middle one of its places, with the middle one of the shapes that a search tries.
    fn terms(robot: &Robot) -> Vec<Term> {
        let mut list = Vec::new();
        for effect in all().iter().filter(|e| e.kind() != Kind::BetweenPeriods) {
            list.extend((0..effect.forms()).map(|form| term(robot, *effect, form)));
        }
        list
    }

    fn term(robot: &Robot, effect: &'static dyn Effect, form: usize) -> Term {
        let places = effect.places(robot);
        let joints = places[places.len() / 2].clone();
        let span = Span {
            range: 1.5,
            speed: 1.2,
            interval: INTERVAL,
        };
        let shapes = effect.shapes(form, &joints, &[span; JOINTS]);
        let (coefficients, shape): (usize, Vec<f64>) = match effect.kind() {
            Kind::Distortion => (0, vec![1e-3; effect.steps().len()]),
            _ => (
                effect.parameters(form, robot, &joints).len() - shapes.len(),
                shapes.iter().map(|s| s.grid[s.grid.len() / 2]).collect(),
            ),
        };
        let term = Term {
            effect,
            form,
            joints,
            coefficients: (0..coefficients).map(|i| 0.7 - 0.4 * i as f64).collect(),
            free_shapes: shape.len(),
            bounds: vec![[f64::NEG_INFINITY, f64::INFINITY]; shape.len()],
            shape,
        };
        assert!(term.is_complete(robot), "{term:?}");
        term
    }

    /// q, qd and qdd per unit of every coefficient.
    fn basis() -> [Vec<f64>; 3] {
        let mut parts = [(); 3].map(|()| vec![0.0; SAMPLES * SIZE]);
        for s in 0..SAMPLES {
            for l in 1..=ORDER {
                let [sine, cosine] = harmonic(TAU * FUNDAMENTAL_HZ, l, s as f64 * INTERVAL);
                for d in 0..3 {
                    parts[d][(l - 1) * SAMPLES + s] = sine[d];
                    parts[d][(ORDER + l - 1) * SAMPLES + s] = cosine[d];
                }
            }
            parts[0][2 * ORDER * SAMPLES + s] = 1.0;
        }
        parts
    }

    fn motion_of(coefficients: &DMatrix<f64>) -> Motion {
        let basis = basis();
        Motion::from_fn(JOINTS, SAMPLES, |j, s| {
            let part = |d: usize| {
                (0..SIZE)
                    .map(|i| coefficients[(i, j)] * basis[d][i * SAMPLES + s])
                    .sum::<f64>()
            };
            [part(0), part(1), part(2)]
        })
    }

    fn columns_along(source: &Added, motion: &Motion) -> Vec<AddedColumn> {
        source.along(&Course {
            motion,
            interval: INTERVAL,
            periodic: true,
            coulomb: SMOOTH,
        })
    }

    /// Any weight for every value; none for values near zero, where what they are made of may change its sign.
    fn weights(columns: &[AddedColumn]) -> Vec<AddedColumn> {
        let weight = |at: usize, j: usize, s: usize, value: f64| {
            if value.abs() < 0.05 {
                0.0
            } else {
                ((5 * at + 3 * j + 7 * s) as f64).sin()
            }
        };
        let of = |column: &AddedColumn| {
            let row = |(j, values): &(usize, Vec<f64>)| -> (usize, Vec<f64>) {
                let numbered = values.iter().enumerate();
                (*j, numbered.map(|(s, v)| weight(column.at, *j, s, *v)).collect())
            };
            AddedColumn {
                at: column.at,
                rows: column.rows.iter().map(row).collect(),
            }
        };
        columns.iter().map(of).collect()
    }

    fn weighted(columns: &[AddedColumn], weights: &[AddedColumn]) -> f64 {
        let values = |all: &[AddedColumn]| -> Vec<f64> {
            let rows = all.iter().flat_map(|c| &c.rows);
            rows.flat_map(|(_, values)| values.iter().copied()).collect()
        };
        values(columns).iter().zip(values(weights)).map(|(v, w)| v * w).sum()
    }

    /// By the coefficients, of the sum of all values with these weights.
    fn gradient(source: &Added, model: &AugmentedModel, motion: &Motion, weights: &[AddedColumn]) -> DMatrix<f64> {
        let robot = &model.robot;
        let set = ColumnSet::new(robot, &Layout::standard(robot), &model.base.kept[..1]);
        let mut rows = RowBlocks::new(&set, SAMPLES);
        rows.fill(&Chain::new(robot), &set, motion, SMOOTH);
        let mut beside = Beside::new(source, set.len(), JOINTS, INTERVAL, motion.stride());
        beside.fill(&set, &rows, motion, SMOOTH);
        (0..JOINTS).for_each(|j| beside.weights_mut(j).fill(0.0));
        for column in weights {
            for (j, values) in &column.rows {
                let place = beside.outputs(*j).iter().rposition(|&c| c == set.len() + column.at);
                let first = place.expect("was filled in") * SAMPLES;
                beside.weights_mut(*j)[first..first + SAMPLES].copy_from_slice(values);
            }
        }
        let (mut local, basis) = (MotionGradient::new(JOINTS, SAMPLES), basis());
        beside.add_local(motion, SMOOTH, &mut local);
        let mut total = DMatrix::from_fn(SIZE, JOINTS, |i, j| {
            let at = |s: usize| {
                let part = local.get(j, s);
                (0..3).map(|d| basis[d][i * SAMPLES + s] * part[d]).sum::<f64>()
            };
            (0..SAMPLES).map(at).sum::<f64>()
        });
        beside.add_course(motion, SMOOTH, &basis, &mut total);
        total
    }

    /// What each effect says of what it reads is true, and the steps fit all of them: the gradient is that of the columns.
    #[test]
    fn prop_gradient_goes_through_the_columns_of_every_effect() {
        let declared = AugmentedModel::declared(&arm());
        let model = AugmentedModel {
            values: DVector::from_fn(declared.values.len(), |i, _| 1.0 + 0.3 * (5.0 * i as f64).sin()),
            ..declared
        };
        let x = DMatrix::from_fn(SIZE, JOINTS, |i, j| 0.5 * (3.2 + 2.1 * i as f64 + 1.7 * j as f64).sin());
        let motion = motion_of(&x);
        // Where a joint turns, hysteresis has no derivative: no sample is so near that the differences come there.
        let slowest = (0..JOINTS)
            .flat_map(|j| motion.velocities(j))
            .fold(f64::INFINITY, |least, v| least.min(v.abs()));
        assert!(slowest > 10.0 * STEP, "{slowest}");
        for term in terms(&model.robot) {
            let source = Added(Arc::new(EffectColumns::new(&model.robot, &[(term.clone(), &model)])));
            let weights = weights(&columns_along(&source, &motion));
            let found = gradient(&source, &model, &motion, &weights);
            // Only an offset is the same on every motion.
            let most = found.amax();
            assert_eq!(most > 0.0, term.effect.code() != "torque_offset", "{term:?}");
            for i in 0..SIZE * JOINTS {
                let at = |by: f64| {
                    let mut moved = x.clone();
                    moved[i] += by;
                    weighted(&columns_along(&source, &motion_of(&moved)), &weights)
                };
                let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                // Columns of distortions are differences themselves: rounding of the torque by the step of the effect and by STEP leaves four
                // digits of the gradient; a joint or a variable left out is a part of order one.
                assert!(
                    (difference - found[i]).abs() <= 1e-3 * most,
                    "{term:?} coefficient {i}: {difference} {}, the largest is {most}",
                    found[i]
                );
            }
        }
    }
}
