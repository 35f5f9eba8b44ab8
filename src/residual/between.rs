//! What changes from one period to the next: friction that drifts, and contacts. The average hides both.
//!
//! Deviations of every period from the average need no model of the robot. Drift on a joint is friction columns times the course of
//! warming up; a contact is a level on all joints in an interval of time. Whichever explains more is taken out of the data, and the search
//! goes on until neither is beyond chance. Where a level of one joint that goes with time or period, which no cause is known of, explains clearly more,
//! it is taken out as well, and told as a remainder.

use super::candidate::chance;
use super::levels::{best_level, without_slow};
use super::projection::reduce;
use super::remainder::PREFERENCE;
use super::trace::joint_names;
use super::unsteady::{TakenOut, Unsteady};
use super::{Evidence, Finding, NoiseModel, ReportedParameter, RmsPair, Stretch};
use crate::effects::by_code;
use crate::model::Robot;
use nalgebra::{DMatrix, DVector};

/// Drift or contact, with its fit.
#[derive(Debug, Clone)]
pub(crate) struct BetweenFinding {
    effect: &'static str,
    joints: Vec<usize>,
    parameters: Vec<ReportedParameter>,
    gain: f64,
    p_value: f64,
    /// First row of an interval, counted over all periods.
    first_row: Option<usize>,
    pub rms: Option<(RmsPair, RmsPair)>,
}

impl BetweenFinding {
    /// Two log evidence ratios, at the log of about ten thousand rows for every parameter.
    fn evidence(&self) -> f64 {
        self.gain - self.parameters.len() as f64 * 9.0
    }

    pub fn finding(&self, robot: &Robot, otherwise: &RmsPair) -> Finding {
        let (rms_before, rms_after) = self.rms.clone().unwrap_or((otherwise.clone(), otherwise.clone()));
        let note = match self.effect {
            "external_contact" => "the interval is left out of the fit",
            _ => "base parameters are those of the mean over the log",
        };
        Finding {
            effect: self.effect.into(),
            joints: joint_names(robot, &self.joints),
            parameters: self.parameters.clone(),
            rms_before,
            rms_after,
            evidence: Evidence {
                gain: self.gain,
                log_evidence_ratio: self.evidence(),
                p_value: self.p_value,
                held_out_blocks: self.gain,
                held_out_periods: None,
            },
            rivals: Vec::new(),
            note: Some(note.into()),
        }
    }
}

const MOST_FINDINGS: usize = 6;

/// What changes between the periods, and the stretches without it.
pub(crate) struct Separated {
    /// Without drift, contacts and levels: what the model is fitted to.
    pub steady: Vec<Stretch>,
    /// Without drift and contacts, which are explained: what errors are told of.
    pub explained: Vec<Stretch>,
    pub found: Vec<BetweenFinding>,
    /// Levels that nothing explains.
    pub unsteady: Vec<Unsteady>,
}

pub(crate) fn separate(robot: &Robot, stretches: &[Stretch], limit: f64) -> Separated {
    let mut all = Separated {
        steady: Vec::new(),
        explained: Vec::new(),
        found: Vec::new(),
        unsteady: Vec::new(),
    };
    for stretch in stretches {
        let mut steady = stretch.clone();
        let mut explained = stretch.clone();
        if stretch.periods.len() >= 3 {
            // One sample of the motion to every row.
            let mut rows = stretch.as_coarse();
            let taken = separated(robot, &mut rows, limit, &mut all.found);
            if let Some(noise) = robust_noise(&rows).filter(|_| taken.count() > 0) {
                all.unsteady.extend(taken.told(&rows, &noise));
            }
            let whole = taken.put_back(&rows);
            (explained.periods, explained.torque) = (whole.periods, whole.torque);
            (steady.periods, steady.torque) = (rows.periods, rows.torque);
        }
        all.steady.push(steady);
        all.explained.push(explained);
    }
    all
}

