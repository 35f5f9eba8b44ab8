//! A dataset with its data changed: rounded, thinned, halved, or behind another filter.

use super::dataset::Stretch;
use super::decimation::coarse_filter;
use crate::preparation::PreparedLog;
use crate::preparation::filter::LowPass;
use std::sync::Arc;

impl Stretch {
    pub(crate) fn with_torques(mut self, change: impl Fn(f64) -> f64) -> Self {
        let periods = self.periods.iter_mut().flatten();
        periods.chain(self.torque.iter_mut()).flatten().for_each(|v| *v = change(*v));
        self
    }

    /// The same with half of its rows.
    pub(crate) fn every_second_row(mut self) -> Self {
        fn half<T: Copy>(all: &mut Vec<T>) {
            *all = all.iter().step_by(2).copied().collect();
        }
        // Rows next to a reversal are left out before the filter hides which they are.
        self.usable = (0..self.joints()).map(|j| self.kept(&self.motion, j)).collect();
        self.torque.iter_mut().chain(self.periods.iter_mut().flatten()).for_each(half);
        self.usable.iter_mut().chain(&mut self.resting).for_each(half);
        half(&mut self.samples);
        let filter = self.filter.take();
        let rows = move |columns: &[&[f64]]| -> Vec<Vec<f64>> {
            let mut all = match &filter {
                Some(filter) => filter(columns),
                None => columns.iter().map(|x| x.to_vec()).collect(),
            };
            all.iter_mut().for_each(half);
            all
        };
        Self {
            filter: Some(Arc::new(rows)),
            periodic: false,
            coarse: None,
            unfiltered: None,
            ..self
        }
    }

    /// The same with the rows alone that `keep` says, by number and count.
    fn with_rows(mut self, keep: impl Fn(usize, usize) -> bool) -> Self {
        let count = self.rows();
        let marks = self.usable.iter_mut().flat_map(|u| u.iter_mut().enumerate());
        marks.for_each(|(s, u)| *u &= keep(s, count));
        self
    }

    /// One half of the periods, or of the rows where there are none. Of an odd number of periods the one in the middle belongs to
    /// both.
    pub(crate) fn half(self, which: usize) -> Option<Self> {
        let count = self.periods.len();
        if count == 0 {
            return Some(self.with_rows(|s, all| (2 * s >= all) == (which == 1)));
        }
        if count < 4 {
            return None;
        }
        let part: Vec<usize> = match which {
            0 => (0..count.div_ceil(2)).collect(),
            _ => (count / 2..count).collect(),
        };
        Some(Self {
            torque: self.mean_over(&part),
            periods: part.iter().map(|&p| self.periods[p].clone()).collect(),
            starts: part.iter().map(|&p| self.starts[p]).collect(),
            ..self
        })
    }

    /// The same log behind a filter with `factor` times the cut-off; `None` where it goes through none, or repeats.
    pub(crate) fn with_cutoff(&self, factor: f64) -> Option<Self> {
        let source = self.source.as_ref()?;
        let old = source.row_filter.columns.as_ref()?;
        let filter = LowPass::butterworth(old.order, factor * old.cutoff_hz, old.rate_hz).ok()?;
        let mut prepared = PreparedLog::clone(source);
        prepared.row_filter.torque = Some(filter.clone());
        prepared.row_filter.columns = Some(filter);
        let step = prepared.row_filter.decimation as f64 / factor;
        prepared.row_filter.decimation = step.round().max(1.0) as usize;
        let fine = Self::from_periods(&prepared, Vec::new(), self.starts.clone());
        let coarse = coarse_filter(&prepared.row_filter).map(|(first, step, filter)| fine.thinned(first, step, filter));
        let changed = Self { coarse, ..fine };
        match self.recorded {
            Some(recorded) => changed.behind(recorded),
            None => Some(changed),
        }
    }
}
