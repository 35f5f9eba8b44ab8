//! Velocities and accelerations from positions: from their Fourier series, or by filter and differences.

use super::{Chain, Derivatives, Record, describe, padding};
use crate::dynamics::Motion;
use crate::model::decimals;
use crate::preparation::cutoff::{POSITION_ORDER, position_cutoff};
use crate::preparation::error::PreprocessError;
use crate::preparation::filter::{
    LowPass, central_difference, central_difference_periodic, fourth_order_difference, fourth_order_difference_periodic,
    zero_phase,
};
use crate::preparation::fourier_fit::fourier_fit;
use crate::preparation::motion_error::MotionError;
use crate::preparation::options::{Choice, FilterSpec, Method};
use rayon::prelude::*;

/// The paper's filter of positions (section 4.3).
const PAPER_POSITION: FilterSpec = FilterSpec {
    order: 20,
    cutoff_hz: 2.0,
};

impl Chain<'_> {
    /// q, qd, qdd, and what is not known of them.
    pub(crate) fn differentiate(&self, record: &Record, choices: &mut Vec<Choice>) -> Result<Derivatives, PreprocessError> {
        match self.method(record) {
            Method::FourierFit => self.by_fourier(record, choices),
            method => self.by_filter(record, method, choices),
        }
    }

    fn by_fourier(&self, record: &Record, choices: &mut Vec<Choice>) -> Result<Derivatives, PreprocessError> {
        let Some(periods) = &record.periods else {
            return Err(PreprocessError::NotPeriodic {
                log: self.log.name.clone(),
            });
        };
        let noise = |j: usize| record.position_noise.as_ref().map(|v| &v[j]);
        let fits: Vec<_> = record
            .q
            .par_iter()
            .enumerate()
            .map(|(j, q)| {
                self.cancel.leave_if_set();
                fourier_fit(q, periods.period_s, noise(j), record.order)
            })
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
        let worst = fits.iter().map(|f| f.error.std_dev[2]).fold(0.0, f64::max);
        choices.push(Choice::new(
            "derivatives",
            format!("Fourier fit, harmonics per joint {kept:?}, highest {highest} ({:.2} Hz)", highest as f64 / periods.period_s),
            format!(
                "the log repeats; harmonics that stand above the position noise are kept and differentiated exactly, which leaves at most \
                 {worst:.2e} rad/s² (m/s²) of noise in the accelerations"
            ),
        ));
        Ok(Derivatives {
            motion,
            error: fits.into_iter().map(|f| f.error).collect(),
            filter: None,
        })
    }

    fn by_filter(&self, record: &Record, method: Method, choices: &mut Vec<Choice>) -> Result<Derivatives, PreprocessError> {
        let periodic = record.periods.is_some();
        let (spec, why) = match (self.options.position_filter, method) {
            (Some(spec), _) => (spec, "given"),
            (None, Method::Paper) => (PAPER_POSITION, "the paper's section 4.3"),
            (None, _) => (
                self.position_default(),
                "it leaves what stands above the noise of the positions as it is, and takes off what would bring their accelerations more noise \
                 than signal",
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
            self.cancel.leave_if_set();
            let q = zero_phase(&filter, raw, padding, filter.settling_samples());
            self.cancel.leave_if_set();
            let qd = difference(&q, step);
            let qdd = difference(&qd, step);
            (filtered_error(raw, &q, &filter), [q, qd, qdd])
        };
        let (mut errors, states): (Vec<MotionError>, Vec<[Vec<f64>; 3]>) = record.q.par_iter().map(of_joint).unzip();
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
                        errors[j].std_dev[1] = filtered_noise(&logged[j], qd, &filter);
                    }
                    let why = "they agree with the positions; filtered alike, and differenced once for the accelerations";
                    ("used", why.to_string())
                }
            };
            choices.push(Choice::new("logged_velocities", choice.0, choice.1));
        }
        Ok(Derivatives {
            motion,
            error: errors,
            // The paper asks no more of its ends than its filter of torques does.
            filter: (method != Method::Paper).then_some(filter),
        })
    }

    fn differs(&self, joint: usize, part: f64) -> String {
        format!(
            "those of joint {} are {} % of their size off the positions' derivative: another unit, sign or delay",
            joint + 1,
            decimals(100.0 * part, 0)
        )
    }

    /// Positions are filtered before the model sees them, torques are not: what the filter takes off the motion, a fraction
    /// (f/f_c)^2n at frequency f, is missing in the model alone and bends the parameters. At twice the highest frequency of the
    /// signal that is 2^-16, a hundredth of what the noise of a good log leaves in a parameter; where noise lets more through,
    /// the row filter ends it, or the lower cut-off of [`position_cutoff`] does.
    fn position_default(&self) -> FilterSpec {
        FilterSpec {
            order: POSITION_ORDER,
            cutoff_hz: position_cutoff(self.log, self.cancel),
        }
    }
}

const NOT_USED: &str = "not used";

/// Velocities this near to the derivative of the positions are the same quantity: a twentieth is a delay of 8 ms at 1 Hz.
const SAME_VELOCITY: f64 = 0.05;

/// The joint whose logged velocities are farthest from those of `motion`, and by which part of their root mean square; `None`
/// where all are the same. Joints that stand still say nothing.
fn disagreement(logged: &[Vec<f64>], motion: &Motion) -> Option<(usize, f64)> {
    let rms = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    let sizes: Vec<f64> = (0..logged.len())
        .map(|j| rms(&mut motion.velocities(j).iter().copied()))
        .collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let part = |(j, v): (usize, &Vec<f64>)| {
        let off = rms(&mut v.iter().zip(motion.velocities(j)).map(|(a, b)| a - b));
        (!off.is_finite() || sizes[j] > 0.01 * fastest).then(|| (j, off / sizes[j]))
    };
    let worst = logged
        .iter()
        .enumerate()
        .filter_map(part)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    // What is no number is not the same either.
    (worst.1.is_nan() || worst.1 > SAME_VELOCITY).then_some(worst)
}

/// Standard deviation of what `filter` leaves of the white noise that it took most of: `2 fc/f_s` of its variance.
fn filtered_noise(raw: &[f64], filtered: &[f64], filter: &LowPass) -> f64 {
    let removed = raw.iter().zip(filtered).map(|(r, f)| (r - f).powi(2)).sum::<f64>() / raw.len() as f64;
    let share = 2.0 * filter.cutoff_hz / filter.rate_hz;
    (removed * share / (1.0 - share).max(0.1)).sqrt()
}

/// Error that is left after filtering, from what the filter took out: white noise, taken out above the cut-off.
fn filtered_error(raw: &[f64], filtered: &[f64], filter: &LowPass) -> MotionError {
    let removed = raw.iter().zip(filtered).map(|(r, f)| (r - f).powi(2)).sum::<f64>() / raw.len() as f64;
    let share = 1.0 - 2.0 * filter.cutoff_hz / filter.rate_hz;
    MotionError::behind_low_pass(removed / share.max(0.1), filter.cutoff_hz, filter.rate_hz)
}
