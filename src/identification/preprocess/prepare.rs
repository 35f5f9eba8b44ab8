//! The chain from log to [`PreparedLog`].

use super::cutoff::{ABOVE_SIGNAL, signal_cutoff};
use super::fourier_fit::fourier_fit;
use super::spectrum::forward;
use super::{
    Choice, FilterSpec, Method, Period, Periods, PreparedLog, PreprocessError, PreprocessOptions, RowFilter, Scatter,
    detect_period,
};
use crate::dynamics::Motion;
use crate::identification::Log;
use crate::identification::filter::{
    LowPass, Padding, central_difference, central_difference_periodic, fourth_order_difference, fourth_order_difference_periodic,
    zero_phase,
};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// The paper's filters (section 4.3).
const PAPER_POSITION: FilterSpec = FilterSpec {
    order: 20,
    cutoff_hz: 2.0,
};
const PAPER_TORQUE: FilterSpec = FilterSpec {
    order: 12,
    cutoff_hz: 1.6,
};
/// Order of the parallel filter: run both ways it falls by 48 dB per octave, and rings little.
const PARALLEL_ORDER: usize = 4;
/// Order of its position filter, see `Chain::position_default`.
const POSITION_ORDER: usize = 8;
/// Velocities nearer to zero than three of their standard deviations have no known sign.
const SIGN_SIGMAS: f64 = 3.0;

/// Prepares `log` for a robot with `joints` joints.
///
/// # Errors
/// Wrong number of joints, a period that the log does not hold, filters that the sample rate does not allow, options out of range.
pub fn prepare(log: &Log, joints: usize, options: &PreprocessOptions) -> Result<PreparedLog, PreprocessError> {
    if log.joints() != joints || log.tau.len() != joints {
        return Err(PreprocessError::WrongJoints {
            log: log.name.clone(),
            expected: joints,
            actual: log.joints().min(log.tau.len()),
        });
    }
    let chain = Chain { log, options };
    chain.check()?;
    let mut choices = Vec::new();
    let record = chain.record(&mut choices)?;
    let (mut motion, velocity_std) = chain.differentiate(&record, &mut choices)?;
    let still = hold_still(&mut motion, &velocity_std);
    let row_filter = chain.row_filter(&record, &mut choices)?;
    let dead_zone = chain.dead_zone(&velocity_std, &still, &mut choices);
    let samples = record.usable.len();
    let rows = row_filter.rows(samples).len();
    if rows < 8 {
        return Err(PreprocessError::NothingLeft {
            log: log.name.clone(),
            rows,
            samples,
        });
    }
    let first = record.periods.as_ref().map_or(0, |p| p.first);
    Ok(PreparedLog {
        name: log.name.clone(),
        rate_hz: record.rate_hz,
        start_s: log.start_s + first as f64 / log.rate_hz,
        motion: Arc::new(motion),
        torque: record.tau.into_owned(),
        usable: record.usable,
        periods: record.periods,
        scatter: record.scatter,
        row_filter,
        dead_zone,
        choices,
    })
}

/// Whether periods scatter by noise alone, and not by torques of their own ([`is_noise`]): about their mean or, where they do not, between the two of them,
/// not far apart, that agree best. A touch in one period or over the border of two, or friction that changes as the arm warms up, is something that the
/// loop has to find and is no reason to give the periods up.
fn torques_repeat(record: &Record) -> bool {
    let Some(scatter) = &record.scatter else { return true };
    let power = |tau: &Vec<f64>| tau.iter().map(|t| t * t).sum::<f64>() / tau.len() as f64;
    (0..record.tau.len()).all(|j| {
        let torque = power(&record.tau[j]);
        // Spectra are of the mean: periods scatter K times as much.
        let single: Vec<f64> = scatter.spectrum[j].iter().map(|s| s * scatter.periods as f64).collect();
        is_noise(&single, torque) || is_noise(&between_alike(scatter, j, record.tau[j].len()), torque)
    })
}

/// Two periods touched between them leave another pair that is no farther apart, of four periods or more.
const FARTHEST: usize = 3;

