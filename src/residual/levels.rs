//! Torque that is not the same all through a log, whatever the robot does: a level that drifts with time, or that differs from period to
//! period. No effect of the list is of that kind, so it is never a finding; it is a remainder that depends on `time` or on `period`.
//!
//! Deviations of the periods from their mean need no model of the robot. A level of joint j is `g(t)` on its rows, with g one of a few smooth
//! courses over the log, or a constant of its own in every period. Both are held against the noise from row to row.

use super::candidate::chance;
use super::noise::deviation;
use super::projection::reduce;
use super::remainder::{LEAST_SIZE, PREFERENCE};
use super::{NoiseModel, Stretch};
use nalgebra::{DMatrix, DVector};

/// What a level goes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Along {
    Time,
    Period,
}

impl Along {
    /// As in [`Remainder::depends_on`](super::Remainder::depends_on).
    pub fn name(self) -> &'static str {
        match self {
            Along::Time => "time",
            Along::Period => "period",
        }
    }
}

/// A level that is not the same all through the log, on one joint.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    pub joint: usize,
    pub along: Along,
    /// Two log evidence ratios: the decrease of the weighted sum of squares of the deviations, less what parameters and courses tried cost.
    pub evidence: f64,
    /// Chance of the gain without it, times the number of hypotheses tried.
    pub p_value: f64,
    /// Its torque without its mean over the log [N·m or N]; P × M.
    pub torque: Vec<Vec<f64>>,
}

/// Polynomials up to this degree stand in for courses that are neither fast nor exponential: a cubic has two turns, one more for safety.
const DEGREE: usize = 4;
/// Time constants of warming up, in units of the length of the log; longer ones are polynomials. A ratio of 1.8 leaves a fiftieth of the square of
/// any between two of them: `(2√r/(1 + r))²` is 0.979 for the r = √1.8 to the nearer.
const CONSTANTS: [f64; 6] = [0.06, 0.1, 0.18, 0.32, 0.6, 1.0];
/// Courses of one joint that are tried: each degree, each time constant, and the levels of the periods.
const TRIES: usize = DEGREE + CONSTANTS.len() + 1;

impl Level {
    /// RMS over the log [N·m or N].
    pub fn rms(&self) -> f64 {
        let count = self.torque.iter().map(Vec::len).sum::<usize>().max(1);
        (self.torque.iter().flatten().map(|v| v * v).sum::<f64>() / count as f64).sqrt()
    }

    /// Takes the level out of the torque of its joint.
    pub fn take_out(&self, periods: &mut [Vec<Vec<f64>>]) {
        self.add(periods, -1.0);
    }

    /// What [`take_out`](Self::take_out) took.
    pub fn put_back(&self, periods: &mut [Vec<Vec<f64>>]) {
        self.add(periods, 1.0);
    }

    fn add(&self, periods: &mut [Vec<Vec<f64>>], factor: f64) {
        for (period, own) in periods.iter_mut().zip(&self.torque) {
            period[self.joint].iter_mut().zip(own).for_each(|(t, v)| *t += factor * v);
        }
    }
}

/// The stretch without a parabola in what every period deviates from the mean. Its noise is that from row to row: levels and drifts that are in the
/// periods would pass for noise that is slow, and hide themselves in it.
pub(crate) fn without_slow(stretch: &Stretch) -> Stretch {
    let rows = stretch.rows();
    let x = |s: usize| (2.0 * s as f64 + 1.0) / rows as f64 - 1.0;
    let square = (0..rows).map(|s| x(s) * x(s)).sum::<f64>() / rows as f64;
    // Orthogonal to each other on rows that lie evenly to both sides.
    let basis: [&dyn Fn(usize) -> f64; 3] = [&|_: usize| 1.0, &x, &|s: usize| x(s) * x(s) - square];
    let mut periods = stretch.periods.clone();
    for period in &mut periods {
        for j in 0..stretch.joints() {
            let off = deviation(stretch, period, j);
            for b in basis {
                let (along, norm) = (0..rows).fold((0.0, 0.0), |(a, n), s| (a + b(s) * off[s], n + b(s) * b(s)));
                let size = along / norm.max(f64::MIN_POSITIVE);
                period[j].iter_mut().enumerate().for_each(|(s, t)| *t -= size * b(s));
            }
        }
    }
    Stretch {
        periods,
        ..stretch.clone()
    }
}

