//! Held-out data have the last word: did an effect, or all of them together, change the error on data that fitted nothing?
//!
//! Two models are compared on the same rows. Residuals are correlated in time and the two models' errors with each other, so that
//! rows are no witnesses; blocks of time nearly are. The logarithms of the ratios of the two mean squares, block by block, are
//! tested by Wilcoxon's signed ranks (Wilcoxon 1945; Diebold & Mariano 1995 for forecasts), with the correlation of neighbouring
//! blocks added (Newey & West 1987). Ranks, because an effect gains far more in some blocks than in others: to Student's t, the
//! few blocks in which a rotor's inertia or friction at low speed shows make the scatter as large as the gain.
//!
//! Without validation logs every block of the identification logs is predicted by a fit to the others. That is weaker: the same
//! data chose the effects.

use crate::diagnosis::report::{Change, Evaluated, FindingHeldOut, HeldOut, HeldOutVerdict, JointHeldOut};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{
    AugmentedModel, Data, SETTINGS as REGRESSION_SETTINGS, Stretch, System, chi_square_tail, left_out, time_blocks,
};
use rayon::prelude::*;

/// Squared errors of single measurements about a model, summed over the periods: per stretch, joint and row; NaN where a row does
/// not count.
pub(crate) struct RowErrors {
    squares: Vec<Vec<Vec<f64>>>,
    /// Measurements per row of every stretch.
    repetitions: Vec<f64>,
}

impl RowErrors {
    /// About the predictions of `model` on logs that it has not seen.
    pub fn of_logs(model: &AugmentedModel, logs: &[Stretch]) -> Self {
        let of = |stretch: &Stretch| {
            let e = model.evaluate(stretch, None);
            let joint = |j: usize| squares(stretch, j, &e.torque[j], &stretch.kept(&e.motion, j));
            (0..stretch.joints()).map(joint).collect()
        };
        Self {
            squares: logs.iter().map(of).collect(),
            repetitions: logs.iter().map(|s| s.repetitions() as f64).collect(),
        }
    }

    /// About predictions of every block of the data by the fit of `system`'s model to all others.
    pub fn in_turn(data: &Data, system: &System) -> Self {
        let mut predicted: Vec<Vec<Vec<f64>>> = system.evaluated.iter().map(|e| e.torque.clone()).collect();
        let base = data.base_rows(&system.model);
        let columns: Vec<_> = data
            .stretches
            .iter()
            .zip(base)
            .map(|(s, rows)| system.model.evaluate(s, Some(rows)).jacobian)
            .collect();
        for (block, change) in left_out(data, system) {
            for (j, torque) in predicted[block.stretch].iter_mut().enumerate() {
                for (at, column) in &columns[block.stretch][j] {
                    let rows = torque[block.rows.clone()].iter_mut().zip(&column[block.rows.clone()]);
                    rows.for_each(|(t, c)| *t += change[*at] * c);
                }
            }
        }
        let of = |(i, stretch): (usize, &Stretch)| {
            let joint = |j: usize| squares(stretch, j, &predicted[i][j], &stretch.kept(&system.evaluated[i].motion, j));
            (0..stretch.joints()).map(joint).collect()
        };
        Self {
            squares: data.stretches.iter().enumerate().map(of).collect(),
            repetitions: data.stretches.iter().map(|s| s.repetitions() as f64).collect(),
        }
    }

    /// Whether any row of a joint counts.
    fn has(&self, joint: usize) -> bool {
        self.squares.iter().any(|stretch| stretch[joint].iter().any(|v| !v.is_nan()))
    }