/// Half the power `|X_l|²/N` of the difference of two periods, of the pair that has least.
fn between_alike(scatter: &Scatter, joint: usize, samples: usize) -> Vec<f64> {
    let (torque, usable) = (&scatter.torque[joint], &scatter.usable);
    let power = |(one, other): (usize, usize)| {
        let pairs = (0..samples).map(|s| (one * samples + s, other * samples + s));
        let difference: Vec<f64> = pairs
            .map(|(a, b)| if usable[a] && usable[b] { torque[b] - torque[a] } else { 0.0 })
            .collect();
        // The first line is a level of its own in every period, which tracing tells of as well.
        let lines = forward(&difference).into_iter().enumerate();
        lines
            .map(|(l, x)| if l == 0 { 0.0 } else { x.norm_sqr() / (2 * samples) as f64 })
            .collect()
    };
    let count = scatter.periods;
    let pairs = (0..count).flat_map(|one| (one + 1..count.min(one + 1 + FARTHEST)).map(move |other| (one, other)));
    let sum = |lines: &Vec<f64>| lines.iter().sum::<f64>();
    let least = pairs.map(power).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    least.expect("scatter is that of two periods at least")
}

/// Below a tenth of the band, where the motion is, the scatter of one period is less than 5 % of the torque, or its density no more than ten times that
/// of the noise above.
fn is_noise(spectrum: &[f64], torque_power: f64) -> bool {
    let mean = |lines: &[f64]| lines.iter().sum::<f64>() / lines.len().max(1) as f64;
    let (low, high) = spectrum.split_at(spectrum.len() / 10);
    // Two lines of the whole spectrum per line of this half.
    let samples = 2 * (spectrum.len() - 1);
    let scattered = 2.0 * low.iter().sum::<f64>() / samples.max(1) as f64;
    scattered < 0.05 * 0.05 * torque_power || mean(low) < 10.0 * mean(high)
}

/// Joints whose velocity is noise and nothing else are taken to stand still: their friction must not be fitted to noise.
fn hold_still(motion: &mut Motion, velocity_std: &[f64]) -> Vec<bool> {
    let samples = motion.samples();
    let still = |(j, std): (usize, &f64)| {
        let square: f64 = motion.velocities(j).iter().map(|v| v * v).sum();
        (square / samples as f64).sqrt() <= SIGN_SIGMAS * std
    };
    let still: Vec<bool> = velocity_std.iter().enumerate().map(still).collect();
    for j in (0..still.len()).filter(|&j| still[j]) {
        let mean = motion.positions(j).iter().sum::<f64>() / samples as f64;
        (0..samples).for_each(|s| motion.set(j, s, [mean, 0.0, 0.0]));
    }
    still
}

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
    /// Variance of the mean positions, where periods scatter.
    position_variance: Option<Vec<f64>>,
    scatter: Option<Scatter>,
}

struct Chain<'a> {
    log: &'a Log,
    options: &'a PreprocessOptions,
}

impl<'a> Chain<'a> {
    fn check(&self) -> Result<(), PreprocessError> {
        let refuse = |field, value, problem| {
            Err(PreprocessError::Option {
                log: self.log.name.clone(),
                field,
                value,
                problem,
            })
        };
        if let Period::Known { period_s, .. } = self.options.period
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

    /// Cuts the log into periods where it has them, and takes their mean.
    fn record(&self, choices: &mut Vec<Choice>) -> Result<Record<'a>, PreprocessError> {
        let (period, order, source) = match self.options.period {
            Period::None => (None, None, "the request asks for one stretch"),
            Period::Known { period_s, order } => (Some(period_s), order, "given"),
            Period::Detect => (detect_period(self.log), None, "found in the positions' autocorrelation"),
        };
        let stated = matches!(self.options.period, Period::Known { .. });
        let periods = period.and_then(|p| Periods::find(self.log, p));
        match periods {
            Some(periods) if periods.count == 1 && !stated => {
                choices.push(Choice::new(
                    "period",
                    "none",
                    "less than two whole periods repeat: their ends need not meet",
                ));
                Ok(self.whole())
            }
            Some(periods) => {
                let mut made = Vec::new();
                let record = self.averaged(periods, order, source, &mut made);
                if !stated && !torques_repeat(&record) {
                    let why = "the positions repeat but the torques do not: something other than the motion acts, and a mean would hide it";
                    choices.push(Choice::new("period", "none", why));
                    return Ok(self.whole());
                }
                choices.extend(made);
                Ok(record)
            }
            None if stated => Err(PreprocessError::NoWholePeriod {
                log: self.log.name.clone(),
                period_s: period.unwrap_or(f64::NAN),
                duration_s: self.log.duration_s(),
            }),
            None => {
                let why = if self.options.period == Period::None {
                    source
                } else {
                    "nothing in the positions repeats twice"
                };
                choices.push(Choice::new("period", "none", why));
                Ok(self.whole())
            }
        }
    }

