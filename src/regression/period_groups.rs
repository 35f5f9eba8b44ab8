//! Groups of consecutive periods, each with a mean of its own: what follows a slow quantity, such as a temperature, differs
//! between them, and the mean over all hides it.

use super::dataset::Stretch;
use crate::dynamics::Channel;
use std::ops::Range;

/// Groups of one log at most: eight values of a quantity tell a straight line from a curve, and every group costs as much as a
/// log.
const MOST_GROUPS: usize = 8;

impl Stretch {
    /// The same log as groups of two periods or more, whose scatter still shows the noise. The motion is the mean over all
    /// periods; further quantities are means over the group. A log without periods, or with fewer than four, stays one.
    pub(crate) fn in_groups(&self) -> Vec<Self> {
        let periods = self.periods.len();
        let groups = (periods / 2).min(MOST_GROUPS);
        if groups < 2 || self.channel_periods.len() != periods {
            return vec![self.clone()];
        }
        (0..groups)
            .map(|g| self.group(g * periods / groups..(g + 1) * periods / groups))
            .collect()
    }

    fn group(&self, range: Range<usize>) -> Self {
        let which: Vec<usize> = range.clone().collect();
        let channels = mean_channels(&self.channel_periods[range.clone()]);
        let mut group = Self {
            torque: self.mean_over(&which),
            periods: self.periods[range.clone()].to_vec(),
            starts: self.starts[range.clone()].to_vec(),
            channel_periods: self.channel_periods[range].to_vec(),
            motion: self.motion.clone().with_channels(channels),
            coarse: self.coarse.clone(),
            unfiltered: None,
            ..self.clone()
        };
        if let Some(coarse) = &self.coarse {
            let mut coarse = coarse.clone();
            coarse.stretch.motion = group.coarse_motion(&group.motion);
            coarse.stretch.torque.clone_from(&group.torque);
            coarse.stretch.periods.clone_from(&group.periods);
            coarse.stretch.starts.clone_from(&group.starts);
            group.coarse = Some(coarse);
        }
        group
    }
}

/// Means over periods, sample by sample.
fn mean_channels(periods: &[Vec<Channel>]) -> Vec<Channel> {
    let mean = |c: usize| {
        let first = &periods[0][c];
        let at = |s: usize| periods.iter().map(|p| p[c].values[s]).sum::<f64>() / periods.len() as f64;
        first.with(&(0..first.values.len()).map(at).collect::<Vec<_>>())
    };
    (0..periods[0].len()).map(mean).collect()
}