/// Takes out of a stretch what changes between its periods, the strongest first; levels are handed back.
fn separated(robot: &Robot, stretch: &mut Stretch, limit: f64, found: &mut Vec<BetweenFinding>) -> TakenOut {
    let mut taken = TakenOut::default();
    let (mut named, most_levels) = (0, 2 * stretch.joints());
    leave_out_start(stretch);
    while named < MOST_FINDINGS && taken.count() < most_levels {
        let Some(noise) = robust_noise(stretch) else { break };
        let best = best_named(robot, stretch, &noise).filter(|(f, _)| f.p_value < limit);
        let least = best.as_ref().map_or(f64::NEG_INFINITY, |(f, _)| f.evidence() + PREFERENCE);
        let level = best_level(stretch, &noise, start_rows(stretch), limit).filter(|l| l.evidence > least);
        match (level, best) {
            (Some(level), _) => taken.take(level, stretch),
            (None, Some((finding, periods))) => {
                stretch.periods = periods;
                named += 1;
                // What goes on from the start is still the start: it is left out, and is nothing that somebody did to the arm.
                let start = start_rows(stretch) + shortest(stretch);
                if finding.first_row.is_none_or(|first| first > start) {
                    found.push(finding);
                }
            }
            (None, None) => break,
        }
        leave_out_start(stretch);
    }
    taken
}

/// Drift or contact, whichever explains more.
fn best_named(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel]) -> Option<Explained> {
    let drift = best_drift(robot, stretch, noise);
    let contact = best_contact(robot, stretch, noise);
    match (drift, contact) {
        (Some(d), Some(c)) => Some(if d.0.gain > c.0.gain { d } else { c }),
        (d, c) => d.or(c),
    }
}

/// Share of the first period in which friction still remembers where the robot stood before the log: no contact, and not the periodic state.
const START: f64 = 0.05;

/// Rows of the first period that do not count.
fn start_rows(stretch: &Stretch) -> usize {
    (START * stretch.rows() as f64) as usize
}

/// Fills the start with the mean of the other periods, as they are by now, and takes the mean over all.
fn leave_out_start(stretch: &mut Stretch) {
    let count = stretch.periods.len();
    for s in 0..start_rows(stretch) {
        for j in 0..stretch.joints() {
            stretch.periods[0][j][s] = stretch.periods[1..].iter().map(|p| p[j][s]).sum::<f64>() / (count - 1) as f64;
        }
    }
    let all: Vec<usize> = (0..count).collect();
    stretch.torque = stretch.mean_over(&all);
}

/// Noise from the quieter half of the periods of every joint, so that one disturbed period raises neither its level nor its correlation, and levels that
/// differ between the periods do not either.
fn robust_noise(stretch: &Stretch) -> Option<Vec<NoiseModel>> {
    let stretch = &without_slow(stretch);
    (0..stretch.joints())
        .map(|j| {
            let median = median_period(stretch, j);
            let mut periods: Vec<(f64, usize)> = (0..stretch.periods.len())
                .map(|p| {
                    (
                        stretch.periods[p][j]
                            .iter()
                            .zip(&median)
                            .map(|(t, m)| (t - m) * (t - m))
                            .sum(),
                        p,
                    )
                })
                .collect();
            periods.sort_by(|a, b| a.0.total_cmp(&b.0));
            let quiet: Vec<usize> = periods.iter().take(periods.len().div_ceil(2).max(2)).map(|p| p.1).collect();
            let half = Stretch {
                torque: stretch.mean_over(&quiet),
                periods: quiet.iter().map(|&p| stretch.periods[p].clone()).collect(),
                ..stretch.clone()
            };
            NoiseModel::from_periods(&[half], j)
        })
        .collect()
}

type Explained = (BetweenFinding, Vec<Vec<Vec<f64>>>);

/// Time constants tried, in units of the length of the log.
const COURSES: [f64; 7] = [0.1, 0.2, 0.35, 0.6, 1.0, 2.0, 5.0];

fn best_drift(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel]) -> Option<Explained> {
    let length = stretch.starts.last()? - stretch.starts[0] + stretch.rows() as f64 * stretch.interval;
    let tries = (COURSES.len() * robot.joint_count()) as f64;
    let mut best: Option<(f64, usize, f64)> = None;
    for j in 0..robot.joint_count() {
        let at = |course: f64| drift_fit(stretch, noise, j, course * length);
        for &course in &COURSES {
            let (gain, _, _) = at(course);
            if best.is_none_or(|b| gain > b.0) {
                best = Some((gain, j, course * length));
            }
        }
    }
    let (_, j, coarse) = best?;
    let drift = refined_drift(stretch, noise, j, coarse);
    let p_value = chance(drift.gain, 3) * tries;
    let finding = drift_finding(robot, stretch, noise, &drift, p_value);
    let Drift { course, solution, .. } = drift;
    let mut periods = stretch.periods.clone();
    let mean = mean_course(stretch, course);
    for (p, period) in periods.iter_mut().enumerate() {
        for s in 0..stretch.rows() {
            let v = stretch.motion.velocities(j)[s];
            let g = course_at(stretch, p, s, course) - mean;
            period[j][s] -= g * (solution[0] * v + solution[1] * direction(v));
        }
    }
    Some((finding, periods))
}