    fn whole(&self) -> Record<'a> {
        Record {
            rate_hz: self.log.rate_hz,
            q: Cow::Borrowed(&self.log.q),
            qd: self.log.qd.as_deref().map(Cow::Borrowed),
            tau: Cow::Borrowed(&self.log.tau),
            usable: self.log.usable.clone(),
            periods: None,
            order: None,
            position_variance: None,
            scatter: None,
        }
    }

    fn averaged(&self, periods: Periods, order: Option<usize>, source: &str, choices: &mut Vec<Choice>) -> Record<'a> {
        let (k, n) = (periods.count, periods.samples);
        let usable = periods.usable(self.log);
        let mean = |columns: &[Vec<f64>]| {
            columns
                .par_iter()
                .map(|x| periods.mean(&periods.unfold(x), &usable))
                .collect::<Vec<_>>()
        };
        let (q, tau) = (mean(&self.log.q), mean(&self.log.tau));
        let position_variance = (k > 1).then(|| {
            let variance = |(x, mean): (&Vec<f64>, &Vec<f64>)| {
                let sum = periods.scatter_square(&periods.unfold(x), mean, &usable);
                sum / ((k - 1) * n) as f64 / k as f64
            };
            self.log.q.par_iter().zip(&q).map(variance).collect()
        });
        let torque = || self.log.tau.par_iter().map(|x| periods.unfold(x).into_owned()).collect();
        let scatter = (k > 1).then(|| Scatter::new(&periods, torque(), &tau, usable.clone()));
        let left = self.log.duration_s() - k as f64 * periods.period_s;
        choices.push(Choice::new("period", format!("{:.6} s", periods.period_s), source));
        choices.push(Choice::new(
            "averaging",
            format!(
                "{k} periods of {n} samples from {:.3} s on",
                self.log.start_s + periods.first as f64 / self.log.rate_hz
            ),
            format!(
                "noise falls by the square root of {k}; {:.3} s at the ends belong to no whole period that repeats",
                left.max(0.0)
            ),
        ));
        Record {
            rate_hz: n as f64 / periods.period_s,
            q: Cow::Owned(q),
            qd: self.log.qd.as_deref().map(|columns| Cow::Owned(mean(columns))),
            tau: Cow::Owned(tau),
            usable: (0..n).map(|i| (i..k * n).step_by(n).any(|s| usable[s])).collect(),
            periods: Some(periods),
            order,
            position_variance,
            scatter,
        }
    }

    fn method(&self, record: &Record) -> Method {
        match self.options.method {
            Method::Automatic if record.periods.is_some() => Method::FourierFit,
            Method::Automatic => Method::ParallelFilter,
            chosen => chosen,
        }
    }

    /// q, qd, qdd, and the standard deviation of the velocities where it is known.
    fn differentiate(&self, record: &Record, choices: &mut Vec<Choice>) -> Result<(Motion, Vec<f64>), PreprocessError> {
        match self.method(record) {
            Method::FourierFit => self.by_fourier(record, choices),
            method => self.by_filter(record, method, choices),
        }
    }

    fn by_fourier(&self, record: &Record, choices: &mut Vec<Choice>) -> Result<(Motion, Vec<f64>), PreprocessError> {
        let Some(periods) = &record.periods else {
            return Err(PreprocessError::NotPeriodic {
                log: self.log.name.clone(),
            });
        };
        let variance = |j: usize| record.position_variance.as_ref().map(|v| v[j]);
        let fits: Vec<_> = record
            .q
            .par_iter()
            .enumerate()
            .map(|(j, q)| fourier_fit(q, periods.period_s, variance(j), record.order))
            .collect();
        let motion = Motion::from_fn(fits.len(), record.usable.len(), |j, s| {
            [fits[j].q[s], fits[j].qd[s], fits[j].qdd[s]]
        });
        if let Some(logged) = &record.qd {
            let why = match disagreement(logged, &motion) {
                Some((j, part)) => format!("{}; the positions are believed", self.differs(j, part)),
                None => "they agree with the positions, whose Fourier series has less noise in its derivatives".to_string(),
            };
            choices.push(Choice::new("logged_velocities", NOT_USED, why));
        }
        let highest = fits.iter().map(|f| f.highest).max().unwrap_or(0);
        let kept: Vec<usize> = fits.iter().map(|f| f.kept).collect();
        let worst = fits.iter().map(|f| f.acceleration_std).fold(0.0, f64::max);
        choices.push(Choice::new(
            "derivatives",
            format!("Fourier fit, harmonics per joint {kept:?}, highest {highest} ({:.2} Hz)", highest as f64 / periods.period_s),
            format!(
                "the log repeats; harmonics that stand above the position noise are kept and differentiated exactly, which leaves at most \
                 {worst:.2e} rad/s² (m/s²) of noise in the accelerations"
            ),
        ));
        Ok((motion, fits.iter().map(|f| f.velocity_std).collect()))
    }

    fn by_filter(
        &self,
        record: &Record,
        method: Method,
        choices: &mut Vec<Choice>,
    ) -> Result<(Motion, Vec<f64>), PreprocessError> {
        let periodic = record.periods.is_some();
        let (spec, why) = match (self.options.position_filter, method) {
            (Some(spec), _) => (spec, "given"),
            (None, Method::Paper) => (PAPER_POSITION, "the paper's section 4.3"),
            (None, _) => (
                self.position_default(),
                "twice as high as the positions stand above their noise, so that it leaves them as they are up to there",
            ),
        };
        let filter = self.design(spec, record.rate_hz, "position_filter")?;
        let padding = padding(periodic);
        let step = 1.0 / record.rate_hz;
        let difference = match (method, periodic) {
            (Method::Paper, true) => central_difference_periodic,
            (Method::Paper, false) => central_difference,
            (_, true) => fourth_order_difference_periodic,
            (_, false) => fourth_order_difference,
        };
        let mut motion = Motion::zeros(record.q.len(), record.usable.len());
        let of_joint = |raw: &Vec<f64>| {
            let q = zero_phase(&filter, raw, padding, filter.settling_samples());
            let qd = difference(&q, step);
            let qdd = difference(&qd, step);
            (velocity_noise(raw, &q, &filter), [q, qd, qdd])
        };
        let (mut velocity_std, states): (Vec<f64>, Vec<[Vec<f64>; 3]>) = record.q.par_iter().map(of_joint).unzip();
        for (j, [q, qd, qdd]) in states.iter().enumerate() {
            (0..q.len()).for_each(|s| motion.set(j, s, [q[s], qd[s], qdd[s]]));
        }
        drop(states);
        choices.push(Choice::new(
            "derivatives",
            format!(
                "{}, then {}",
                describe(spec),
                if method == Method::Paper {
                    "central differences"
                } else {
                    "differences of fourth order"
                }
            ),
            why,
        ));
        if let Some(logged) = &record.qd {
            let filtered: Vec<Vec<f64>> = logged
                .iter()
                .map(|v| zero_phase(&filter, v, padding, filter.settling_samples()))
                .collect();
            let choice = match (disagreement(&filtered, &motion), method) {
                (Some((j, part)), _) => (NOT_USED, format!("{}; the positions are believed", self.differs(j, part))),
                (None, Method::Paper) => (NOT_USED, "the paper takes them from the positions".to_string()),
                (None, _) => {
                    for (j, qd) in filtered.iter().enumerate() {
                        let qdd = difference(qd, step);
                        (0..qd.len()).for_each(|s| motion.set(j, s, [motion.positions(j)[s], qd[s], qdd[s]]));
                        velocity_std[j] = filtered_noise(&logged[j], qd, &filter);
                    }
                    let why = "they agree with the positions; filtered alike, and differenced once for the accelerations";
                    ("used", why.to_string())
                }
            };
            choices.push(Choice::new("logged_velocities", choice.0, choice.1));
        }
        Ok((motion, velocity_std))
    }

    fn differs(&self, joint: usize, part: f64) -> String {
        format!(
            "those of joint {} are {:.0} % of their size off the positions' derivative: another unit, sign or delay",
            joint + 1,
            100.0 * part
        )
    }

    fn parallel_default(&self) -> FilterSpec {
        FilterSpec {
            order: PARALLEL_ORDER,
            cutoff_hz: signal_cutoff(self.log),
        }
    }

    /// Positions are filtered before the model sees them, torques are not: what the filter takes off the motion, a fraction (f/f_c)^2n at
    /// frequency f, is missing in the model alone and bends the parameters. At twice the highest frequency of the signal that is 2^-16, a
    /// hundredth of what the noise of a good log leaves in a parameter; where noise lets more through, the row filter ends it.
    fn position_default(&self) -> FilterSpec {
        FilterSpec {
            order: POSITION_ORDER,
            cutoff_hz: signal_cutoff(self.log) * (2.0 / ABOVE_SIGNAL),
        }
    }

    fn design(&self, spec: FilterSpec, rate_hz: f64, what: &'static str) -> Result<LowPass, PreprocessError> {
        LowPass::butterworth(spec.order, spec.cutoff_hz, rate_hz).map_err(|source| PreprocessError::Filter {
            log: self.log.name.clone(),
            what,
            source,
        })
    }

    fn row_filter(&self, record: &Record, choices: &mut Vec<Choice>) -> Result<RowFilter, PreprocessError> {
        let periodic = record.periods.is_some();
        let (spec, on_columns, why) = match (self.options.torque_filter, self.method(record)) {
            (Some(spec), Method::Paper) => (Some(spec), false, "given"),
            (Some(spec), _) => (
                Some(spec),
                true,
                "given; the same for torque and every regressor column, which leaves the equation as it is",
            ),
            (None, Method::Paper) => (Some(PAPER_TORQUE), false, "the paper's section 4.3: torque alone is filtered"),
            (None, Method::ParallelFilter) => (
                Some(self.options.position_filter.unwrap_or_else(|| self.parallel_default())),
                true,
                "as for the positions; the same filter for torque and every regressor column leaves the equation as it is",
            ),
            (None, _) => (
                None,
                false,
                "averaging is all the filter that least squares needs; the noise of the mean is known from the periods",
            ),
        };
        choices.push(Choice::new("row_filter", spec.map_or("none".to_string(), describe), why));
        let filter = spec
            .map(|spec| self.design(spec, record.rate_hz, "torque_filter"))
            .transpose()?;
        let mut rows = RowFilter {
            columns: filter.clone().filter(|_| on_columns),
            torque: filter,
            padding: padding(periodic),
            ..RowFilter::none()
        };
        self.edges_and_decimation(record, &mut rows, choices);
        Ok(rows)
    }

    fn edges_and_decimation(&self, record: &Record, rows: &mut RowFilter, choices: &mut Vec<Choice>) {
        let settling = rows.torque.as_ref().map_or(0, LowPass::settling_samples);
        let (edges, why) = match self.options.discard_edges_s {
            Some(seconds) => ((seconds * record.rate_hz).round() as usize, "given"),
            None if record.periods.is_some() => (0, "a period has no ends"),
            None => (
                settling,
                "what the filter remembers of the padding beyond the record, down to a thousandth",
            ),
        };
        rows.edges = edges;
        choices.push(Choice::new("edges", format!("{:.3} s", edges as f64 / record.rate_hz), why));
        let (decimation, why) = match (self.options.decimation, &rows.torque) {
            (Some(d), _) => (d, "given".to_string()),
            // Four samples per cycle of the cut-off: twice what the filtered signals need, so nothing is lost.
            (None, Some(filter)) if record.periods.is_none() => {
                let d = (record.rate_hz / (4.0 * filter.cutoff_hz)).floor().max(1.0) as usize;
                // A round number lets the rows be made of thinned-out samples too.
                (
                    if d >= 10 { d - d % 5 } else { d },
                    "rows closer together than a quarter of the filter's cut-off period say nothing new".to_string(),
                )
            }
            (None, _) => (1, "every sample of the mean period counts".to_string()),
        };
        rows.decimation = decimation;
        choices.push(Choice::new("decimation", decimation.to_string(), why));
    }

    fn dead_zone(&self, velocity_std: &[f64], still: &[bool], choices: &mut Vec<Choice>) -> Vec<f64> {
        let (mut zone, why) = match (self.options.dead_zone, self.options.method) {
            (Some(v), _) => (vec![v; velocity_std.len()], "given"),
            (None, Method::Paper) => (vec![0.0; velocity_std.len()], "the paper has none"),
            (None, _) => (
                velocity_std.iter().map(|s| SIGN_SIGMAS * s).collect(),
                "three standard deviations of the velocity: closer to zero its sign, and with it the Coulomb torque, is not known",
            ),
        };
        // A joint that never moves has no friction to mistake, and its rows tell of gravity.
        zone.iter_mut()
            .zip(still)
            .filter(|(_, still)| **still)
            .for_each(|(z, _)| *z = 0.0);
        let text: Vec<String> = zone.iter().map(|v| format!("{v:.2e}")).collect();
        choices.push(Choice::new("dead_zone", format!("[{}] rad/s (m/s)", text.join(", ")), why));
        zone
    }
}

