//! The observation matrix: the paper's (8), joint by joint.
//!
//! Row j of the regressor is zero except in the columns of joint j and of the links it carries, so W is kept as one dense block per
//! joint. Rows that are left out (gaps, dead zone) are zero rows: they weigh nothing and keep the others evenly spaced in time.

use super::PreparedLog;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// What belongs to the rows of one joint, besides W.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRows {
    /// Model column of every column of the joint's part of W.
    pub columns: Vec<usize>,
    /// R.
    pub torque: DVector<f64>,
    /// Which rows are data; the others are zero.
    pub used: Vec<bool>,
    /// Standard deviation that recording has added to a torque: no residual is known better [N m or N].
    pub resolution: f64,
}

impl JointRows {
    pub fn used_rows(&self) -> usize {
        self.used.iter().filter(|&&u| u).count()
    }

    /// The entries of `values`, over the whole model, that act on this joint.
    pub(super) fn own(&self, values: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.columns.len(), self.columns.iter().map(|&c| values[c]))
    }
}

/// All rows that one log gives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    pub joints: Vec<JointRows>,
    /// Number of model columns p: base parameters first, then whatever was added.
    pub columns: usize,
    /// Sample of the prepared log that every row stands for, R.
    pub samples: Vec<usize>,
    /// W, filtered and decimated like the torque: R × w per joint.
    pub matrices: Vec<DMatrix<f64>>,
}

/// Doubles that regressor columns may take before they are filtered and decimated (32 MB): longer logs go through in several
/// passes over the kinematics, which is cheap.
const BLOCK_BUDGET: usize = 4 << 20;

impl Observation {
    /// Columns of the base parameters `base` of `robot` over a prepared log.
    pub fn new(robot: &Robot, base: &BaseParameters, log: &PreparedLog) -> Self {
        Self::of_columns(robot, &base.kept, log)
    }

    /// Columns of the standard parameters `wanted` (indices into [`Layout::standard`]), in that order.
    pub fn of_columns(robot: &Robot, wanted: &[usize], log: &PreparedLog) -> Self {
        let set = ColumnSet::new(robot, &Layout::standard(robot), wanted);
        let samples: Vec<usize> = log.row_filter.rows(log.samples()).collect();
        let joints: Vec<JointRows> = (0..log.joints())
            .map(|j| {
                let used = used_rows(robot, log, j, &samples);
                JointRows {
                    columns: set.row(j).to_vec(),
                    torque: masked(log.row_filter.torque_rows(&log.torque[j]), &used),
                    used,
                    resolution: log.resolution[j],
                }
            })
            .collect();
        let mut observation = Self {
            joints,
            columns: wanted.len(),
            samples,
            matrices: Vec::new(),
        };
        observation.fill(robot, wanted, log);
        observation
    }

    /// Makes W, some columns at a time.
    fn fill(&mut self, robot: &Robot, wanted: &[usize], log: &PreparedLog) {
        let layout = Layout::standard(robot);
        let mut data: Vec<Vec<f64>> = vec![Vec::new(); self.joints.len()];
        self.joints.iter_mut().for_each(|rows| rows.columns.clear());
        let batch = (BLOCK_BUDGET / (log.samples() * log.joints()).max(1)).clamp(1, wanted.len().max(1));
        let chain = Chain::new(robot);
        let stretches: Vec<Motion> = stretches(log.samples()).map(|range| log.motion.stretch(range)).collect();
        for (start, part) in wanted.chunks(batch).enumerate().map(|(i, part)| (i * batch, part)) {
            let set = ColumnSet::new(robot, &layout, part);
            let fill = |motion: &Motion| {
                let mut blocks = RowBlocks::new(&set, motion.samples());
                blocks.fill(&chain, &set, motion, Coulomb::Sign);
                blocks
            };
            let blocks: Vec<RowBlocks> = stretches.par_iter().map(fill).collect();
            self.joints
                .par_iter_mut()
                .zip(&mut data)
                .enumerate()
                .for_each(|(j, (rows, data))| {
                    rows.columns.extend(set.row(j).iter().map(|output| start + output));
                    data.reserve_exact(set.row(j).len() * rows.used.len());
                    (0..set.row(j).len()).for_each(|k| push_rows(&blocks, j, k, log, &rows.used, data));
                });
        }
        let matrix = |(rows, data): (&JointRows, Vec<f64>)| DMatrix::from_vec(self.samples.len(), rows.columns.len(), data);
        self.matrices = self.joints.iter().zip(data).map(matrix).collect();
    }

