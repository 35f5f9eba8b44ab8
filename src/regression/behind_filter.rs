//! A log whose torques were filtered before they were recorded: columns go through the same filter, and rows are taken no closer
//! together than they say something new.

use super::dataset::{Coarse, ColumnFilter, Stretch, Unfiltered, slices};
use super::recorded_filter::RecordedFilter;
use crate::dynamics::{Channel, Motion};
use std::sync::Arc;

impl Stretch {
    /// Whether rows are samples, or means over neighbouring ones, and go through no further filter.
    pub(crate) fn is_plain(&self) -> bool {
        self.filter.is_none() || self.coarse.as_ref().is_some_and(|c| c.stretch.filter.is_none())
    }

    /// The same torques, with columns that go through the filter on their way into the rows. `None` where the motion has too few
    /// samples a second for it.
    pub(crate) fn behind(&self, filter: RecordedFilter) -> Option<Self> {
        self.behind_with(filter, self.step(filter))
    }

    /// The same with every `step`-th row.
    pub(crate) fn behind_with(&self, filter: RecordedFilter, step: usize) -> Option<Self> {
        let coarse = match &self.coarse {
            Some(c) => Some(Coarse {
                stretch: Box::new(Self {
                    recorded: Some(filter),
                    ..c.stretch.every(step, c.stretch.smooth_rows(filter, step)?)
                }),
                ..c.clone()
            }),
            None => None,
        };
        // What changes from one period to the next is looked for where there are any.
        let unfiltered = (!self.periods.is_empty()).then(|| Unfiltered {
            stretch: Arc::new(self.coarse_form().as_rows(step)),
            filter: Arc::new(|rows: &[&[f64]]| rows.iter().map(|r| r.to_vec()).collect()),
        });
        Some(Self {
            coarse,
            recorded: Some(filter),
            unfiltered,
            ..self.every(step, self.smooth_rows(filter, step)?)
        })
    }

    /// Every `step`-th row, with columns that go through no low-pass.
    pub(crate) fn sparse(&self, step: usize) -> Self {
        let rows = self.filter.clone();
        let filter = move |columns: &[&[f64]]| match &rows {
            Some(rows) => rows(columns).iter().map(|x| every(x, step)).collect(),
            None => columns.iter().map(|x| every(x, step)).collect(),
        };
        Self {
            coarse: None,
            unfiltered: None,
            ..self.every(step, Arc::new(filter))
        }
    }

    /// Every how-manieth row says something new behind the filter. It divides the period.
    pub(crate) fn step(&self, filter: RecordedFilter) -> usize {
        let row_s = self.row_interval();
        let most = 1.0 / (2.0 * filter.edge_hz() * row_s);
        let divides = |d: &usize| *d as f64 <= most && self.rows().is_multiple_of(*d);
        (1..=self.rows()).rev().find(divides).unwrap_or(1)
    }

    /// Through the low-pass, then what the rows are made by, then every `step`-th.
    fn smooth_rows(&self, filter: RecordedFilter, step: usize) -> Option<ColumnFilter> {
        let low_pass = filter.made()?;
        let (rows, rate_hz, periodic) = (self.filter.clone(), 1.0 / self.interval, self.periodic);
        Some(Arc::new(move |columns: &[&[f64]]| {
            let smooth = low_pass.through(columns, rate_hz, periodic);
            let all = match &rows {
                Some(rows) => rows(&slices(&smooth)),
                None => smooth,
            };
            all.iter().map(|x| every(x, step)).collect()
        }))
    }

    /// Every `step`-th row, made of the motion by `filter`.
    fn every(&self, step: usize, filter: ColumnFilter) -> Self {
        let rows = |all: &Vec<Vec<f64>>| all.iter().map(|x| every(x, step)).collect::<Vec<_>>();
        let flags = |all: &Vec<Vec<bool>>| all.iter().map(|x| every(x, step)).collect::<Vec<_>>();
        Self {
            torque: rows(&self.torque),
            periods: self.periods.iter().map(rows).collect(),
            samples: every(&self.samples, step),
            usable: flags(&self.usable),
            resting: flags(&self.resting),
            filter: Some(filter),
            ..self.clone()
        }
    }

    /// Every `step`-th row with the sample of the motion that it stands for, and no filter: what changes between the periods is
    /// looked for here.
    fn as_rows(&self, step: usize) -> Self {
        let at = every(&(0..self.motion.samples()).collect::<Vec<_>>(), step);
        let channel = |c: &Channel| c.with(&every(&c.values, step));
        let channels = |all: &[Channel]| all.iter().map(channel).collect::<Vec<_>>();
        let motion = Motion::from_fn(self.joints(), at.len(), |j, s| self.motion.get(j, at[s]));
        Self {
            motion: motion.with_channels(channels(self.motion.channels())),
            channel_periods: self.channel_periods.iter().map(|p| channels(p)).collect(),
            interval: self.interval * step as f64,
            filter: None,
            coarse: None,
            unfiltered: None,
            samples: (0..at.len()).collect(),
            ..self.every(step, Arc::new(|_: &[&[f64]]| Vec::new()))
        }
    }
}

fn every<T: Clone>(values: &[T], step: usize) -> Vec<T> {
    values.iter().step_by(step).cloned().collect()
}