fn padding(periodic: bool) -> Padding {
    if periodic { Padding::Periodic } else { Padding::Odd }
}

fn describe(spec: FilterSpec) -> String {
    format!("zero-phase Butterworth, order {} at {:.3} Hz", spec.order, spec.cutoff_hz)
}

const NOT_USED: &str = "not used";
/// Velocities this near to the derivative of the positions are the same quantity: a twentieth is a delay of 8 ms at 1 Hz.
const SAME_VELOCITY: f64 = 0.05;

/// The joint whose logged velocities are farthest from those of `motion`, and by which part of their root mean square; `None` where all
/// are the same. Joints that stand still say nothing.
fn disagreement(logged: &[Vec<f64>], motion: &Motion) -> Option<(usize, f64)> {
    let rms = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    let sizes: Vec<f64> = (0..logged.len())
        .map(|j| rms(&mut motion.velocities(j).iter().copied()))
        .collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let part = |(j, v): (usize, &Vec<f64>)| {
        let off = rms(&mut v.iter().zip(motion.velocities(j)).map(|(a, b)| a - b));
        (sizes[j] > 0.01 * fastest).then(|| (j, off / sizes[j]))
    };
    let worst = logged
        .iter()
        .enumerate()
        .filter_map(part)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (worst.1 > SAME_VELOCITY).then_some(worst)
}