/// The level with the best evidence over all joints, where it is beyond chance and large enough to act on.
///
/// `first` are the rows of the first period that do not count.
pub(crate) fn best_level(stretch: &Stretch, noise: &[NoiseModel], first: usize, limit: f64) -> Option<Level> {
    let of_joint = |j: usize| {
        let deviations = Deviations::of(stretch, &noise[j], j, first);
        let tries = (TRIES * stretch.joints()) as f64;
        deviations.levels(tries).into_iter()
    };
    let is_worth_telling = |level: &Level| {
        level.p_value < limit && level.evidence > PREFERENCE && level.rms() > LEAST_SIZE * noise[level.joint].std_dev
    };
    let all = (0..stretch.joints()).flat_map(of_joint).filter(is_worth_telling);
    all.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Whitened deviations of one joint from the mean over the periods.
struct Deviations<'a> {
    stretch: &'a Stretch,
    noise: &'a NoiseModel,
    joint: usize,
    /// Rows of the first period that do not count.
    first: usize,
    /// Rows that count, in the first period and in the others.
    rows: [Vec<bool>; 2],
    /// Per period.
    white: Vec<DVector<f64>>,
}

impl<'a> Deviations<'a> {
    fn of(stretch: &'a Stretch, noise: &'a NoiseModel, joint: usize, first: usize) -> Self {
        let all = noise.whitened_rows(&stretch.kept(&stretch.motion, joint), stretch.periodic);
        let mut later = all.clone();
        let reach = (first + noise.autoregression.len()).min(later.len());
        later[..reach].fill(false);
        let rows = [later, all];
        let white = stretch.periods.iter().enumerate().map(|(p, period)| {
            let raw = deviation(stretch, period, joint);
            DVector::from_vec(noise.whiten(&raw, &rows[usize::from(p > 0)], 1))
        });
        Self {
            white: white.collect(),
            stretch,
            noise,
            joint,
            first,
            rows,
        }
    }

    fn whitened(&self, period: usize, values: &[f64]) -> DVector<f64> {
        DVector::from_vec(self.noise.whiten(values, &self.rows[usize::from(period > 0)], 1))
    }

    /// The best course of time, and the levels of the periods.
    fn levels(&self, tries: f64) -> Vec<Level> {
        let courses = self.courses();
        let (own, right) = self.normal_equations(&courses);
        let polynomials = (1..=DEGREE).map(|degree| (0..degree).collect::<Vec<_>>());
        let exponentials = (DEGREE..courses.len()).map(|k| vec![k]);
        let with = |set: Vec<usize>| self.of_time(&courses, &set, &own, &right, tries);
        let timed = polynomials.chain(exponentials).map(with);
        let best = timed.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        best.into_iter().chain([self.of_periods(tries)]).collect()
    }

    /// Values of every course in every period, over the rows: powers of the time of the log from −1 to 1, then `exp(−t/T)`.
    fn courses(&self) -> Vec<Vec<Vec<f64>>> {
        let (starts, rows) = (&self.stretch.starts, self.stretch.rows());
        let step = self.stretch.interval * self.stretch.motion.samples() as f64 / rows as f64;
        let since = |p: usize, s: usize| starts[p] - starts[0] + s as f64 * step;
        let length = since(starts.len() - 1, rows);
        let course = |value: &dyn Fn(f64) -> f64| {
            let of_period = |p: usize| (0..rows).map(|s| value(since(p, s) / length)).collect();
            (0..starts.len()).map(of_period).collect::<Vec<Vec<f64>>>()
        };
        let powers = (1..=DEGREE).map(|d| course(&|x| (2.0 * x - 1.0).powi(d as i32)));
        powers.chain(CONSTANTS.map(|c| course(&|x| (-x / c).exp()))).collect()
    }

