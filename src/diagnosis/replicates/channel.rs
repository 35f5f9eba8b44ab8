//! Friction or torque of one joint that follows a measured quantity, such as a temperature, from what the periods deviate from
//! their mean.
//!
//! Such a quantity has the last word over the time of the log: a joint that warms up drifts with its temperature, and the
//! temperature is what the next log will have.

use super::period_finding::{Seams, start_rows};
use crate::diagnosis::selection::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{NoiseModel, Reduced, Stretch, deviation, reduce};
use nalgebra::{DMatrix, DVector};

/// A joint whose torque follows a channel.
#[derive(Debug, Clone)]
pub(crate) struct Following {
    pub joint: usize,
    /// Number of the channel.
    pub channel: usize,
    /// BIC difference, as that of a drift.
    pub evidence: f64,
    /// Chance of the gain without it, times the number tried.
    pub p_value: f64,
    /// What it adds to the torque of the joint, without its mean over the log [N·m or N]; P × M.
    pub torque: Vec<Vec<f64>>,
}

/// Functions of the velocity that a channel may change the factor of: a torque, viscous and Coulomb friction.
const FACTORS: [fn(f64) -> f64; 3] = [|_| 1.0, |v| v, |v| if v == 0.0 { 0.0 } else { v.signum() }];

/// Which of the [`FACTORS`] go together.
const SETS: [&[usize]; 5] = [&[0], &[1], &[2], &[1, 2], &[0, 1, 2]];

/// Powers of the channel, about its mean: a parabola is near enough to whatever curve the search will name.
const POWERS: [i32; 2] = [1, 2];

/// The joint and the channel that explain most of what the periods deviate from each other by; none where the log has no channel
/// that changes from period to period.
pub(crate) fn best_following(stretch: &Stretch, noise: &[NoiseModel], seams: &Seams) -> Option<Following> {
    if stretch.channel_periods.len() != stretch.periods.len() || stretch.channel_periods.is_empty() {
        return None;
    }
    let channels = stretch.channel_periods[0].len();
    let tries = (stretch.joints() * channels * SETS.len() * POWERS.len()) as f64;
    let places = (0..channels).flat_map(|c| (0..stretch.joints()).map(move |j| (c, j)));
    let all = places.filter_map(|(c, j)| following(stretch, noise, seams, j, c));
    let mut best = all.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    best.p_value *= tries;
    Some(best)
}

/// The courses of a channel over the log, by power: `(x - x̄)ᵏ` in units of its standard deviation; P × M each. None of one that
/// stands still.
fn courses(stretch: &Stretch, channel: usize) -> Option<Vec<Vec<Vec<f64>>>> {
    let values = |p: usize| &stretch.channel_periods[p][channel].values;
    let (periods, rows) = (stretch.periods.len(), stretch.rows());
    if (0..periods).any(|p| values(p).len() != rows) {
        return None;
    }
    let count = (periods * rows) as f64;
    let sum = |f: &dyn Fn(f64) -> f64| (0..periods).flat_map(|p| values(p).iter()).map(|x| f(*x)).sum::<f64>() / count;
    let mean = sum(&|x| x);
    let spread = sum(&|x| (x - mean).powi(2)).sqrt();
    // A channel that is constant but for rounding follows nothing.
    if spread <= 1e-9 * mean.abs() || spread == 0.0 {
        return None;
    }
    let power = |k: i32| {
        let of = |p: usize| values(p).iter().map(|x| ((x - mean) / spread).powi(k)).collect();
        (0..periods).map(of).collect()
    };
    Some(POWERS.map(power).to_vec())
}

