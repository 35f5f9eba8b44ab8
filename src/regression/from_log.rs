//! A dataset from a prepared log.

use super::dataset::{ColumnFilter, Stretch, Unfiltered, slices};
use super::decimation::coarse_filter;
use super::rows::at_rest;
use crate::dynamics::{Channel, Motion};
use crate::preparation::{Log, MotionError, PreparedLog};
use std::sync::Arc;

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
            channel_periods: Vec::new(),
            interval,
            periodic,
            samples: (0..samples).collect(),
            usable: vec![vec![true; samples]; joints],
            resting: vec![vec![false; samples]; joints],
            excluded: vec![None; joints],
            resolution: vec![0.0; joints],
            motion_error: vec![MotionError::default(); joints],
            recorded: None,
            filter: None,
            coarse: None,
            unfiltered: None,
            source: None,
        }
    }

    /// One period of a motion that will be recorded: [`Self::of_motion`] without the rows at which a joint rests, which a
    /// recording does not count either.
    pub(crate) fn of_planned(motion: Motion, interval: f64) -> Self {
        let resting: Vec<Vec<bool>> = (0..motion.joints())
            .map(|j| at_rest(motion.velocities(j), interval))
            .collect();
        let moving = |rests: &Vec<bool>| rests.iter().map(|r| !r).collect();
        Self {
            usable: resting.iter().map(moving).collect(),
            resting,
            ..Self::of_motion(motion, interval, true)
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
        let filter = Arc::new(move |x: &[&[f64]]| filter.torque_rows(x));
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
                let period: Vec<&[f64]> = unfolded.iter().map(|t| &t[k * n..(k + 1) * n]).collect();
                prepared.row_filter.torque_rows(&period)
            };
            periods = (0..p.count).map(rows).collect();
            starts = (0..p.count).map(|k| prepared.start_s + k as f64 * p.period_s).collect();
        }
        Self {
            channel_periods: channel_periods(prepared, log),
            ..Self::from_periods(prepared, periods, starts)
        }
    }

    /// From a prepared log with the torques of its periods, if it has any.
    pub(crate) fn from_periods(prepared: &PreparedLog, periods: Vec<Vec<Vec<f64>>>, starts: Vec<f64>) -> Self {
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
            torque: prepared.row_filter.torque_rows(&slices(&prepared.torque)),
            periods,
            starts,
            channel_periods: Vec::new(),
            interval: 1.0 / prepared.rate_hz,
            periodic: prepared.is_periodic() && plain,
            samples: prepared.row_filter.rows(n).collect(),
            usable: both(true),
            resting: both(false),
            excluded: prepared.excluded.clone(),
            resolution: prepared.resolution.clone(),
            motion_error: prepared.motion_error.clone(),
            recorded: None,
            filter: (!plain).then(|| Arc::new(move |x: &[&[f64]]| filter.column_rows(x)) as ColumnFilter),
            coarse: None,
            unfiltered: None,
            source: source_of(prepared),
        }
    }
}

/// The log's further quantities period by period; none where nothing repeats.
fn channel_periods(prepared: &PreparedLog, log: &Log) -> Vec<Vec<Channel>> {
    let (n, repeats) = (prepared.samples(), prepared.periods.as_ref().filter(|p| p.count >= 2));
    let Some(p) = repeats.filter(|_| !log.channels.is_empty()) else {
        return Vec::new();
    };
    let period = |k: usize| {
        let part = |c: &Channel| c.with(&p.unfold(&c.values)[k * n..(k + 1) * n]);
        log.channels.iter().map(part).collect()
    };
    (0..p.count).map(period).collect()
}

/// Rows at which a joint rests, the torque's filter reached from either side.
fn resting_rows(prepared: &PreparedLog, joint: usize) -> Vec<bool> {
    let rests = at_rest(prepared.motion.velocities(joint), 1.0 / prepared.rate_hz);
    prepared.row_filter.rows(prepared.samples()).map(|s| rests[s]).collect()
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
    let beside = samples_with_a_say(prepared);
    let directed = |s: usize| {
        let near = &speed[s.saturating_sub(beside)..(s + beside + 1).min(n)];
        near.iter().all(|v| v.abs() >= prepared.dead_zone[joint])
    };
    prepared.row_filter.rows(n).map(|s| intact(s) && directed(s)).collect()
}

/// Weight of a sample in a row from which on its direction counts: a fourth, as of four samples that make a row.
const HEAVY: f64 = 0.25;

/// How many samples to either side of a row have a say in it of their own.
///
/// The filter gives the sample in the middle of a row a weight of `2 f_c/f_s`, and those up to `f_s/(2 f_c)` from it less, with
/// the same sign. Where that is small, samples of the wrong direction are some among dozens, and wrong to either side. At few
/// samples a second each is a large part of several rows, and adds up to twice the Coulomb torque to them: smooth friction and
/// elastic joints were made of it.
fn samples_with_a_say(prepared: &PreparedLog) -> usize {
    let Some(filter) = &prepared.row_filter.torque else { return 0 };
    let weight = 2.0 * filter.cutoff_hz / filter.rate_hz;
    if weight > HEAVY { (1.0 / weight) as usize } else { 0 }
}

/// What a stretch of a log that does not repeat is made from, for other filters.
pub(crate) fn source_of(prepared: &PreparedLog) -> Option<Arc<PreparedLog>> {
    (!prepared.is_periodic() && prepared.row_filter.columns.is_some()).then(|| Arc::new(prepared.clone()))
}