    /// `C'C` and `C'd` of the whitened courses, their mean over the periods taken out as it is of the data.
    fn normal_equations(&self, courses: &[Vec<Vec<f64>>]) -> (DMatrix<f64>, DVector<f64>) {
        let (count, k) = (self.white.len(), courses.len());
        let means: Vec<Vec<f64>> = courses.iter().map(|c| self.mean_over_periods(c)).collect();
        let (mut own, mut right) = (DMatrix::zeros(k, k), DVector::zeros(k));
        for p in 0..count {
            let column = |(course, mean): (&Vec<Vec<f64>>, &Vec<f64>)| {
                let raw: Vec<f64> = course[p].iter().zip(mean).map(|(v, m)| v - m).collect();
                self.whitened(p, &raw)
            };
            let columns: Vec<DVector<f64>> = courses.iter().zip(&means).map(column).collect();
            let columns = DMatrix::from_columns(&columns);
            own += columns.tr_mul(&columns);
            right += columns.tr_mul(&self.white[p]);
        }
        (own, right)
    }

    /// Where the start of the first period is filled with the others' mean, it is no part of the mean.
    fn mean_over_periods(&self, course: &[Vec<f64>]) -> Vec<f64> {
        let mean = |s: usize| {
            let counted = &course[usize::from(s < self.first)..];
            counted.iter().map(|period| period[s]).sum::<f64>() / counted.len() as f64
        };
        (0..self.stretch.rows()).map(mean).collect()
    }

    fn of_time(&self, courses: &[Vec<Vec<f64>>], set: &[usize], own: &DMatrix<f64>, right: &DVector<f64>, tries: f64) -> Level {
        let own = own.select_rows(set).select_columns(set);
        let reduced = reduce(&own, &own, &right.select_rows(set));
        let value = |p: usize, s: usize| {
            let parts = set.iter().zip(reduced.coefficients.iter());
            parts.map(|(&k, c)| c * courses[k][p][s]).sum::<f64>()
        };
        self.level(Along::Time, reduced.gain, reduced.rank, tries, value)
    }

    /// A constant in every period: deviations from the mean sum to zero, so that one of the constants is spent.
    fn of_periods(&self, tries: f64) -> Level {
        let unit = vec![1.0; self.stretch.rows()];
        let fit = |(p, white): (usize, &DVector<f64>)| {
            let unit = self.whitened(p, &unit);
            let (along, square) = (unit.dot(white), unit.norm_squared().max(f64::MIN_POSITIVE));
            (along / square, along * along / square)
        };
        let fits: Vec<(f64, f64)> = self.white.iter().enumerate().map(fit).collect();
        let gain = fits.iter().map(|f| f.1).sum();
        self.level(Along::Period, gain, fits.len() - 1, tries, |p, _| fits[p].0)
    }