fn direction(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

/// `exp(−(t − t_0)/T)` with t_0 the start of the log.
fn course_at(stretch: &Stretch, period: usize, row: usize, constant: f64) -> f64 {
    (-(stretch.starts[period] - stretch.starts[0] + row as f64 * stretch.interval) / constant).exp()
}

fn mean_course(stretch: &Stretch, constant: f64) -> f64 {
    let (periods, rows) = (stretch.periods.len(), stretch.rows());
    let sum: f64 = (0..periods)
        .map(|p| (0..rows).map(|s| course_at(stretch, p, s, constant)).sum::<f64>())
        .sum();
    sum / (periods * rows) as f64
}

/// Friction of one joint that changes as `exp(−t/T)`, fitted to the deviations between periods.
struct Drift {
    joint: usize,
    gain: f64,
    /// T (s).
    course: f64,
    /// Viscous and Coulomb friction that fades.
    solution: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// Golden section on the logarithm of the time constant, a factor of three to either side: thirty steps leave 1e-6 of it, a hundredth of the standard
/// deviation of the strongest drift.
fn refined_drift(stretch: &Stretch, noise: &[NoiseModel], joint: usize, coarse: f64) -> Drift {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = ((coarse / 3.0).ln(), (coarse * 3.0).ln());
    for _ in 0..30 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        let gain = |x: f64| drift_fit(stretch, noise, joint, x.exp()).0;
        if gain(a) > gain(b) { high = b } else { low = a }
    }
    let course = (0.5 * (low + high)).exp();
    let (gain, solution, covariance) = drift_fit(stretch, noise, joint, course);
    Drift {
        joint,
        gain,
        course,
        solution,
        covariance,
    }
}

/// Least squares of the whitened deviations of all periods on friction times the course, whose mean over the periods is taken out.
fn drift_fit(stretch: &Stretch, noise: &[NoiseModel], j: usize, constant: f64) -> (f64, DVector<f64>, DMatrix<f64>) {
    let count = stretch.periods.len();
    let rows = stretch.rows();
    let keep = noise[j].whitened_rows(&stretch.kept(&stretch.motion, j), stretch.periodic);
    let speed = stretch.motion.velocities(j);
    // The start of the first period is filled with the others' mean: it says nothing, and is no part of the mean there.
    let start = start_rows(stretch);
    let mean: Vec<f64> = (0..rows)
        .map(|s| {
            let first = usize::from(s < start);
            (first..count).map(|p| course_at(stretch, p, s, constant)).sum::<f64>() / (count - first) as f64
        })
        .collect();
    let (mut own, mut right) = (DMatrix::zeros(2, 2), DVector::zeros(2));
    for (p, period) in stretch.periods.iter().enumerate() {
        let mut rows_here = keep.clone();
        if p == 0 {
            let reach = (start + noise[j].autoregression.len()).min(rows);
            rows_here[..reach].iter_mut().for_each(|k| *k = false);
        }
        let keep = &rows_here;
        let column = |f: fn(f64) -> f64| {
            let raw: Vec<f64> = (0..rows)
                .map(|s| (course_at(stretch, p, s, constant) - mean[s]) * f(speed[s]))
                .collect();
            noise[j].whiten(&raw, keep, 1)
        };
        let columns = DMatrix::from_columns(&[DVector::from_vec(column(|v| v)), DVector::from_vec(column(direction))]);
        let white = DVector::from_vec(noise[j].whiten(&super::noise::deviation(stretch, period, j), keep, 1));
        own += columns.tr_mul(&columns);
        right += columns.tr_mul(&white);
    }
    let reduced = reduce(&own, &own, &right);
    let covariance = own
        .clone()
        .try_inverse()
        .unwrap_or_else(|| DMatrix::from_element(2, 2, f64::INFINITY));
    (reduced.gain, reduced.coefficients, covariance)
}

/// Changes of friction from the start of the log to its end, with the time constant that they were fitted with (variable projection: the gain
/// falls by one at one standard deviation of it, and the coefficients move with it).
fn drift_finding(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel], drift: &Drift, p_value: f64) -> BetweenFinding {
    let (j, course) = (drift.joint, drift.course);
    let last = stretch.periods.len() - 1;
    let swing = |constant: f64| course_at(stretch, last, stretch.rows() - 1, constant) - 1.0;
    // A tenth of the time constant to both sides is where the gain is still a parabola.
    let step = 0.1 * course;
    let sides = [course - step, course + step].map(|t| (drift_fit(stretch, noise, j, t), swing(t)));
    let curvature = 2.0 * drift.gain - sides[0].0.0 - sides[1].0.0;
    let of_course = step * (2.0 / curvature.max(f64::MIN_POSITIVE)).sqrt();
    let infos = by_code("friction_drift").expect("is in the list").parameters(0, robot, &[j]);
    let change = |(i, info): (usize, crate::effects::ParameterInfo)| {
        let slope = (sides[1].0.1[i] * sides[1].1 - sides[0].0.1[i] * sides[0].1) / (2.0 * step);
        let alone = drift.covariance[(i, i)].max(0.0).sqrt() * swing(course);
        ReportedParameter {
            name: format!("{}_over_log", info.name),
            value: drift.solution[i] * swing(course),
            unit: info.unit,
            std_dev: alone.hypot(slope * of_course),
        }
    };
    let mut parameters: Vec<ReportedParameter> = infos.into_iter().enumerate().map(change).collect();
    parameters.push(ReportedParameter {
        name: "time_constant".into(),
        value: course,
        unit: "s".into(),
        std_dev: of_course,
    });
    BetweenFinding {
        effect: "friction_drift",
        joints: vec![j],
        parameters,
        gain: drift.gain,
        p_value,
        first_row: None,
        rms: None,
    }
}