    /// Predicted torques for every one of several parameter sets of the whole model, per joint and set, R each.
    pub fn predict(&self, sets: &[&DVector<f64>]) -> Vec<Vec<DVector<f64>>> {
        let of = |(rows, matrix): (&JointRows, &DMatrix<f64>)| sets.iter().map(|values| matrix * rows.own(values)).collect();
        self.joints.iter().zip(&self.matrices).map(of).collect()
    }

    /// Measured minus predicted torque, per joint R; zero in rows that are not used.
    pub fn residuals(&self, values: &DVector<f64>) -> Vec<DVector<f64>> {
        let predicted = self.predict(&[values]);
        let error = |(rows, mut sets): (&JointRows, Vec<DVector<f64>>)| &rows.torque - sets.swap_remove(0);
        self.joints.iter().zip(predicted).map(error).collect()
    }

    /// Adds one model column that acts on the given joints, and returns its number. Each entry is (joint, N values at the samples of
    /// `log`); they go through the same filter, decimation and row selection as the regressor.
    pub fn push_column(&mut self, log: &PreparedLog, entries: &[(usize, &[f64])]) -> usize {
        let number = self.columns;
        self.columns += 1;
        for &(j, values) in entries {
            let column = self.column_rows(log, j, values);
            self.joints[j].columns.push(number);
            let matrix = &mut self.matrices[j];
            let at = matrix.ncols();
            *matrix = std::mem::replace(matrix, DMatrix::zeros(0, 0)).insert_column(at, 0.0);
            matrix.set_column(at, &column);
        }
        number
    }

    /// Adds one constant column per joint (torque offsets), and returns the number of the first.
    pub fn push_offsets(&mut self, log: &PreparedLog) -> usize {
        let ones = vec![1.0; log.samples()];
        let first = self.columns;
        for j in 0..self.joints.len() {
            self.push_column(log, &[(j, &ones)]);
        }
        first
    }

    /// Rows of a column of joint `j`, without adding it: N values in, R values out.
    pub fn column_rows(&self, log: &PreparedLog, j: usize, values: &[f64]) -> DVector<f64> {
        masked(log.row_filter.column_rows(values), &self.joints[j].used)
    }
}

/// Rows of joint `j` that are data: its torque takes part, their sample is usable (and so is everything the filter reaches), and the joint moves fast
/// enough for its direction to be known, where the model has a Coulomb term.
fn used_rows(robot: &Robot, log: &PreparedLog, j: usize, samples: &[usize]) -> Vec<bool> {
    if log.excluded[j].is_some() {
        return vec![false; samples.len()];
    }
    let reach = log.row_filter.torque.as_ref().map_or(0, |f| f.settling_samples());
    let slowest = if robot.friction().coulomb { log.dead_zone[j] } else { 0.0 };
    let speed = log.motion.velocities(j);
    let mut broken = vec![0usize];
    for (s, &usable) in log.usable.iter().enumerate() {
        broken.push(broken[s] + usize::from(!usable));
    }
    let intact = |s: usize| broken[(s + reach + 1).min(log.samples())] == broken[s.saturating_sub(reach)];
    samples.iter().map(|&s| intact(s) && speed[s].abs() >= slowest).collect()
}

/// Samples whose regressor is made in one go; threads share the stretches.
const STRETCH: usize = 1024;

fn stretches(samples: usize) -> impl Iterator<Item = Range<usize>> {
    (0..samples)
        .step_by(STRETCH)
        .map(move |start| start..(start + STRETCH).min(samples))
}

/// Appends the rows of column `k` of joint `j`, which is spread over the stretches of `blocks`.
fn push_rows(blocks: &[RowBlocks], j: usize, k: usize, log: &PreparedLog, used: &[bool], data: &mut Vec<f64>) {
    let part = |block: &RowBlocks| {
        let start = k * block.stride();
        start..start + block.samples()
    };
    let masked = |(&v, &used): (&f64, &bool)| if used { v } else { 0.0 };
    if log.row_filter.takes_all() {
        for (block, used) in blocks.iter().zip(used.chunks(STRETCH)) {
            data.extend(block.block(j)[part(block)].iter().zip(used).map(masked));
        }
        return;
    }
    let column: Vec<f64> = blocks
        .iter()
        .flat_map(|block| &block.block(j)[part(block)])
        .copied()
        .collect();
    data.extend(log.row_filter.column_rows(&column).iter().zip(used).map(masked));
}

fn masked(values: Vec<f64>, used: &[bool]) -> DVector<f64> {
    DVector::from_iterator(values.len(), values.iter().zip(used).map(|(&v, &u)| if u { v } else { 0.0 }))
}