    fn level(&self, along: Along, gain: f64, rank: usize, tries: f64, value: impl Fn(usize, usize) -> f64) -> Level {
        let (count, rows) = (self.white.len(), self.stretch.rows());
        let mut torque: Vec<Vec<f64>> = (0..count).map(|p| (0..rows).map(|s| value(p, s)).collect()).collect();
        let mean = torque.iter().flatten().sum::<f64>() / (count * rows) as f64;
        torque.iter_mut().flatten().for_each(|v| *v -= mean);
        let price = ((count * rows) as f64).ln();
        Level {
            joint: self.joint,
            along,
            evidence: gain - rank as f64 * price - 2.0 * tries.ln(),
            p_value: (chance(gain, rank) * tries).min(1.0),
            torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Motion;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;

    const PERIODS: usize = 5;
    const ROWS: usize = 400;

    /// Box and Muller.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }

    /// Five periods of 4 s of two joints with unit noise, correlated from row to row, and a level on the second joint.
    fn stretch(seed: u64, correlation: f64, level: impl Fn(usize, f64) -> f64) -> Stretch {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wave = |j: usize, s: usize| (TAU * (j + 1) as f64 * s as f64 / ROWS as f64 + 0.3).sin_cos();
        let motion = Motion::from_fn(2, ROWS, |j, s| {
            let ((sin, cos), w) = (wave(j, s), 0.5 * TAU * (j + 1) as f64 / 2.0);
            [sin, w * cos, -w * w * sin]
        });
        let mut last = [0.0; 2];
        let mut periods = vec![vec![vec![0.0; ROWS]; 2]; PERIODS];
        for at in 0..PERIODS * ROWS {
            let (p, s) = (at / ROWS, at % ROWS);
            for j in 0..2 {
                last[j] = correlation * last[j] + (1.0 - correlation * correlation).sqrt() * normal(&mut rng);
                periods[p][j][s] = last[j]
                    + if j == 1 {
                        level(p, at as f64 / (PERIODS * ROWS) as f64)
                    } else {
                        0.0
                    };
            }
        }
        let mut whole = Stretch {
            periods,
            starts: (0..PERIODS).map(|p| 4.0 * p as f64).collect(),
            ..Stretch::of_motion(motion, 0.01, true)
        };
        whole.torque = whole.mean_over(&[0, 1, 2, 3, 4]);
        whole
    }

    fn noise(stretch: &Stretch) -> Vec<NoiseModel> {
        let own = without_slow(stretch);
        (0..2)
            .map(|j| NoiseModel::from_periods(std::slice::from_ref(&own), j).unwrap())
            .collect()
    }

    /// Chances that are told are no smaller than they are: of 200 logs, 100 of them with correlated noise, one in twenty falls below one in twenty. And
    /// none has a level.
    #[test]
    fn prop_noise_has_no_level() {
        let mut below = 0;
        for seed in 0..200 {
            let whole = stretch(seed, if seed % 2 == 0 { 0.0 } else { 0.7 }, |_, _| 0.0);
            let noise = noise(&whole);
            assert!(best_level(&whole, &noise, 20, 1e-3).is_none(), "seed {seed}");
            let of = |j: usize| Deviations::of(&whole, &noise[j], j, 20).levels((2 * TRIES) as f64);
            let least = (0..2).flat_map(of).map(|l| l.p_value).fold(1.0, f64::min);
            below += usize::from(least < 0.05);
        }
        // Ten are expected; more than 22 come once in ten thousand times.
        assert!(below <= 22, "{below} of 200");
    }

    #[test]
    fn prop_a_drift_goes_with_time_and_levels_with_periods() {
        // A line, warming up, and levels in no order, of about the size of the noise.
        let levels = [0.9, -0.8, 0.7, -0.9, 0.1];
        let line = stretch(1, 0.0, |_, x| 2.0 * x);
        let warm = stretch(2, 0.7, |_, x| 3.0 * (-x / 0.25).exp());
        let steps = stretch(3, 0.0, |p, _| levels[p]);
        for (whole, along, rms) in [
            // 2/√12; 3 times the deviation of e^(−4x) from its mean over the log; the root of the mean square.
            (line, Along::Time, 0.577),
            (warm, Along::Time, 0.762),
            (steps, Along::Period, 0.743),
        ] {
            let level = best_level(&whole, &noise(&whole), 20, 1e-3).unwrap();
            assert_eq!((level.joint, level.along), (1, along));
            assert!((level.rms() - rms).abs() < 0.1 * rms, "{} for {rms}", level.rms());
            // With it taken out there is nothing left.
            let mut rest = whole.clone();
            level.take_out(&mut rest.periods);
            rest.torque = rest.mean_over(&[0, 1, 2, 3, 4]);
            assert!(best_level(&rest, &noise(&rest), 20, 1e-3).is_none());
        }
    }
}
