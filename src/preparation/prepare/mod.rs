//! The chain from log to [`PreparedLog`].

mod derivatives;
mod record;
mod rows;

use super::autocorrelation::{NO_MOTION, moments};
use super::torque_column::{exclusions, resolution};
use super::{Choice, Exclusion, FilterSpec, Method, Period, Periods, PreparedLog, PreprocessError, PreprocessOptions, Scatter};
use crate::cancel::CancelFlag;
use crate::dynamics::{Channel, Motion};
use crate::model::INPUT_LIMITS;
use crate::preparation::Log;
use crate::preparation::filter::{LowPass, Padding};
use crate::preparation::fourier_fit::PositionNoise;
use crate::preparation::motion_error::MotionError;
use std::borrow::Cow;
use std::sync::Arc;

/// Rows below which there is no motion to speak of.
const LEAST_ROWS: usize = 8;
/// Velocities nearer to zero than three of their standard deviations have no known sign.
const SIGN_SIGMAS: f64 = 3.0;

/// Prepares `log` for a robot with `joints` joints.
///
/// # Errors
/// Wrong number of joints, a period that the log does not hold, filters that the sample rate does not allow, options out of
/// range.
pub fn prepare(log: &Log, joints: usize, options: &PreprocessOptions) -> Result<PreparedLog, PreprocessError> {
    prepare_until(log, joints, options, &CancelFlag::default())
}

/// The same, left when `cancel` is set, as by [`CancelFlag::leave_if_set`]: within [`CancelFlag::run`].
///
/// # Errors
/// As [`prepare`].
pub fn prepare_until(
    log: &Log,
    joints: usize,
    options: &PreprocessOptions,
    cancel: &CancelFlag,
) -> Result<PreparedLog, PreprocessError> {
    if log.joints() != joints || log.tau.len() != joints {
        return Err(PreprocessError::WrongJoints {
            log: log.name.clone(),
            expected: joints,
            actual: log.joints().min(log.tau.len()),
        });
    }
    let chain = Chain { log, options, cancel };
    chain.check()?;
    chain.check_positions()?;
    let mut choices = Vec::new();
    let record = chain.record(&mut choices)?;
    let Derivatives {
        mut motion,
        error,
        filter,
    } = chain.differentiate(&record, &mut choices)?;
    let velocity_std: Vec<f64> = error.iter().map(|e| e.std_dev[1]).collect();
    let still = hold_still(&mut motion, &velocity_std, log);
    let excluded = chain.excluded(&still, &mut choices)?;
    cancel.leave_if_set();
    let row_filter = chain.row_filter(&record, filter.as_ref(), &mut choices)?;
    let dead_zone = chain.dead_zone(&velocity_std, &still, &mut choices);
    let samples = record.usable.len();
    let rows = row_filter.rows(samples).len();
    if rows < LEAST_ROWS {
        return Err(PreprocessError::NothingLeft {
            log: log.name.clone(),
            rows,
            samples,
        });
    }
    let recorded = |tau: &Vec<f64>| {
        cancel.leave_if_set();
        resolution(tau, &log.usable)
    };
    let recorded = log.tau.iter().map(recorded).collect();
    let first = record.periods.as_ref().map_or(0, |p| p.first);
    Ok(PreparedLog {
        name: log.name.clone(),
        rate_hz: record.rate_hz,
        start_s: log.start_s + first as f64 / log.rate_hz,
        motion: Arc::new(motion.with_channels(record.channels)),
        torque: record.tau.into_owned(),
        usable: record.usable,
        periods: record.periods,
        scatter: record.scatter,
        row_filter,
        dead_zone,
        excluded,
        resolution: recorded,
        motion_error: error,
        choices,
    })
}

/// Joints whose velocity is noise and nothing else, or that stay about one place, are taken to stand still: their friction must
/// not be fitted to noise, nor to the few microns that a drive gives way.
fn hold_still(motion: &mut Motion, velocity_std: &[f64], log: &Log) -> Vec<bool> {
    let samples = motion.samples();
    let still = |(j, std): (usize, &f64)| {
        let square: f64 = motion.velocities(j).iter().map(|v| v * v).sum();
        !moves(&log.q[j]) || (square / samples as f64).sqrt() <= SIGN_SIGMAS * std
    };
    let still: Vec<bool> = velocity_std.iter().enumerate().map(still).collect();
    for j in (0..still.len()).filter(|&j| still[j]) {
        let mean = motion.positions(j).iter().sum::<f64>() / samples as f64;
        (0..samples).for_each(|s| motion.set(j, s, [mean, 0.0, 0.0]));
    }
    still
}

/// Whether a joint travels more than static friction and a drive's play allow.
fn moves(q: &[f64]) -> bool {
    moments(q).1 >= NO_MOTION * NO_MOTION
}

/// Positions beyond this are none [rad or m].
const FARTHEST: f64 = INPUT_LIMITS.measured_position;

