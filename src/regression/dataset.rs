//! Measured torque along a motion, as the tracing sees it.

use super::recorded_filter::RecordedFilter;
use super::rows::clear_of_reversals;
use crate::dynamics::{Channel, Motion, RowBlocks};
use crate::effects::{Column, Span};
use crate::preparation::{Exclusion, MotionError, PreparedLog};
use std::sync::Arc;

/// A linear filter (with decimation, perhaps) that the torque has been through, and that every column must go through alike:
/// columns of N samples to columns of M rows.
pub type ColumnFilter = Arc<dyn Fn(&[&[f64]]) -> Vec<Vec<f64>> + Send + Sync>;

/// Per joint, `(parameter, values over the rows)` of every column that is not zero there.
pub(crate) type ShapedRows = Vec<Vec<(usize, Vec<f64>)>>;

/// Rows of a matrix, borrowed.
pub(crate) fn slices(rows: &[Vec<f64>]) -> Vec<&[f64]> {
    rows.iter().map(Vec::as_slice).collect()
}

/// One stretch of motion with its torque: the average over the periods of a log, or the log itself.
#[derive(Clone)]
pub struct Stretch {
    /// Name of the log.
    pub name: String,
    /// N samples, before the filter.
    pub motion: Motion,
    /// Mean torque over the periods, after the filter; n × M (M = N without filter) [N·m or N].
    pub torque: Vec<Vec<f64>>,
    /// Torque of every period; P × n × M. Empty where the log does not repeat.
    pub periods: Vec<Vec<Vec<f64>>>,
    /// When every period began on the log's clock (s).
    pub starts: Vec<f64>,
    /// Further quantities in every period, over the samples of the motion; P lists, or none where the log has none.
    pub channel_periods: Vec<Vec<Channel>>,
    /// Time between samples of the motion (s).
    pub interval: f64,
    /// Whether the sample after the last is the first.
    pub periodic: bool,
    /// Sample of the motion that every row stands for, M.
    pub samples: Vec<usize>,
    /// Rows that count; n × M. None of a joint whose torque takes no part.
    pub usable: Vec<Vec<bool>>,
    /// Rows that would count, but that a joint rests at; n × M.
    pub resting: Vec<Vec<bool>>,
    /// Per joint: why it has no rows that count, where it has none.
    pub excluded: Vec<Option<Exclusion>>,
    /// Per joint: standard deviation that recording has added to a torque [N·m or N]; no noise is less.
    pub resolution: Vec<f64>,
    /// Per joint: what is not known of its motion, which no period shows.
    pub motion_error: Vec<MotionError>,
    /// What the torque had been through before it was recorded, where that is known; columns go through it in `filter`.
    pub(crate) recorded: Option<RecordedFilter>,
    /// What torque and columns go through; `None` where every sample is a row.
    pub filter: Option<ColumnFilter>,
    /// The same rows from fewer samples, where a filter leaves most of them without say.
    pub coarse: Option<Coarse>,
    /// The periods before the filter; `None` where there is no filter, or where nothing repeats.
    pub unfiltered: Option<Unfiltered>,
    /// The log before the filter, of one that does not repeat.
    pub(crate) source: Option<Arc<PreparedLog>>,
}

/// Periods as they were measured, and the filter on the way to the rows.
///
/// What changes from one period to the next is looked for here: a filter spreads a touch over the rows around it, brings the
/// start of a period to its end, and leaves noise that goes together over more rows than a model of it has terms.
#[derive(Clone)]
pub struct Unfiltered {
    /// The same stretch before the filter.
    pub stretch: Arc<Stretch>,
    pub(crate) filter: ColumnFilter,
}

impl Unfiltered {
    /// Rows of some torques of all joints, n × N.
    pub(crate) fn rows(&self, torque: &[Vec<f64>]) -> Vec<Vec<f64>> {
        (self.filter)(&slices(torque))
    }
}

impl std::fmt::Debug for Stretch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Stretch({}, {} samples, {} periods)",
            self.name,
            self.motion.samples(),
            self.periods.len()
        )
    }
}

impl Stretch {
    /// Number of joints n.
    pub fn joints(&self) -> usize {
        self.torque.len()
    }

    /// Turns the sign of the torque of `joint`.
    pub fn turn(&mut self, joint: usize) {
        let periods = self.periods.iter_mut().map(|p| &mut p[joint]);
        periods.chain([&mut self.torque[joint]]).flatten().for_each(|v| *v = -*v);
        if let Some(before) = &mut self.unfiltered {
            Arc::make_mut(&mut before.stretch).turn(joint);
        }
        if let Some(source) = &mut self.source {
            Arc::make_mut(source).torque[joint].iter_mut().for_each(|v| *v = -*v);
        }
    }

    /// Whether the torque of `joint` takes part.
    pub fn has_rows(&self, joint: usize) -> bool {
        self.usable[joint].contains(&true)
    }

    /// Rows per joint.
    pub fn rows(&self) -> usize {
        self.torque[0].len()
    }

    /// Time between rows (s).
    pub fn row_interval(&self) -> f64 {
        self.interval * self.motion.samples() as f64 / self.rows().max(1) as f64
    }

    /// How many measurements each value of the mean torque stands for.
    pub fn repetitions(&self) -> usize {
        self.periods.len().max(1)
    }

