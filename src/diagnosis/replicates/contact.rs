//! Something that touched the arm: an interval of time in which all joints together deviate from the other periods.

use super::period_finding::{
    BetweenFinding, Explained, Seams, all_beside_median, all_beside_others, beside_others, others, start_rows,
};
use crate::diagnosis::report::ReportedParameter;
use crate::diagnosis::selection::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::by_code;
use crate::model::Robot;
use crate::regression::{NoiseModel, Stretch};
use std::ops::Range;

/// Deviations of all periods of a joint from a reference.
type Deviations = fn(&Stretch, usize) -> Vec<Vec<f64>>;

/// Running sums over all periods one after the other, per joint: of whitened deviations times the whitened unit level, and of the
/// square of that.
struct Sums {
    deviations: Vec<Vec<f64>>,
    levels: Vec<Vec<f64>>,
}

impl Sums {
    /// Over the rows in `keep`, per joint.
    fn over(
        stretch: &Stretch,
        noise: &[NoiseModel],
        seams: &Seams,
        deviations: Deviations,
        keep: impl Fn(usize) -> Vec<bool>,
    ) -> Self {
        let (rows, n) = (stretch.rows(), stretch.joints());
        let length = stretch.periods.len() * rows;
        let mut sums = Self {
            deviations: vec![vec![0.0; length + 1]; n],
            levels: vec![vec![0.0; length + 1]; n],
        };
        for j in 0..n {
            let keep = seams.whitened_rows(&noise[j], keep(j));
            let unit = noise[j].whiten(&vec![1.0; rows], &keep, 1);
            for (p, deviation) in deviations(stretch, j).iter().enumerate() {
                let white = noise[j].whiten(deviation, &keep, 1);
                for s in 0..rows {
                    let at = p * rows + s;
                    sums.deviations[j][at + 1] = sums.deviations[j][at] + unit[s] * white[s];
                    sums.levels[j][at + 1] = sums.levels[j][at] + unit[s] * unit[s];
                }
            }
        }
        sums
    }

    /// What a level of joint `j` in an interval explains.
    fn of_joint(&self, j: usize, from: usize, to: usize) -> f64 {
        let level = self.levels[j][to] - self.levels[j][from];
        match level > 0.0 {
            true => (self.deviations[j][to] - self.deviations[j][from]).powi(2) / level,
            false => 0.0,
        }
    }

    /// What levels of all joints explain.
    fn statistic(&self, from: usize, to: usize) -> f64 {
        (0..self.levels.len()).map(|j| self.of_joint(j, from, to)).sum()
    }

    /// Level of a joint in an interval with its standard deviation.
    fn level(&self, j: usize, from: usize, to: usize) -> (f64, f64) {
        let level = (self.levels[j][to] - self.levels[j][from]).max(f64::MIN_POSITIVE);
        (
            (self.deviations[j][to] - self.deviations[j][from]) / level,
            level.sqrt().recip(),
        )
    }
}