    /// RMS over these joints [N·m or N].
    fn rms(&self, joints: &[usize]) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (stretch, &repetitions) in self.squares.iter().zip(&self.repetitions) {
            for v in joints.iter().flat_map(|&j| &stretch[j]).filter(|v| !v.is_nan()) {
                sum += v;
                count += repetitions;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Squares of `self` and of `after` in every block of time, summed over these joints, each weighted; on the rows that both
    /// have.
    fn beside(&self, after: &Self, joints: &[usize], weights: &[f64]) -> Vec<[f64; 2]> {
        let rows: Vec<usize> = self.squares.iter().map(|s| s[0].len()).collect();
        let of = |(stretch, rows): (usize, std::ops::Range<usize>)| {
            let joint = |&j: &usize| {
                let (b, a) = (
                    &self.squares[stretch][j][rows.clone()],
                    &after.squares[stretch][j][rows.clone()],
                );
                let both = b.iter().zip(a).filter(|(b, a)| !b.is_nan() && !a.is_nan());
                both.fold([0.0; 2], |[before, after], (b, a)| {
                    [before + weights[j] * b, after + weights[j] * a]
                })
            };
            joints
                .iter()
                .map(joint)
                .fold([0.0; 2], |[b, a], [more, less]| [b + more, a + less])
        };
        time_blocks(&rows, REGRESSION_SETTINGS.jackknife_blocks)
            .into_iter()
            .map(|b| of((b.stretch, b.rows)))
            .collect()
    }
}

fn squares(stretch: &Stretch, joint: usize, predicted: &[f64], keep: &[bool]) -> Vec<f64> {
    let row = |s: usize| {
        if !keep[s] {
            return f64::NAN;
        }
        match stretch.periods.is_empty() {
            true => (stretch.torque[joint][s] - predicted[s]).powi(2),
            false => stretch.periods.iter().map(|p| (p[joint][s] - predicted[s]).powi(2)).sum(),
        }
    };
    (0..keep.len()).map(row).collect()
}

/// What the second of two models leaves less than the first, summed over the blocks, and the chance of such a change to either
/// side. A change that most blocks do not share counts as chance.
pub(crate) fn paired_test(blocks: &[[f64; 2]]) -> (f64, f64) {
    let sum: f64 = blocks.iter().map(|[before, after]| before - after).sum();
    let ratio = |[before, after]: &[f64; 2]| (*before > 0.0 && *after > 0.0).then(|| (before / after).ln());
    let (ranks, p_value) = signed_rank_test(&blocks.iter().filter_map(ratio).collect::<Vec<_>>());
    (sum, if ranks * sum > 0.0 { p_value } else { 1.0 })
}

/// Sum of the ranks of the sizes of `differences`, each with its sign, and the chance of one as far from zero to either side
/// (normal; good from six on).
pub(crate) fn signed_rank_test(differences: &[f64]) -> (f64, f64) {
    let mut order: Vec<usize> = (0..differences.len()).filter(|&i| differences[i] != 0.0).collect();
    let n = order.len();
    if n < SETTINGS.held_out.fewest_blocks {
        return (0.0, 1.0);
    }
    order.sort_by(|&a, &b| differences[a].abs().total_cmp(&differences[b].abs()));
    let mut ranks = vec![0.0; differences.len()];
    for (rank, &i) in order.iter().enumerate() {
        ranks[i] = differences[i].signum() * (rank + 1) as f64;
    }
    let sum: f64 = ranks.iter().sum();
    let own: f64 = ranks.iter().map(|r| r * r).sum();
    let off: Vec<f64> = ranks.iter().map(|r| r - sum / n as f64).collect();
    let scatter: f64 = off.iter().map(|d| d * d).sum();
    // Bartlett's weight of one half, on both sides.
    let neighbours: f64 = off.windows(2).map(|w| w[0] * w[1]).sum();
    let variance = own * (1.0 + neighbours / scatter.max(f64::MIN_POSITIVE)).max(1.0);
    (sum, chi_square_tail(sum * sum / variance, 1))
}

fn change(sum: f64, p_value: f64) -> Change {
    match (0.5 * p_value < SETTINGS.held_out.beyond_chance, sum > 0.0) {
        (false, _) => Change::Same,
        (true, true) => Change::Better,
        (true, false) => Change::Worse,
    }
}

/// Where errors are taken from.
#[derive(Clone)]
pub(crate) struct Judge<'a> {
    /// Validation logs; none where the identification logs are held out block by block.
    pub logs: &'a [Stretch],
    /// Standard deviation of the noise of every joint.
    pub floor: Vec<f64>,
}

impl Judge<'_> {
    pub fn errors(&self, data: &Data, system: &System) -> RowErrors {
        match self.logs.is_empty() {
            true => RowErrors::in_turn(data, system),
            false => RowErrors::of_logs(&system.model, self.logs),
        }
    }

