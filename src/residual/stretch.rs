//! Measured torque along a motion, as the tracing sees it.

use super::coarse::{Coarse, coarse_filter};
use super::perturbation::source_of;
use crate::dynamics::Motion;
use crate::effects::{Column, Span};
use crate::identification::preprocess::Exclusion;
use crate::identification::{Log, PreparedLog};
use std::sync::Arc;

/// A linear filter (with decimation, perhaps) that the torque has been through, and that every column must go through alike.
pub type ColumnFilter = Arc<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// One stretch of motion with its torque: the average over the periods of a log, or the log itself.
#[derive(Clone)]
pub struct Stretch {
    pub name: String,
    /// N samples, before the filter.
    pub motion: Motion,
    /// Mean torque over the periods, after the filter; n × M (M = N without filter) [N·m or N].
    pub torque: Vec<Vec<f64>>,
    /// Torque of every period; P × n × M. Empty where the log does not repeat.
    pub periods: Vec<Vec<Vec<f64>>>,
    /// When every period began on the log's clock (s).
    pub starts: Vec<f64>,
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
    pub filter: Option<ColumnFilter>,
    /// The same rows from fewer samples, where a filter leaves most of them without say.
    pub coarse: Option<Coarse>,
    /// The periods before the filter; `None` where there is no filter, or where nothing repeats.
    pub unfiltered: Option<Unfiltered>,
    /// The log before the filter, of one that does not repeat.
    pub(super) source: Option<Arc<PreparedLog>>,
}

/// Periods as they were measured, and the filter on the way to the rows.
///
/// What changes from one period to the next is looked for here: a filter spreads a touch over the rows around it, brings the start of a period to its end, and leaves noise
/// that goes together over more rows than a model of it has terms.
#[derive(Clone)]
pub struct Unfiltered {
    pub stretch: Arc<Stretch>,
    filter: ColumnFilter,
}

impl Unfiltered {
    /// Rows of some torques of all joints, n × N.
    pub(crate) fn rows(&self, torque: &[Vec<f64>]) -> Vec<Vec<f64>> {
        torque.iter().map(|t| (self.filter)(t)).collect()
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

    /// How many measurements each value of the mean torque stands for.
    pub fn repetitions(&self) -> usize {
        self.periods.len().max(1)
    }

    /// `values` over the motion as they enter the rows.
    pub(crate) fn shaped(&self, values: Vec<f64>) -> Vec<f64> {
        match &self.filter {
            Some(filter) => filter(&values),
            None => values,
        }
    }

    /// A column over the motion as it enters the rows.
    pub(crate) fn shaped_column(&self, column: Column) -> Column {
        let rows = column.rows.into_iter();
        Column {
            rows: rows.map(|(j, values)| (j, self.shaped(values))).collect(),
        }
    }

    /// Rows of `joint` that can be compared with a model whose (distorted) motion is `motion`: usable ones, but not those at a reversal,
    /// where a fraction of a sample decides on the sign of Coulomb friction.
    ///
    /// A filtered stretch keeps them, unless its filter is a mean over a few samples: there the jump is filtered alike on both sides.
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

/// Samples that are neither at a reversal nor so slow that the sign is a matter of the derivative's own ripple: a thousandth of the top
/// speed.
fn clear_of_reversals(v: &[f64], periodic: bool) -> Vec<bool> {
    let n = v.len();
    let slowest = 1e-3 * v.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    let mut clear: Vec<bool> = v.iter().map(|v| v.abs() >= slowest).collect();
    let next = |s: usize| if s + 1 < n { Some(s + 1) } else { periodic.then_some(0) };
    for s in 0..n {
        let Some(t) = next(s) else { continue };
        if v[s] * v[t] <= 0.0 {
            let before = if s > 0 { Some(s - 1) } else { periodic.then_some(n - 1) };
            [before, Some(s), Some(t), next(t)]
                .into_iter()
                .flatten()
                .for_each(|at| clear[at] = false);
        }
    }
    clear
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
            let range = extreme(j, Motion::positions, false) - extreme(j, Motion::positions, true);
            let speed = extreme(j, Motion::velocities, false).max(-extreme(j, Motion::velocities, true));
            // Rows, not samples, limit what can be told apart where a filter thins them out.
            let thinned = stretches[0].motion.samples() as f64 / stretches[0].rows().max(1) as f64;
            Span {
                range,
                speed,
                interval: stretches[0].interval * thinned,
            }
        })
        .collect()
}