    /// Lists of `values` over the motion as they enter the rows.
    pub(crate) fn shaped(&self, values: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        match &self.filter {
            Some(filter) => filter(&slices(&values)),
            None => values,
        }
    }

    /// Columns of a block of rows of the regressor with their numbers, as they enter the rows.
    pub(crate) fn shaped_block(&self, rows: &RowBlocks, joint: usize, columns: &[usize]) -> Vec<(usize, Vec<f64>)> {
        let values = rows.block(joint).chunks_exact(rows.stride()).map(|v| &v[..rows.samples()]);
        let values: Vec<&[f64]> = values.collect();
        let shaped = match &self.filter {
            Some(filter) => filter(&values),
            None => values.into_iter().map(<[f64]>::to_vec).collect(),
        };
        columns.iter().copied().zip(shaped).collect()
    }

    /// Values with a key each, as they enter the rows.
    pub(crate) fn shaped_with<K>(&self, values: impl IntoIterator<Item = (K, Vec<f64>)>) -> Vec<(K, Vec<f64>)> {
        let (keys, values): (Vec<K>, Vec<Vec<f64>>) = values.into_iter().unzip();
        keys.into_iter().zip(self.shaped(values)).collect()
    }

    /// Columns over the motion as they enter the rows.
    pub(crate) fn shaped_columns(&self, columns: Vec<Column>) -> Vec<Column> {
        let mut shaped: Vec<Column> = columns.iter().map(|_| Column { rows: Vec::new() }).collect();
        let rows = columns.into_iter().enumerate();
        let rows = rows.flat_map(|(k, column)| column.rows.into_iter().map(move |(j, values)| ((k, j), values)));
        for ((k, j), values) in self.shaped_with(rows) {
            shaped[k].rows.push((j, values));
        }
        shaped
    }

    /// Rows of `joint` that can be compared with a model whose (distorted) motion is `motion`: usable ones, but not those at a
    /// reversal, where a fraction of a sample decides on the sign of Coulomb friction.
    ///
    /// A filtered stretch keeps them, unless its filter is a mean over a few samples: there the jump is filtered alike on both
    /// sides.
    pub(crate) fn kept(&self, motion: &Motion, joint: usize) -> Vec<bool> {
        let mut keep = self.usable[joint].clone();
        let binned = self.coarse.as_ref().filter(|c| c.stretch.filter.is_none());
        if self.filter.is_some() && binned.is_none() {
            return keep;
        }
        let step = binned.map_or(1, |c| c.step);
        let clear = clear_of_reversals(motion.velocities(joint), self.periodic);
        keep.iter_mut()
            .zip(clear.chunks(step))
            .for_each(|(k, bin)| *k &= bin.iter().all(|c| *c));
        keep
    }

    /// The same with the rows at which the joint rests: what touches the arm shows there as well.
    pub(crate) fn kept_or_resting(&self, motion: &Motion, joint: usize) -> Vec<bool> {
        let mut keep = self.kept(motion, joint);
        keep.iter_mut().zip(&self.resting[joint]).for_each(|(k, r)| *k |= r);
        keep
    }

    /// Means over the periods in `which`, n × M.
    pub(crate) fn mean_over(&self, which: &[usize]) -> Vec<Vec<f64>> {
        let scale = 1.0 / which.len() as f64;
        let mean = |j: usize, s: usize| which.iter().map(|&p| self.periods[p][j][s]).sum::<f64>() * scale;
        (0..self.joints())
            .map(|j| (0..self.rows()).map(|s| mean(j, s)).collect())
            .collect()
    }
}

/// Travel and speed of every joint over all stretches.
pub(crate) fn spans(stretches: &[Stretch]) -> Vec<Span> {
    let extreme = |j: usize, f: fn(&Motion, usize) -> &[f64], low: bool| {
        let values = stretches.iter().flat_map(|s| f(&s.motion, j).iter().copied());
        if low {
            values.fold(f64::INFINITY, f64::min)
        } else {
            values.fold(f64::NEG_INFINITY, f64::max)
        }
    };
    (0..stretches[0].joints())
        .map(|j| {
            let highest = extreme(j, Motion::positions, false);
            let range = highest - extreme(j, Motion::positions, true);
            let speed = extreme(j, Motion::velocities, false).max(-extreme(j, Motion::velocities, true));
            // Rows, not samples, limit what can be distinguished where a filter thins them out.
            let thinned = stretches[0].motion.samples() as f64 / stretches[0].rows().max(1) as f64;
            Span {
                range,
                highest,
                speed,
                interval: stretches[0].interval * thinned,
                speed_error: stretches.iter().map(|s| s.motion_error[j].std_dev[1]).fold(0.0, f64::max),
            }
        })
        .collect()
}

/// Every `step`-th sample from `first` (or the mean of it and the next), and a filter of the same cut-off at that rate: good to a
/// few percent of a jump of the sign, ten times cheaper, and used to find what is worth fitting.
#[derive(Debug, Clone)]
pub struct Coarse {
    pub first: usize,
    pub step: usize,
    /// Samples that the mean is taken over: one, or the two in the middle of a bin of an even number. One of them alone would be
    /// half a sample early or late, and that is a delay.
    pub width: usize,
    pub stretch: Box<Stretch>,
}