/// One stretch or one mean period, before derivatives.
struct Record<'a> {
    rate_hz: f64,
    q: Cow<'a, [Vec<f64>]>,
    /// As logged.
    qd: Option<Cow<'a, [Vec<f64>]>>,
    tau: Cow<'a, [Vec<f64>]>,
    usable: Vec<bool>,
    periods: Option<Periods>,
    /// Highest harmonic of the excitation, where known.
    order: Option<usize>,
    /// Noise of the mean positions, where periods scatter.
    position_noise: Option<Vec<PositionNoise>>,
    scatter: Option<Scatter>,
    /// Further quantities over the stretch, or averaged over the periods.
    channels: Vec<Channel>,
}

struct Chain<'a> {
    log: &'a Log,
    options: &'a PreprocessOptions,
    /// Leaves the preparation when it is set.
    cancel: &'a CancelFlag,
}

impl Chain<'_> {
    fn check(&self) -> Result<(), PreprocessError> {
        let refuse = |field, value, problem| {
            Err(PreprocessError::Option {
                log: self.log.name.clone(),
                field,
                value,
                problem,
            })
        };
        if let Period::Known { period_s, .. } | Period::Expected { period_s, .. } = self.options.period
            && !(period_s.is_finite() && period_s > 0.0)
        {
            return refuse("period_s", period_s, "not a positive time");
        }
        if let Some(v) = self.options.discard_edges_s.filter(|v| !(v.is_finite() && *v >= 0.0)) {
            return refuse("discard_edges_s", v, "not a time");
        }
        if let Some(v) = self.options.dead_zone.filter(|v| !(v.is_finite() && *v >= 0.0)) {
            return refuse("dead_zone", v, "not a speed");
        }
        if self.options.decimation == Some(0) {
            return refuse("decimation", 0.0, "not a count: 1 keeps every row");
        }
        Ok(())
    }

    /// Positions that are those of an arm, of which at least one moves.
    fn check_positions(&self) -> Result<(), PreprocessError> {
        let log = self.log.name.clone();
        let size = |v: &f64| if v.is_nan() { f64::INFINITY } else { v.abs() };
        let largest = |q: &Vec<f64>| q.iter().map(size).fold(0.0, f64::max);
        if let Some((j, largest)) = self.log.q.iter().map(largest).enumerate().find(|(_, m)| *m > FARTHEST) {
            return Err(PreprocessError::ImplausiblePosition {
                log,
                joint: j + 1,
                largest,
            });
        }
        if self.log.samples() < LEAST_ROWS {
            let samples = self.log.samples();
            return Err(PreprocessError::NothingLeft {
                log,
                rows: samples,
                samples,
            });
        }
        match self.log.q.iter().any(|q| moves(q)) {
            true => Ok(()),
            false => Err(PreprocessError::NothingMoves { log }),
        }
    }

    /// Joints whose torque takes no part, and why.
    fn excluded(&self, still: &[bool], choices: &mut Vec<Choice>) -> Result<Vec<Option<Exclusion>>, PreprocessError> {
        let excluded = exclusions(&self.log.tau, &self.log.usable, still);
        let reasons: Vec<String> = excluded
            .iter()
            .enumerate()
            .filter_map(|(j, e)| Some(format!("joint {}: {}", j + 1, (*e)?)))
            .collect();
        if reasons.len() == excluded.len() {
            return Err(PreprocessError::NoTorque {
                log: self.log.name.clone(),
                reasons: reasons.join("; "),
            });
        }
        if !reasons.is_empty() {
            choices.push(Choice::new(
                "left_out",
                reasons.join("; "),
                "such a joint has no rows; the others are not affected",
            ));
        }
        Ok(excluded)
    }

    fn method(&self, record: &Record) -> Method {
        match self.options.method {
            Method::Automatic if record.periods.is_some() => Method::FourierFit,
            Method::Automatic => Method::ParallelFilter,
            chosen => chosen,
        }
    }

    fn design(&self, spec: FilterSpec, rate_hz: f64, what: &'static str) -> Result<LowPass, PreprocessError> {
        LowPass::butterworth(spec.order, spec.cutoff_hz, rate_hz).map_err(|source| PreprocessError::Filter {
            log: self.log.name.clone(),
            what,
            source,
        })
    }
}

/// A motion, and what is not known of it.
pub(crate) struct Derivatives {
    pub motion: Motion,
    /// Per joint.
    pub error: Vec<MotionError>,
    /// What the positions went through, where that was a low-pass whose memory counts.
    pub filter: Option<LowPass>,
}

fn padding(periodic: bool) -> Padding {
    if periodic { Padding::Periodic } else { Padding::Odd }
}

fn describe(spec: FilterSpec) -> String {
    format!("zero-phase Butterworth, order {} at {:.3} Hz", spec.order, spec.cutoff_hz)
}