impl Stretch {
    /// A motion without a measurement: all torques zero.
    pub fn of_motion(motion: Motion, interval: f64, periodic: bool) -> Self {
        let (joints, samples) = (motion.joints(), motion.samples());
        Self {
            name: "motion".into(),
            motion,
            torque: vec![vec![0.0; samples]; joints],
            periods: Vec::new(),
            starts: vec![0.0],
            interval,
            periodic,
            samples: (0..samples).collect(),
            usable: vec![vec![true; samples]; joints],
            resting: vec![vec![false; samples]; joints],
            excluded: vec![None; joints],
            resolution: vec![0.0; joints],
            filter: None,
            coarse: None,
            unfiltered: None,
            source: None,
        }
    }

    /// From a prepared log and the record it was prepared from, which has the periods one by one.
    pub fn new(prepared: &PreparedLog, log: &Log) -> Self {
        let filter = &prepared.row_filter;
        let fine = Self {
            unfiltered: Self::before_filter(prepared, log),
            ..Self::fine(prepared, log)
        };
        let coarse = coarse_filter(filter).map(|(first, step, filter)| fine.thinned(first, step, filter));
        Self { coarse, ..fine }.in_bins()
    }

    /// Its periods before the filter, where there is one.
    fn before_filter(prepared: &PreparedLog, log: &Log) -> Option<Unfiltered> {
        let filter = prepared.row_filter.clone();
        let repeats = prepared.periods.as_ref().is_some_and(|p| p.count >= 2);
        if !repeats || filter.torque.is_none() && filter.takes_all() {
            return None;
        }
        let stretch = Arc::new(Self::fine(&prepared.before_filter(), log));
        let filter = Arc::new(move |x: &[f64]| filter.torque_rows(x));
        Some(Unfiltered { stretch, filter })
    }

    /// With all its samples.
    fn fine(prepared: &PreparedLog, log: &Log) -> Self {
        let n = prepared.samples();
        let (mut periods, mut starts) = (Vec::new(), vec![prepared.start_s]);
        if let Some(p) = prepared.periods.as_ref().filter(|p| p.count >= 2) {
            // What is no measurement deviates from nothing.
            let usable = p.usable(log);
            let measured = |(t, mean): (&Vec<f64>, &Vec<f64>)| {
                let mut unfolded = p.unfold(t).into_owned();
                let values = unfolded.iter_mut().zip(&usable).enumerate();
                values.filter(|(_, (_, u))| !**u).for_each(|(s, (v, _))| *v = mean[s % n]);
                unfolded
            };
            let unfolded: Vec<Vec<f64>> = log.tau.iter().zip(&prepared.torque).map(measured).collect();
            let rows = |k: usize| {
                unfolded
                    .iter()
                    .map(|t| prepared.row_filter.torque_rows(&t[k * n..(k + 1) * n]))
                    .collect()
            };
            periods = (0..p.count).map(rows).collect();
            starts = (0..p.count).map(|k| prepared.start_s + k as f64 * p.period_s).collect();
        }
        Self::of(prepared, periods, starts)
    }

