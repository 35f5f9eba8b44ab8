//! What preprocessing hands on.

use super::average::{Periods, Scatter};
use super::motion_error::MotionError;
use super::options::Choice;
use super::row_filter::RowFilter;
use super::torque_column::Exclusion;
use crate::dynamics::Motion;
use std::sync::Arc;

/// A log ready for least squares: one motion, the torques that belong to it, and how rows are made of both.
///
/// `motion` and `torque` are on the same uniform grid of N samples. Torque is *not* filtered here: [`PreparedLog::row_filter`] is
/// what both torque and regressor columns go through, and whatever adds columns sends them the same way.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedLog {
    /// Name of the log.
    pub name: String,
    /// Samples of `motion` per second; for a log that repeats, N samples to the period.
    pub rate_hz: f64,
    /// Time of sample 0 on the log's own clock (s).
    pub start_s: f64,
    /// q, qd, qdd: averaged over periods where the log repeats. Shared with the rows that are made of it.
    pub motion: Arc<Motion>,
    /// Per joint, N torques [N m or N], averaged like the motion.
    pub torque: Vec<Vec<f64>>,
    /// Samples that are data; false inside gaps of the record, and where a caller leaves an interval out.
    pub usable: Vec<bool>,
    /// `None` for a log taken as one stretch.
    pub periods: Option<Periods>,
    /// Noise measured without a model; `None` with fewer than two periods.
    pub scatter: Option<Scatter>,
    /// How rows are made of samples.
    pub row_filter: RowFilter,
    /// Per joint: rows below this speed are left out [rad/s or m/s].
    pub dead_zone: Vec<f64>,
    /// Per joint: why its torque takes no part, where it does not. Such a joint has no rows.
    pub excluded: Vec<Option<Exclusion>>,
    /// Per joint: standard deviation that recording has added to a torque sample, steps of the file or the converter over √12 [N
    /// m or N].
    pub resolution: Vec<f64>,
    /// Per joint: what is not known of its motion.
    pub motion_error: Vec<MotionError>,
    /// Every decision, and why.
    pub choices: Vec<Choice>,
}

impl PreparedLog {
    /// Number of joints n.
    pub fn joints(&self) -> usize {
        self.torque.len()
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.usable.len()
    }

    /// Cut-off of the filter that torque and columns of a log that does not repeat go through (Hz).
    pub fn band_hz(&self) -> Option<f64> {
        let filter = self.row_filter.columns.as_ref().filter(|_| !self.is_periodic());
        filter.map(|f| f.cutoff_hz)
    }

    /// True when the motion is one period of something that goes round: filters and derivatives then have no ends.
    pub fn is_periodic(&self) -> bool {
        self.periods.is_some()
    }

    /// Periods that a sample of torque is the mean of.
    pub fn averaged(&self) -> usize {
        self.periods.as_ref().map_or(1, |p| p.count)
    }

    /// Time of sample `s` on the log's own clock (s).
    pub fn time(&self, s: usize) -> f64 {
        self.start_s + s as f64 / self.rate_hz
    }

    /// The same without a filter: every sample is a row, as it is. Without scatter, which is of no use to rows.
    pub(crate) fn before_filter(&self) -> Self {
        Self {
            name: self.name.clone(),
            motion: Arc::clone(&self.motion),
            torque: self.torque.clone(),
            usable: self.usable.clone(),
            periods: self.periods.clone(),
            scatter: None,
            row_filter: RowFilter::none(),
            dead_zone: self.dead_zone.clone(),
            excluded: self.excluded.clone(),
            resolution: self.resolution.clone(),
            motion_error: self.motion_error.clone(),
            choices: Vec::new(),
            ..*self
        }
    }

    /// Leaves samples out of everything that is made from this log from now on (an interval in contact, say).
    pub fn leave_out(&mut self, samples: std::ops::Range<usize>) {
        let end = samples.end.min(self.usable.len());
        self.usable[samples.start.min(end)..end].fill(false);
    }
}