/// The interval of time in which the deviations of all joints from the other periods are least like noise.
///
/// It has to stand out from the mean of the others and from the median of all. Filtered noise is smooth, and the median of it is
/// not: its kinks look like touches. An odd period is half of the mean of the two others of three, and looks like a touch of
/// each.
///
/// It is found on rows that move, since the torque that friction locks in at rest differs from one period to the next; where it
/// begins or ends at rest is seen on the rows at rest.
pub(crate) fn best_contact(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel], seams: &Seams) -> Option<Explained> {
    let (count, rows, n) = (stretch.periods.len(), stretch.rows(), stretch.joints());
    let length = count * rows;
    // At a reversal a jump of friction that comes a sample later in one period is no touch.
    let on_moving_rows = |from: Deviations| Sums::over(stretch, noise, seams, from, |j| stretch.kept(&stretch.motion, j));
    let moving = on_moving_rows(all_beside_others);
    let (mut best, mut windows) = ((0.0, 0, 0), 0.0);
    let shortest = shortest(stretch);
    let mut width = shortest;
    while width <= rows {
        for from in (start_rows(stretch)..length.saturating_sub(width)).step_by((width / 4).max(1)) {
            windows += 1.0;
            let gain = moving.statistic(from, from + width);
            if gain > best.0 {
                best = (gain, from, from + width);
            }
        }
        width = width * 3 / 2;
    }
    let (gain, from, to) = sharpened(best, length, shortest, &|from, to| moving.statistic(from, to));
    // The mean over the P - 1 others has its noise too; the median over P periods has π/2 of the variance of their mean.
    let beside_mean = gain / (1.0 + 1.0 / (count - 1) as f64);
    let beside_median = on_moving_rows(all_beside_median).statistic(from, to) / (1.0 + 0.5 * std::f64::consts::PI / count as f64);
    let fair = beside_mean.min(beside_median);
    let p_value = chance(fair, n) * windows;
    let all = Sums::over(stretch, noise, seams, all_beside_others, |j| {
        stretch.kept_or_resting(&stretch.motion, j)
    });
    let (_, from, to) = sharpened((all.statistic(from, to), from, to), length, shortest, &|from, to| {
        all.statistic(from, to)
    });
    // A touch that stays below the noise of every joint is slow drift of something else.
    let felt = (0..n).any(|j| all.level(j, from, to).0.abs() > noise[j].std_dev);
    if !felt || to - from > rows {
        return None;
    }
    // Joints that feel it: four standard deviations, one joint in 16 000 by chance.
    let feels = |j: &usize| {
        let (level, deviation) = all.level(*j, from, to);
        level.abs() > 4.0 * deviation
    };
    let joints: Vec<usize> = (0..n).filter(feels).collect();
    let reported_level = |j: usize| level_beside(stretch, &noise[j], j, [from, to]);
    let finding = contact_finding(robot, stretch, &joints, [from, to], fair, p_value, &reported_level);
    let periods = without_rows(stretch, filled(stretch, [from, to]));
    Some((finding, periods))
}

/// Level of one joint in an interval beside the mean of the periods that were not touched then, with its standard deviation.
fn level_beside(stretch: &Stretch, noise: &NoiseModel, joint: usize, [from, to]: [usize; 2]) -> (f64, f64) {
    let rows = stretch.rows();
    let keep = noise.whitened_rows(&stretch.kept_or_resting(&stretch.motion, joint), false);
    let unit = noise.whiten(&vec![1.0; rows], &keep, 1);
    let (mut sum, mut level, mut fewest) = (0.0, f64::MIN_POSITIVE, stretch.periods.len());
    for p in from / rows..=(to - 1) / rows {
        let inside = from.saturating_sub(p * rows)..(to - p * rows).min(rows);
        fewest = (0..rows).map(|s| others(stretch, p, joint, s).1).fold(fewest, usize::min);
        let white = noise.whiten(&beside_others(stretch, p, joint), &keep, 1);
        for s in inside {
            sum += unit[s] * white[s];
            level += unit[s] * unit[s];
        }
    }
    (sum / level, ((1.0 + 1.0 / fewest as f64) / level).sqrt())
}

/// The same in rows.
pub(crate) fn shortest(stretch: &Stretch) -> usize {
    (SETTINGS.replicates.shortest_contact / stretch.interval).round().max(4.0) as usize
}

/// Moves the edges of an interval to where the statistic is largest, in steps that halve; a few samples alone are a spike, not a
/// touch.
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
    let parameters = ReportedParameter::of(infos, values);
    BetweenFinding {
        effect: "external_contact",
        joints: joints.to_vec(),
        parameters,
        gain,
        p_value,
        first_row: Some(from),
        filled: Some(filled(stretch, [from, to])),
        rms: None,
    }
}

/// The rows of an interval with a margin of a tenth, for edges that are not sharp.
fn filled(stretch: &Stretch, [from, to]: [usize; 2]) -> Range<usize> {
    let margin = (to - from) / 10 + 2;
    from.saturating_sub(margin)..(to + margin).min(stretch.periods.len() * stretch.rows())
}

/// The periods with these rows filled by the mean of the other periods.
fn without_rows(stretch: &Stretch, filled: Range<usize>) -> Vec<Vec<Vec<f64>>> {
    let mut periods = stretch.periods.clone();
    for at in filled {
        let (p, s) = (at / stretch.rows(), at % stretch.rows());
        for j in 0..stretch.joints() {
            periods[p][j][s] = others(stretch, p, j, s).0;
        }
    }
    periods
}
