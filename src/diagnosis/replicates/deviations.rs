//! Levels of one joint fitted to what the periods deviate from their mean: courses of time, and a constant in every period.

use super::level::{Along, Level};
use crate::diagnosis::selection::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{NoiseModel, Stretch, deviation, reduce};
use nalgebra::{DMatrix, DVector};

const DEGREE: usize = SETTINGS.replicates.level_degree;

/// Courses of one joint that are tried: each degree, each time constant, and the levels of the periods.
pub(crate) const TRIES: usize = DEGREE + SETTINGS.replicates.level_constants.len() + 1;

/// Whitened deviations of one joint from the mean over the periods.
pub(crate) struct Deviations<'a> {
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
    pub fn of(stretch: &'a Stretch, noise: &'a NoiseModel, joint: usize, first: usize) -> Self {
        let all = noise.whitened_rows(&stretch.kept(&stretch.motion, joint), false);
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
    pub fn levels(&self, tries: f64) -> Vec<Level> {
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
        powers
            .chain(SETTINGS.replicates.level_constants.map(|c| course(&|x| (-x / c).exp())))
            .collect()
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
