//! Regressor and added columns side by side, and the derivative of the criterion through the added ones.

use super::{Added, AddedColumn, Course};
use crate::dynamics::{ColumnSet, Coulomb, Motion, MotionGradient, RowBlocks};
use nalgebra::DMatrix;

/// `[Y_b, C]` joint by joint over a block of samples, and derivatives with respect to C over all samples.
#[derive(Debug, Clone)]
pub(in super::super) struct Beside {
    source: Added,
    /// Columns of `Y_b`.
    base: usize,
    interval: f64,
    /// Of the motion.
    stride: usize,
    /// Per joint: the added columns that are not zero there, over all samples, and which each of them is.
    added: Vec<Vec<(usize, Vec<f64>)>>,
    /// Per joint: derivatives by those; `stride` values each.
    weights: Vec<Vec<f64>>,
    /// Per joint: the base columns, then the added ones, over the block; of the block's stride.
    blocks: Vec<Vec<f64>>,
    /// Per joint, which column each of them is.
    outputs: Vec<Vec<usize>>,
}

/// Steps of central differences in q, in units of [rad or m]; the fastest ripple known (400 cycles a turn) errs by 3e-6 of its
/// slope there.
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
            added: vec![Vec::new(); joints],
            weights: vec![Vec::new(); joints],
            blocks: vec![Vec::new(); joints],
            outputs: vec![Vec::new(); joints],
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

    /// Computes the added columns along a motion.
    pub fn see(&mut self, motion: &Motion, coulomb: Coulomb) {
        self.added.iter_mut().for_each(Vec::clear);
        for column in self.source.along(&self.course(motion, coulomb)) {
            for (j, values) in column.rows {
                self.added[j].push((column.at, values));
            }
        }
        for (weights, added) in self.weights.iter_mut().zip(&self.added) {
            weights.resize(added.len() * self.stride, 0.0);
        }
    }

    /// Puts the added columns beside the rows of the block of samples that begins with `first`.
    pub fn join(&mut self, columns: &ColumnSet, rows: &RowBlocks, first: usize) {
        let (stride, samples) = (rows.stride(), rows.samples());
        for (j, added) in self.added.iter().enumerate() {
            let (block, outputs) = (&mut self.blocks[j], &mut self.outputs[j]);
            block.clear();
            block.extend_from_slice(rows.block(j));
            outputs.clear();
            outputs.extend_from_slice(columns.row(j));
            for (at, values) in added {
                outputs.push(self.base + at);
                block.extend_from_slice(&values[first..first + samples]);
                block.resize(outputs.len() * stride, 0.0);
            }
        }
    }

    /// Derivatives by the added columns of a joint over the block that begins with sample `first`, as [`Self::block`] has them.
    pub fn set_weights(&mut self, joint: usize, first: usize, of_block: &[f64]) {
        let columns = self.added[joint].len();
        if columns == 0 {
            return;
        }
        let block_stride = of_block.len() / columns;
        let samples = block_stride.min(self.stride - first);
        for (to, from) in self.weights[joint]
            .chunks_exact_mut(self.stride)
            .zip(of_block.chunks_exact(block_stride))
        {
            to[first..first + samples].copy_from_slice(&from[..samples]);
        }
    }

    /// The derivative by the values of an added column on a joint's rows; `None` where the column is zero.
    fn weights_of(&self, joint: usize, at: usize) -> Option<&[f64]> {
        let place = self.added[joint].iter().rposition(|(c, _)| *c == at)?;
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

    /// Adds the derivative through columns that look at other samples, by the coefficients of the series (rows of `to`), whose
    /// parts of the motion are the columns of `basis`.
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