    fn weights(&self) -> Vec<f64> {
        self.floor.iter().map(|f| (f * f).max(f64::MIN_POSITIVE).recip()).collect()
    }

    /// One effect: the model without it and with it. Weighed over all joints, because base parameters carry what it explains to
    /// others; `joints` are those whose errors are reported.
    pub fn finding(&self, without: &RowErrors, with: &RowErrors, joints: &[usize]) -> (FindingHeldOut, f64) {
        let all: Vec<usize> = (0..self.floor.len()).collect();
        let (sum, p_value) = paired_test(&without.beside(with, &all, &self.weights()));
        let mut change = change(sum, p_value);
        // No change on the whole, and one joint pays for it: worse. The chance is shared among the joints.
        let pays = |&j: &usize| {
            let (sum, p) = paired_test(&without.beside(with, &[j], &self.weights()));
            sum < 0.0 && 0.5 * p < SETTINGS.held_out.beyond_chance / all.len() as f64
        };
        if change == Change::Same && all.iter().any(pays) {
            change = Change::Worse;
        }
        let report = FindingHeldOut {
            before: Evaluated::Value(without.rms(joints)),
            after: Evaluated::Value(with.rms(joints)),
            change,
            p_value: Evaluated::Value(p_value),
        };
        (report, sum)
    }

    /// All effects together: the declared model and the final one.
    pub fn whole(&self, names: &[String], declared: &RowErrors, last: &RowErrors) -> HeldOut {
        let weights = self.weights();
        let joint = |(j, name): (usize, &String)| {
            let (sum, p_value) = paired_test(&declared.beside(last, &[j], &weights));
            JointHeldOut {
                joint: name.clone(),
                before: declared.rms(&[j]),
                after: last.rms(&[j]),
                floor: self.floor[j],
                change: change(sum, p_value),
                p_value,
            }
        };
        let all: Vec<usize> = (0..names.len()).collect();
        let (sum, p_value) = paired_test(&declared.beside(last, &all, &weights));
        HeldOut {
            verdict: match change(sum, p_value) {
                Change::Better => HeldOutVerdict::Confirmed,
                _ => HeldOutVerdict::NotConfirmed,
            },
            source: self.source().into(),
            p_value: Evaluated::Value(p_value),
            joints: names
                .iter()
                .enumerate()
                .filter(|(j, _)| declared.has(*j))
                .map(joint)
                .collect(),
        }
    }

    /// Nothing to compare: no effect is in the model.
    pub fn nothing(&self, names: &[String], errors: &RowErrors) -> HeldOut {
        HeldOut {
            verdict: HeldOutVerdict::NotTested,
            p_value: Evaluated::NotEvaluated,
            ..self.whole(names, errors, errors)
        }
    }

    fn source(&self) -> &'static str {
        match self.logs.is_empty() {
            true => {
                "blocks of the identification logs, each predicted by a fit to the others: weaker than a validation log, because the same data \
                 chose the effects"
            }
            false => "validation logs",
        }
    }
}

/// Which effects stay in the model.
pub(crate) struct Decision {
    /// The model with those that stay, those that gain most on held-out data first.
    pub system: System,
    /// Numbers of the effects in that order, then those that do not stay.
    pub order: Vec<usize>,
    pub stay: usize,
    /// In the order of `order`.
    pub tests: Vec<FindingHeldOut>,
}

