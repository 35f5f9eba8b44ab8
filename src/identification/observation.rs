//! The observation matrix: the paper's (8), joint by joint.
//!
//! Row j of the regressor is zero except in the columns of joint j and of the links it carries, so W is kept as one dense block per
//! joint. Rows that are left out (gaps, dead zone) are zero rows: they weigh nothing and keep the others evenly spaced in time.
//! What would fill the memory is not kept: [`Observation::for_each_block`] then makes it afresh, some rows at a time.

use super::PreparedLog;
use super::row_maker::RowMaker;
use crate::dynamics::{Chain, ColumnSet, Coulomb, RowBlocks};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// What belongs to the rows of one joint, besides W.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRows {
    /// Model column of every column of the joint's part of W.
    pub columns: Vec<usize>,
    /// R.
    pub torque: DVector<f64>,
    /// Which rows are data; the others are zero.
    pub used: Vec<bool>,
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
    matrices: Matrices,
}

/// W, filtered and decimated like the torque.
#[derive(Debug, Clone, PartialEq)]
enum Matrices {
    /// R × w per joint.
    Held(Vec<DMatrix<f64>>),
    /// The regressor's columns are made when they are asked for; those added later, per joint, are here.
    Made {
        maker: Box<RowMaker>,
        added: Vec<Vec<DVector<f64>>>,
    },
}

impl Default for Matrices {
    fn default() -> Self {
        Self::Held(Vec::new())
    }
}

/// Doubles that regressor columns may take before they are filtered and decimated (32 MB): longer logs go through in several
/// passes over the kinematics, which is cheap.
const BLOCK_BUDGET: usize = 4 << 20;
/// Doubles of W that are held: all. Rows made in blocks differ from held ones by more than rounding at the cuts of a filter.
const HELD: usize = usize::MAX;

impl Observation {
    /// Columns of the base parameters `base` of `robot` over a prepared log.
    pub fn new(robot: &Robot, base: &BaseParameters, log: &PreparedLog) -> Self {
        Self::of_columns(robot, &base.kept, log)
    }

    /// Columns of the standard parameters `wanted` (indices into [`Layout::standard`]), in that order.
    pub fn of_columns(robot: &Robot, wanted: &[usize], log: &PreparedLog) -> Self {
        Self::holding(HELD, robot, wanted, log)
    }

    /// The same, with W held in memory as long as it is no more than `most` numbers, or one period.
    pub fn holding(most: usize, robot: &Robot, wanted: &[usize], log: &PreparedLog) -> Self {
        let set = ColumnSet::new(robot, &Layout::standard(robot), wanted);
        let samples: Vec<usize> = log.row_filter.rows(log.samples()).collect();
        let joints: Vec<JointRows> = (0..log.joints())
            .map(|j| {
                let used = used_rows(robot, log, j, &samples);
                JointRows {
                    columns: set.row(j).to_vec(),
                    torque: masked(log.row_filter.torque_rows(&log.torque[j]), &used),
                    used,
                }
            })
            .collect();
        let width: usize = (0..log.joints()).map(|j| set.row(j).len()).sum();
        let mut observation = Self {
            joints,
            columns: wanted.len(),
            samples,
            matrices: Matrices::default(),
        };
        if log.is_periodic() || width * observation.samples.len() <= most {
            observation.hold(robot, wanted, log);
        } else {
            observation.matrices = Matrices::Made {
                maker: Box::new(RowMaker::new(robot, set, log)),
                added: vec![Vec::new(); log.joints()],
            };
        }
        observation
    }