    /// From a prepared log with the torques of its periods, if it has any.
    pub(super) fn of(prepared: &PreparedLog, periods: Vec<Vec<Vec<f64>>>, starts: Vec<f64>) -> Self {
        let n = prepared.samples();
        let filter = prepared.row_filter.clone();
        let sound: Vec<Vec<bool>> = (0..prepared.joints()).map(|j| usable_rows(prepared, j)).collect();
        let rests: Vec<Vec<bool>> = (0..prepared.joints()).map(|j| resting_rows(prepared, j)).collect();
        let both = |moves: bool| {
            let row = |(s, r): (&Vec<bool>, &Vec<bool>)| s.iter().zip(r).map(|(s, r)| *s && *r != moves).collect();
            sound.iter().zip(&rests).map(row).collect::<Vec<Vec<bool>>>()
        };
        let plain = filter.torque.is_none() && filter.columns.is_none() && filter.edges == 0 && filter.decimation == 1;
        Self {
            name: prepared.name.clone(),
            motion: Motion::clone(&prepared.motion),
            torque: prepared.torque.iter().map(|t| prepared.row_filter.torque_rows(t)).collect(),
            periods,
            starts,
            interval: 1.0 / prepared.rate_hz,
            periodic: prepared.is_periodic() && plain,
            samples: prepared.row_filter.rows(n).collect(),
            usable: both(true),
            resting: both(false),
            excluded: prepared.excluded.clone(),
            resolution: prepared.resolution.clone(),
            filter: (!plain).then(|| Arc::new(move |x: &[f64]| filter.column_rows(x)) as ColumnFilter),
            coarse: None,
            unfiltered: None,
            source: source_of(prepared),
        }
    }
}

/// Rows at which a joint rests, the torque's filter reached from either side.
fn resting_rows(prepared: &PreparedLog, joint: usize) -> Vec<bool> {
    let rests = at_rest(prepared.motion.velocities(joint), 1.0 / prepared.rate_hz);
    prepared.row_filter.rows(prepared.samples()).map(|s| rests[s]).collect()
}

/// Share of a joint's top speed (99 % of its samples are slower) below which it hardly moves.
const SLOW: f64 = 0.05;
/// Time (s) that a joint hardly moves for when it rests: a reversal at ordinary accelerations passes [`SLOW`] in a tenth of that.
const REST_S: f64 = 0.5;

/// Samples at which a joint rests: locked-in friction holds it then, any torque between the two levels of Coulomb friction, which is no function of the state. A
/// joint that never moves does not rest, it is not there.
pub(crate) fn at_rest(speeds: &[f64], interval: f64) -> Vec<bool> {
    let mut sorted: Vec<f64> = speeds.iter().map(|v| v.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let top = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    let mut rests = vec![false; speeds.len()];
    let fewest = (REST_S / interval).ceil() as usize;
    let mut from = 0;
    for s in 0..=speeds.len() {
        if s < speeds.len() && speeds[s].abs() < SLOW * top {
            continue;
        }
        if s - from >= fewest.max(1) {
            rests[from..s].fill(true);
        }
        from = s + 1;
    }
    rests
}

/// Rows whose samples are data as far as the filter reaches, and where the joint moves fast enough for its direction to be known.
fn usable_rows(prepared: &PreparedLog, joint: usize) -> Vec<bool> {
    if prepared.excluded[joint].is_some() {
        return vec![false; prepared.row_filter.rows(prepared.samples()).len()];
    }
    let reach = prepared.row_filter.torque.as_ref().map_or(0, |f| f.settling_samples());
    let speed = prepared.motion.velocities(joint);
    let n = prepared.samples();
    let mut gaps = vec![0usize];
    prepared
        .usable
        .iter()
        .enumerate()
        .for_each(|(s, &u)| gaps.push(gaps[s] + usize::from(!u)));
    // Single samples that were interpolated do not spoil a row that a filter makes of hundreds; a twentieth of them does.
    let intact = |s: usize| {
        let (from, to) = (s.saturating_sub(reach), (s + reach + 1).min(n));
        20 * (gaps[to] - gaps[from]) <= if reach > 0 { to - from } else { 0 }
    };
    prepared
        .row_filter
        .rows(n)
        .map(|s| intact(s) && speed[s].abs() >= prepared.dead_zone[joint])
        .collect()
}