/// The interval of time in which the deviations of all joints from the median period are least like noise.
fn best_contact(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel]) -> Option<Explained> {
    let (count, rows, n) = (stretch.periods.len(), stretch.rows(), stretch.joints());
    let length = count * rows;
    // Running sums of whitened deviations and of the whitened unit level, per joint, over all periods one after the other.
    let mut sums = vec![vec![0.0; length + 1]; n];
    let mut levels = vec![vec![0.0; length + 1]; n];
    for j in 0..n {
        // At a reversal a jump of friction that comes a sample later in one period is no touch.
        let keep = noise[j].whitened_rows(&stretch.kept(&stretch.motion, j), stretch.periodic);
        let unit = noise[j].whiten(&vec![1.0; rows], &keep, 1);
        let median = median_period(stretch, j);
        for (p, period) in stretch.periods.iter().enumerate() {
            let deviation: Vec<f64> = period[j].iter().zip(&median).map(|(t, m)| t - m).collect();
            let white = noise[j].whiten(&deviation, &keep, 1);
            for s in 0..rows {
                let at = p * rows + s;
                sums[j][at + 1] = sums[j][at] + unit[s] * white[s];
                levels[j][at + 1] = levels[j][at] + unit[s] * unit[s];
            }
        }
    }
    let statistic = |from: usize, to: usize| -> f64 {
        (0..n)
            .map(|j| {
                let level = levels[j][to] - levels[j][from];
                if level > 0.0 {
                    (sums[j][to] - sums[j][from]).powi(2) / level
                } else {
                    0.0
                }
            })
            .sum()
    };
    let (mut best, mut windows) = ((0.0, 0, 0), 0.0);
    let shortest = shortest(stretch);
    let mut width = shortest;
    while width <= rows {
        for from in (start_rows(stretch)..length.saturating_sub(width)).step_by((width / 4).max(1)) {
            windows += 1.0;
            let gain = statistic(from, from + width);
            if gain > best.0 {
                best = (gain, from, from + width);
            }
        }
        width = width * 3 / 2;
    }
    let (gain, from, to) = sharpened(best, length, shortest, &statistic);
    // The median over P periods has π/2 of the variance of their mean.
    let fair = gain / (1.0 + 0.5 * std::f64::consts::PI / count as f64);
    let p_value = chance(fair, n) * windows;
    let level = |j: usize| {
        let l = levels[j][to] - levels[j][from];
        (
            (sums[j][to] - sums[j][from]) / l.max(f64::MIN_POSITIVE),
            l.max(f64::MIN_POSITIVE).sqrt().recip(),
        )
    };
    // A touch that stays below the noise of every joint is slow drift of something else.
    let felt = (0..n).any(|j| level(j).0.abs() > noise[j].std_dev);
    if !felt || to - from > rows {
        return None;
    }
    // Joints that feel it: four standard deviations, one joint in 16 000 by chance.
    let joints: Vec<usize> = (0..n).filter(|&j| level(j).0.abs() > 4.0 * level(j).1).collect();
    let finding = contact_finding(robot, stretch, &joints, [from, to], fair, p_value, &level);
    Some((finding, without_interval(stretch, from, to)))
}