fn following(stretch: &Stretch, noise: &[NoiseModel], seams: &Seams, j: usize, channel: usize) -> Option<Following> {
    let courses = courses(stretch, channel)?;
    let keep = seams.whitened_rows(&noise[j], stretch.kept(&stretch.motion, j));
    let columns = Columns::new(stretch, &courses, j);
    let count = columns.count();
    let (mut own, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for (p, period) in stretch.periods.iter().enumerate() {
        let mut here = keep.clone();
        if p == 0 {
            let reach = (start_rows(stretch) + noise[j].autoregression.len()).min(stretch.rows());
            here[..reach].fill(false);
        }
        let white = |k: usize| DVector::from_vec(noise[j].whiten(&columns.of(k, p), &here, 1));
        let block = DMatrix::from_columns(&(0..count).map(white).collect::<Vec<_>>());
        let deviation = DVector::from_vec(noise[j].whiten(&deviation(stretch, period, j), &here, 1));
        own += block.tr_mul(&block);
        right += block.tr_mul(&deviation);
    }
    let chosen = subsets().filter_map(|which| Chosen::new(&own, &right, which));
    let best = chosen.max_by(|a, b| a.evidence().total_cmp(&b.evidence()))?;
    let torque = |p: usize| {
        let parts = best.which.iter().enumerate();
        let parts = parts.map(|(i, &k)| (best.reduced.coefficients[i], columns.of(k, p)));
        parts.fold(vec![0.0; stretch.rows()], |mut sum, (c, column)| {
            sum.iter_mut().zip(&column).for_each(|(s, v)| *s += c * v);
            sum
        })
    };
    Some(Following {
        joint: j,
        channel,
        evidence: best.evidence(),
        p_value: chance(best.reduced.gain, best.reduced.rank),
        torque: (0..stretch.periods.len()).map(torque).collect(),
    })
}

/// Numbers of the columns of every set, with the first power alone and with all.
fn subsets() -> impl Iterator<Item = Vec<usize>> {
    let of = |set: &'static [usize]| {
        let up_to = move |powers: usize| {
            (0..powers)
                .flat_map(move |k| set.iter().map(move |f| f + k * FACTORS.len()))
                .collect()
        };
        (1..=POWERS.len()).map(up_to)
    };
    SETS.into_iter().flat_map(of)
}

/// Some of the columns, fitted.
struct Chosen {
    which: Vec<usize>,
    reduced: Reduced,
}

impl Chosen {
    fn new(own: &DMatrix<f64>, right: &DVector<f64>, which: Vec<usize>) -> Option<Self> {
        let part = own.select_rows(&which).select_columns(&which);
        let reduced = reduce(&part, &part, &right.select_rows(&which));
        (reduced.rank > 0 && reduced.gain.is_finite()).then_some(Self { which, reduced })
    }

    fn evidence(&self) -> f64 {
        self.reduced.gain - self.reduced.rank as f64 * SETTINGS.replicates.parameter_price
    }
}

/// Factors times courses, whose mean over the periods is taken out row by row.
struct Columns<'a> {
    courses: &'a [Vec<Vec<f64>>],
    speeds: &'a [f64],
    means: Vec<Vec<f64>>,
}

impl<'a> Columns<'a> {
    fn new(stretch: &'a Stretch, courses: &'a [Vec<Vec<f64>>], j: usize) -> Self {
        // The start of the first period is filled with the others' mean, and is no part of the mean there.
        let (start, periods) = (start_rows(stretch), stretch.periods.len());
        let mean = |course: &Vec<Vec<f64>>| {
            let at = |s: usize| {
                let first = usize::from(s < start);
                course[first..].iter().map(|c| c[s]).sum::<f64>() / (periods - first) as f64
            };
            (0..stretch.rows()).map(at).collect()
        };
        Self {
            means: courses.iter().map(mean).collect(),
            courses,
            speeds: stretch.motion.velocities(j),
        }
    }

    fn count(&self) -> usize {
        FACTORS.len() * self.courses.len()
    }

    fn of(&self, k: usize, period: usize) -> Vec<f64> {
        let (factor, course) = (FACTORS[k % FACTORS.len()], k / FACTORS.len());
        let change = self.courses[course][period].iter().zip(&self.means[course]);
        change
            .zip(self.speeds)
            .map(|((x, mean), v)| (x - mean) * factor(*v))
            .collect()
    }
}