    fn hold(&mut self, robot: &Robot, wanted: &[usize], log: &PreparedLog) {
        let layout = Layout::standard(robot);
        let mut data: Vec<Vec<f64>> = vec![Vec::new(); self.joints.len()];
        self.joints.iter_mut().for_each(|rows| rows.columns.clear());
        let batch = (BLOCK_BUDGET / (log.samples() * log.joints()).max(1)).clamp(1, wanted.len().max(1));
        let chain = Chain::new(robot);
        for (start, part) in wanted.chunks(batch).enumerate().map(|(i, part)| (i * batch, part)) {
            let set = ColumnSet::new(robot, &layout, part);
            let mut blocks = RowBlocks::new(&set, log.samples());
            blocks.fill(&chain, &set, &log.motion, Coulomb::Sign);
            self.joints
                .par_iter_mut()
                .zip(&mut data)
                .enumerate()
                .for_each(|(j, (rows, data))| {
                    for (column, &output) in blocks.block(j).chunks_exact(blocks.stride()).zip(set.row(j)) {
                        rows.columns.push(start + output);
                        let column = log.row_filter.column_rows(&column[..log.samples()]);
                        data.extend(column.iter().zip(&rows.used).map(|(&v, &used)| if used { v } else { 0.0 }));
                    }
                });
        }
        let matrix = |(rows, data): (&JointRows, Vec<f64>)| DMatrix::from_vec(self.samples.len(), rows.columns.len(), data);
        self.matrices = Matrices::Held(self.joints.iter().zip(data).map(matrix).collect());
    }

    /// Whether W is in memory.
    pub fn is_held(&self) -> bool {
        matches!(self.matrices, Matrices::Held(_))
    }

    /// Hands W out: the first row of a block, and the block's rows per joint. Blocks follow each other, the last may be shorter, and
    /// what is held is one block.
    pub fn for_each_block(&self, mut take: impl FnMut(usize, &[DMatrix<f64>])) {
        let (maker, added) = match &self.matrices {
            Matrices::Held(matrices) => return take(0, matrices),
            Matrices::Made { maker, added } => (maker, added),
        };
        let rows = maker.rows_per_block(self.samples.len());
        for first in (0..self.samples.len()).step_by(rows) {
            let range = first..(first + rows).min(self.samples.len());
            let mut block = maker.rows(&self.samples[range.clone()]);
            for ((matrix, added), rows) in block.iter_mut().zip(added).zip(&self.joints) {
                let width = matrix.ncols();
                let mut whole = std::mem::replace(matrix, DMatrix::zeros(0, 0)).insert_columns(width, added.len(), 0.0);
                for (k, column) in added.iter().enumerate() {
                    whole.set_column(width + k, &column.rows(first, range.len()));
                }
                for (r, _) in range.clone().enumerate().filter(|(_, r)| !rows.used[*r]) {
                    whole.row_mut(r).fill(0.0);
                }
                *matrix = whole;
            }
            take(first, &block);
        }
    }

    /// Predicted torques for every one of several parameter sets of the whole model, per joint and set, R each.
    pub fn predict(&self, sets: &[&DVector<f64>]) -> Vec<Vec<DVector<f64>>> {
        let empty = vec![DVector::zeros(self.samples.len()); sets.len()];
        let mut found = vec![empty; self.joints.len()];
        self.for_each_block(|first, block| {
            for ((rows, matrix), found) in self.joints.iter().zip(block).zip(&mut found) {
                for (values, torque) in sets.iter().zip(found) {
                    torque
                        .rows_mut(first, matrix.nrows())
                        .gemv(1.0, matrix, &rows.own(values), 0.0);
                }
            }
        });
        found
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
            match &mut self.matrices {
                Matrices::Made { added, .. } => added[j].push(column),
                Matrices::Held(matrices) => {
                    let at = matrices[j].ncols();
                    let mut matrix = std::mem::replace(&mut matrices[j], DMatrix::zeros(0, 0)).insert_column(at, 0.0);
                    matrix.set_column(at, &column);
                    matrices[j] = matrix;
                }
            }
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

/// Rows of joint `j` that are data: their sample is usable (and so is everything the filter reaches), and the joint moves fast
/// enough for its direction to be known, where the model has a Coulomb term.
fn used_rows(robot: &Robot, log: &PreparedLog, j: usize, samples: &[usize]) -> Vec<bool> {
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

fn masked(values: Vec<f64>, used: &[bool]) -> DVector<f64> {
    DVector::from_iterator(values.len(), values.iter().zip(used).map(|(&v, &u)| if u { v } else { 0.0 }))
}