/// Takes the effects of `found` beyond the first `fixed` terms out that make held-out errors worse beyond chance, the worst
/// first, until none does.
pub(crate) fn decide(data: &Data, found: System, fixed: usize, judge: &Judge) -> Decision {
    let count = found.model.terms.len() - fixed;
    let all = found.model.clone();
    let mut inside: Vec<usize> = (0..count).collect();
    let mut outside: Vec<(usize, FindingHeldOut)> = Vec::new();
    let mut system = found;
    loop {
        let with = judge.errors(data, &system);
        let test = |&i: &usize| {
            let others: Vec<usize> = inside.iter().copied().filter(|o| *o != i).collect();
            let without = data.fit(selected(&all, &system.model, fixed, &inside, &others));
            let (test, gain) = judge.finding(&judge.errors(data, &without), &with, &reached(&all, fixed + i));
            (i, test, gain, without)
        };
        let mut tests: Vec<_> = inside.par_iter().with_max_len(1).map(test).collect();
        tests.sort_by(|a, b| a.2.total_cmp(&b.2));
        match tests.iter().position(|t| t.1.change == Change::Worse) {
            Some(worst) => {
                let (i, test, _, without) = tests.swap_remove(worst);
                inside.retain(|o| *o != i);
                outside.push((i, test));
                system = without;
            }
            None => {
                tests.reverse();
                let order: Vec<usize> = tests.iter().map(|t| t.0).collect();
                let model = selected(&all, &system.model, fixed, &inside, &order);
                let tests = tests.into_iter().map(|t| t.1).chain(outside.iter().map(|o| o.1.clone()));
                return Decision {
                    system: data.linearise(model),
                    stay: order.len(),
                    tests: tests.collect(),
                    order: order.into_iter().chain(outside.iter().map(|o| o.0)).collect(),
                };
            }
        }
    }
}

/// `now`, which has the fixed terms and the effects `inside`, with the effects `wanted` of these alone.
fn selected(all: &AugmentedModel, now: &AugmentedModel, fixed: usize, inside: &[usize], wanted: &[usize]) -> AugmentedModel {
    let mut model = now.clone();
    model.terms.truncate(fixed);
    let term = |i: &usize| match inside.iter().position(|o| o == i) {
        Some(at) => now.terms[fixed + at].clone(),
        None => all.terms[fixed + i].clone(),
    };
    model.terms.extend(wanted.iter().map(term));
    model
}

/// Joints that a term sits on; all of them for an effect of the whole robot.
fn reached(model: &AugmentedModel, at: usize) -> Vec<usize> {
    let term = &model.terms[at];
    match term.joints.is_empty() {
        true => (0..model.robot.joint_count()).collect(),
        false => term.acts_on(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Differences that mean nothing, correlated from block to block, are called a change about once in a hundred times to each
    /// side.
    #[test]
    fn prop_chance_is_what_the_test_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut beyond = 0;
        for _ in 0..5000 {
            let mut last = 0.0;
            let differences: Vec<f64> = (0..16)
                .map(|_| {
                    // Twelve uniform numbers make a normal one.
                    let normal = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
                    last = 0.1 * last + normal;
                    last
                })
                .collect();
            beyond += usize::from(0.5 * signed_rank_test(&differences).1 < SETTINGS.held_out.beyond_chance);
        }
        // 100 are expected; correlation and the estimate of it cost or save a little.
        assert!((40..160).contains(&beyond), "{beyond} of 5000");
        assert_eq!(signed_rank_test(&[0.0; 16]).1, 1.0);
        assert!(signed_rank_test(&[1.0, 1.1, 0.9, 1.3, 1.2, 0.8, 1.4, 1.6]).1 < 0.02);
    }

    /// Every block gains, one of them a hundred times more than the others: no accident.
    #[test]
    fn a_block_that_gains_most_does_not_hide_what_all_gain() {
        let mut blocks: Vec<[f64; 2]> = (0..16).map(|i| [1.5 + 0.05 * i as f64, 1.0]).collect();
        blocks[3] = [100.0, 1.0];
        let (sum, p_value) = paired_test(&blocks);
        assert!(sum > 0.0 && p_value < SETTINGS.held_out.beyond_chance, "{p_value}");
        let one: Vec<[f64; 2]> = (0..16)
            .map(|i| {
                if i == 3 {
                    [100.0, 1.0]
                } else {
                    [1.0, 1.0 + 0.001 * (i % 3) as f64]
                }
            })
            .collect();
        assert!(paired_test(&one).1 > SETTINGS.held_out.beyond_chance);
    }
}
