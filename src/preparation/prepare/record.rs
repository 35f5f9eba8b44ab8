//! From a log to one stretch, or to one mean period where the torques repeat as well as the positions.

use super::{Chain, Record};
use crate::dynamics::Channel;
use crate::model::shortest;
use crate::preparation::average::{Periods, Scatter, mean_spectrum};
use crate::preparation::error::PreprocessError;
use crate::preparation::fourier_fit::PositionNoise;
use crate::preparation::options::{Choice, Period};
use crate::preparation::period::{detect_period_until, repeats_with};
use crate::preparation::spectrum::forward;
use crate::preparation::torque_column::{exclusions, rounded_alike, step_of};
use rayon::prelude::*;
use std::borrow::Cow;

impl<'a> Chain<'a> {
    /// Cuts the log into periods where it has them, and takes their mean.
    pub(crate) fn record(&self, choices: &mut Vec<Choice>) -> Result<Record<'a>, PreprocessError> {
        let Chosen {
            period,
            order,
            source,
            stated,
        } = self.chosen_period();
        let periods = period.and_then(|p| Periods::find(self.log, p, self.cancel));
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
                let record = self.averaged(periods, order, &source, &mut made);
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
                choices.push(Choice::new("period", "none", source));
                Ok(self.whole())
            }
        }
    }

    /// The period that this log has: a stated one is that of the trajectory that somebody had in mind, which need not be this
    /// log's.
    fn chosen_period(&self) -> Chosen {
        let found = |otherwise: &str| {
            let period = detect_period_until(self.log, self.cancel);
            let source = match period {
                Some(_) => "found in the positions' autocorrelation",
                None => "nothing in the positions repeats twice",
            };
            Chosen {
                period,
                order: None,
                source: format!("{source}{otherwise}"),
                stated: false,
            }
        };
        match self.options.period {
            Period::None => Chosen {
                period: None,
                order: None,
                source: "the request asks for one stretch".into(),
                stated: false,
            },
            Period::Detect => found(""),
            Period::Known { period_s, order } | Period::Expected { period_s, order } => {
                let imposed = matches!(self.options.period, Period::Known { .. });
                let given = Chosen {
                    period: Some(period_s),
                    order,
                    source: "given".into(),
                    stated: imposed,
                };
                let own = || {
                    found(&format!(
                        "; this log does not repeat with the stated {} s",
                        shortest(period_s)
                    ))
                };
                match repeats_with(self.log, period_s, self.cancel) {
                    Some(true) => given,
                    Some(false) => own(),
                    None if imposed => given,
                    None => own(),
                }
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
            position_noise: None,
            scatter: None,
            channels: self.log.channels.clone(),
        }
    }

    fn averaged(&self, periods: Periods, order: Option<usize>, source: &str, choices: &mut Vec<Choice>) -> Record<'a> {
        let (k, n) = (periods.count, periods.samples);
        let usable = periods.usable(self.log);
        let mean = |columns: &[Vec<f64>]| {
            columns
                .par_iter()
                .map(|x| {
                    self.cancel.leave_if_set();
                    periods.mean(&periods.unfold(x), &usable)
                })
                .collect::<Vec<_>>()
        };
        let (q, tau) = (mean(&self.log.q), mean(&self.log.tau));
        let position_noise = (k > 1).then(|| {
            let noise = |(x, mean): (&Vec<f64>, &Vec<f64>)| {
                self.cancel.leave_if_set();
                let unfolded = periods.unfold(x);
                let single = periods.scatter_square(&unfolded, mean, &usable) / ((k - 1) * n) as f64;
                // An encoder without noise rounds every period alike, and so their mean.
                let alike = step_of(x, &self.log.usable).map_or(0.0, |step| rounded_alike(step, single.sqrt()));
                let mut spectrum = mean_spectrum(&periods, &unfolded, mean, &usable, self.cancel);
                spectrum.iter_mut().for_each(|s| *s += alike);
                let variance = single / k as f64 + alike;
                PositionNoise { variance, spectrum }
            };
            self.log.q.par_iter().zip(&q).map(noise).collect()
        });
        let torque = || self.log.tau.par_iter().map(|x| periods.unfold(x).into_owned()).collect();
        let scatter = (k > 1).then(|| Scatter::new(&periods, torque(), &tau, usable.clone(), self.cancel));
        let of_channel = |c: &Channel| c.with(&periods.mean(&periods.unfold(&c.values), &usable));
        let channels = self.log.channels.iter().map(of_channel).collect();
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
            position_noise,
            scatter,
            channels,
        }
    }
}

/// What is known of the period before the log is cut.
struct Chosen {
    period: Option<f64>,
    order: Option<usize>,
    source: String,
    /// By the request, and not contradicted by the log.
    stated: bool,
}

/// Whether periods scatter by noise alone, and not by torques of their own ([`is_noise`]): about their mean or, where they do
/// not, between the two of them, not far apart, that agree best. A touch in one period or over the border of two, or friction
/// that changes as the arm warms up, is something that the loop has to find and is no reason to give the periods up.
fn torques_repeat(record: &Record) -> bool {
    let Some(scatter) = &record.scatter else { return true };
    let power = |tau: &Vec<f64>| tau.iter().map(|t| t * t).sum::<f64>() / tau.len() as f64;
    // A column that is no torque says nothing of the others.
    let dead = exclusions(&record.tau, &record.usable, &vec![false; record.tau.len()]);
    (0..record.tau.len()).filter(|&j| dead[j].is_none()).all(|j| {
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

/// Below a tenth of the band, where the motion is, the scatter of one period is less than 5 % of the torque, or its density no
/// more than ten times that of the noise above.
fn is_noise(spectrum: &[f64], torque_power: f64) -> bool {
    let mean = |lines: &[f64]| lines.iter().sum::<f64>() / lines.len().max(1) as f64;
    let (low, high) = spectrum.split_at(spectrum.len() / 10);
    // Two lines of the whole spectrum per line of this half.
    let samples = 2 * (spectrum.len() - 1);
    let scattered = 2.0 * low.iter().sum::<f64>() / samples.max(1) as f64;
    scattered < 0.05 * 0.05 * torque_power || mean(low) < 10.0 * mean(high)
}
