//! The coarse form of a stretch: the same rows from fewer samples, or rows that are means over neighbouring ones.

use super::dataset::{Coarse, Stretch};
use crate::dynamics::{Channel, Motion};
use crate::preparation::RowFilter;
use crate::preparation::filter::LowPass;
use crate::regression::settings::SETTINGS;
use std::sync::Arc;

/// Rows that a period keeps at least: two hundred a second, which is what the slower controllers record and friction and ripples
/// are seen by, but no fewer than a hundred to the fastest of twenty harmonics, and of long periods no more than twice that.
fn fewest_rows(period_s: f64) -> usize {
    (200.0 * period_s).clamp(2000.0, 4000.0) as usize
}

impl Stretch {
    /// Values over the motion on the samples that the coarse form stands on; all of them where there is none.
    pub(crate) fn coarse_values(&self, values: &[f64]) -> Vec<f64> {
        let (first, step, width) = self.coarse.as_ref().map_or((0, 1, 1), |c| (c.first, c.step, c.width));
        let mean = |s: usize| values[s..s + width].iter().sum::<f64>() / width as f64;
        (first..values.len() + 1 - width).step_by(step).map(mean).collect()
    }

    /// A motion on those samples.
    pub(crate) fn coarse_motion(&self, motion: &Motion) -> Motion {
        let of = |rows: fn(&Motion, usize) -> &[f64]| -> Vec<Vec<f64>> {
            (0..self.joints()).map(|j| self.coarse_values(rows(motion, j))).collect()
        };
        let (q, qd, qdd) = (of(Motion::positions), of(Motion::velocities), of(Motion::accelerations));
        let channels = motion.channels().iter().map(|c| c.with(&self.coarse_values(&c.values)));
        Motion::from_fn(self.joints(), q[0].len(), |j, s| [q[j][s], qd[j][s], qdd[j][s]]).with_channels(channels.collect())
    }

    pub(crate) fn coarse_form(&self) -> &Stretch {
        self.coarse.as_ref().map_or(self, |c| &c.stretch)
    }

    /// The coarse form with this stretch's torque, which may have been cleaned or turned round since it was made.
    pub(crate) fn as_coarse(&self) -> Self {
        Self {
            torque: self.torque.clone(),
            periods: self.periods.clone(),
            ..self.coarse_form().clone()
        }
    }

    /// Rows that are means over neighbouring samples, where a period has many more samples than its course has turns: torque and
    /// columns alike, so that nothing changes but the number of rows. The coarse form has the samples in the middle of the bins.
    pub(crate) fn in_bins(self) -> Self {
        let samples = self.motion.samples();
        let fewest = fewest_rows(samples as f64 * self.interval);
        let step = (2..=samples / fewest).rev().find(|d| samples.is_multiple_of(*d));
        let Some(step) = step.filter(|_| self.filter.is_none() && !self.periods.is_empty()) else {
            return self;
        };
        let mean = move |x: &[f64]| -> Vec<f64> {
            x.chunks_exact(step)
                .map(|bin| bin.iter().sum::<f64>() / step as f64)
                .collect()
        };
        let all = |rows: &Vec<Vec<f64>>| rows.iter().map(|r| mean(r)).collect::<Vec<_>>();
        let whole = |row: &Vec<bool>| {
            row.chunks_exact(step)
                .map(|bin| bin.iter().all(|v| *v))
                .collect::<Vec<bool>>()
        };
        let bins = |rows: &Vec<Vec<bool>>| rows.iter().map(whole).collect::<Vec<_>>();
        let rows = samples / step;
        let (first, width) = if step % 2 == 0 { (step / 2 - 1, 2) } else { (step / 2, 1) };
        let middle_of = |values: &[f64], s: usize| {
            let from = first + s * step;
            values[from..from + width].iter().sum::<f64>() / width as f64
        };
        let state = |j: usize, s: usize| {
            let m = &self.motion;
            [m.positions(j), m.velocities(j), m.accelerations(j)].map(|v| middle_of(v, s))
        };
        let in_middle = |c: &Channel| c.with(&(0..rows).map(|s| middle_of(&c.values, s)).collect::<Vec<_>>());
        let channels = |all: &[Channel]| all.iter().map(in_middle).collect::<Vec<_>>();
        let middle = Self {
            motion: Motion::from_fn(self.joints(), rows, state).with_channels(channels(self.motion.channels())),
            channel_periods: self.channel_periods.iter().map(|p| channels(p)).collect(),
            torque: all(&self.torque),
            periods: self.periods.iter().map(all).collect(),
            usable: bins(&self.usable),
            resting: bins(&self.resting),
            interval: self.interval * step as f64,
            ..self.clone()
        };
        Self {
            torque: middle.torque.clone(),
            periods: middle.periods.clone(),
            samples: (0..rows).map(|s| first + s * step).collect(),
            usable: middle.usable.clone(),
            resting: middle.resting.clone(),
            filter: Some(Arc::new(move |columns: &[&[f64]]| columns.iter().map(|x| mean(x)).collect())),
            coarse: Some(Coarse {
                first,
                step,
                width,
                stretch: Box::new(middle),
            }),
            ..self
        }
    }

    pub(crate) fn thinned(&self, first: usize, step: usize, filter: RowFilter) -> Coarse {
        let picked: Vec<usize> = (first..self.motion.samples()).step_by(step).collect();
        let rows = self.rows();
        // The last row may lie on a sample that thinning has cut off.
        let columns = move |x: &[&[f64]]| {
            let mut columns = filter.column_rows(x);
            columns
                .iter_mut()
                .for_each(|y| y.resize(rows, y.last().copied().unwrap_or(0.0)));
            columns
        };
        let at = |c: &Channel| c.with(&picked.iter().map(|&s| c.values[s]).collect::<Vec<_>>());
        let channels = self.motion.channels().iter().map(at);
        let stretch = Box::new(Self {
            motion: Motion::from_fn(self.joints(), picked.len(), |j, s| self.motion.get(j, picked[s]))
                .with_channels(channels.collect()),
            interval: self.interval * step as f64,
            filter: Some(Arc::new(columns)),
            periods: Vec::new(),
            ..self.clone()
        });
        Coarse {
            first,
            step,
            width: 1,
            stretch,
        }
    }
}

/// First sample, step, and the filter at the lower rate; `None` where hardly anything would be saved.
pub(crate) fn coarse_filter(fine: &RowFilter) -> Option<(usize, usize, RowFilter)> {
    let columns = fine.columns.as_ref()?;
    let step = (2..=fine.decimation / SETTINGS.coarse_samples_per_row)
        .rev()
        .find(|step| fine.decimation.is_multiple_of(*step))?;
    let filter = LowPass::butterworth(columns.order, columns.cutoff_hz, columns.rate_hz / step as f64).ok()?;
    let rows = RowFilter {
        torque: None,
        columns: Some(filter),
        padding: fine.padding,
        edges: fine.edges / step,
        decimation: fine.decimation / step,
    };
    Some((fine.edges % step, step, rows))
}