/// The shortest touch looked for (s).
const SHORTEST: f64 = 0.05;

/// The same in rows.
fn shortest(stretch: &Stretch) -> usize {
    (SHORTEST / stretch.interval).round().max(4.0) as usize
}

fn median_period(stretch: &Stretch, j: usize) -> Vec<f64> {
    (0..stretch.rows())
        .map(|s| {
            let mut values: Vec<f64> = stretch.periods.iter().map(|p| p[j][s]).collect();
            values.sort_by(f64::total_cmp);
            let m = values.len();
            0.5 * (values[(m - 1) / 2] + values[m / 2])
        })
        .collect()
}

/// Moves the edges of an interval to where the statistic is largest, in steps that halve; a few samples alone are a spike, not a touch.
fn sharpened(
    (mut gain, mut from, mut to): (f64, usize, usize),
    length: usize,
    shortest: usize,
    statistic: &impl Fn(usize, usize) -> f64,
) -> (f64, usize, usize) {
    let mut step = (to - from).max(1);
    while step > 0 {
        let moves = [
            (from.saturating_sub(step), to),
            ((from + step).min(to - 1), to),
            (from, (to + step).min(length)),
            (from, (to.saturating_sub(step)).max(from + 1)),
        ];
        let best = moves
            .into_iter()
            .filter(|(a, b)| b - a >= shortest)
            .map(|(a, b)| (statistic(a, b), a, b))
            .fold((gain, from, to), |a, b| if b.0 > a.0 { b } else { a });
        if best.0 > gain {
            (gain, from, to) = best;
        } else {
            step /= 2;
        }
    }
    (gain, from, to)
}

fn contact_finding(
    robot: &Robot,
    stretch: &Stretch,
    joints: &[usize],
    [from, to]: [usize; 2],
    gain: f64,
    p_value: f64,
    level: &impl Fn(usize) -> (f64, f64),
) -> BetweenFinding {
    let rows = stretch.rows();
    let time = |at: usize| stretch.starts[(at / rows).min(stretch.starts.len() - 1)] + (at % rows) as f64 * stretch.interval;
    let end = time(to - 1) + stretch.interval;
    let values = [(time(from), stretch.interval), (end, stretch.interval)]
        .into_iter()
        .chain(joints.iter().map(|&j| level(j)));
    let infos = by_code("external_contact")
        .expect("is in the list")
        .parameters(0, robot, joints);
    let parameters = infos
        .into_iter()
        .zip(values)
        .map(|(info, (value, std_dev))| ReportedParameter {
            name: info.name,
            value,
            unit: info.unit,
            std_dev,
        })
        .collect();
    BetweenFinding {
        effect: "external_contact",
        joints: joints.to_vec(),
        parameters,
        gain,
        p_value,
        first_row: Some(from),
        rms: None,
    }
}

/// The periods with the interval filled by the mean of the other periods, with a margin of a tenth for edges that are not sharp.
fn without_interval(stretch: &Stretch, from: usize, to: usize) -> Vec<Vec<Vec<f64>>> {
    let (count, rows) = (stretch.periods.len(), stretch.rows());
    let margin = (to - from) / 10 + 2;
    let mut periods = stretch.periods.clone();
    for at in from.saturating_sub(margin)..(to + margin).min(count * rows) {
        let (p, s) = (at / rows, at % rows);
        for j in 0..stretch.joints() {
            let others = (0..count).filter(|&o| o != p).map(|o| stretch.periods[o][j][s]).sum::<f64>();
            periods[p][j][s] = others / (count - 1) as f64;
        }
    }
    periods
}