/// Standard deviation of what `filter` leaves of the white noise that it took most of: `2 fc/f_s` of its variance.
fn filtered_noise(raw: &[f64], filtered: &[f64], filter: &LowPass) -> f64 {
    let removed = raw.iter().zip(filtered).map(|(r, f)| (r - f).powi(2)).sum::<f64>() / raw.len() as f64;
    let share = 2.0 * filter.cutoff_hz / filter.rate_hz;
    (removed * share / (1.0 - share).max(0.1)).sqrt()
}

/// Standard deviation of the velocity that is left after filtering, from what the filter took out: for white noise of variance σ²
/// per sample, taken out above the cut-off, the velocity keeps `σ² 2/f_s ∫₀^fc (2πf)² df = σ² 8π² fc³ / 3 f_s`.
fn velocity_noise(raw: &[f64], filtered: &[f64], filter: &LowPass) -> f64 {
    let removed = raw.iter().zip(filtered).map(|(r, f)| (r - f).powi(2)).sum::<f64>() / raw.len() as f64;
    let share = 1.0 - 2.0 * filter.cutoff_hz / filter.rate_hz;
    let variance = removed / share.max(0.1);
    let pi = std::f64::consts::PI;
    (variance * 8.0 * pi * pi * filter.cutoff_hz.powi(3) / (3.0 * filter.rate_hz)).sqrt()
}
