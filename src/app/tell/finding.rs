//! One finding: the residual on its joints, what explains it, what else it could be, and what remains.

use super::words::{parameters, phrase, sentence, subject};
use super::{Teller, is_rejected};
use crate::diagnosis::{Change, Covered, Finding, Perturbation, RmsPair};
use crate::effects::{EffectKind, by_code};
use crate::formats::{listed, significant, unit};

/// Joints that a sentence names; an effect of the whole robot changes more of them.
const MOST_JOINTS: usize = 3;
/// Chance of a lack of fit this large from noise, below which structure is said to remain: what single joints are tested at
/// elsewhere.
const STRUCTURED: f64 = 1e-3;

impl Teller<'_> {
    pub(super) fn finding(&self, index: usize, f: &Finding) -> String {
        let first = index == 0;
        let held_out = !f.rms_before.held_out.is_empty();
        let of = |pair: &RmsPair, j: usize| if held_out { pair.held_out[j] } else { pair.identification[j] };
        let shown = self.shown(f, &of);
        let each = |text: &dyn Fn(usize) -> String| listed(&shown.iter().map(|&j| text(j)).collect::<Vec<_>>(), "and");
        let values = self.with_units(&shown, |j| significant(of(&f.rms_before, j), 3));
        let errors = each(&|j| {
            format!(
                "{} → {}",
                significant(of(&f.rms_before, j), 3),
                significant(of(&f.rms_after, j), 3)
            )
        });
        let noise = each(&|j| significant(self.report.noise_floor[j], 2));
        let unit_of = self.effort(shown[0]);
        let names: Vec<&str> = shown.iter().map(|&j| self.name(j)).collect();
        let several = names.len() > 1;
        let mut text = format!(
            "{} on {} {} is {values}; {} {}: {}. ",
            if first {
                "The residual"
            } else {
                "With the effects above, the residual"
            },
            if several { "joints" } else { "joint" },
            listed(&names, "and"),
            subject(&f.effect, f.formula.as_ref(), &f.joints),
            self.how_much(f, &shown, &of),
            parameters(f),
        );
        text += &format!(
            "{} {errors} {unit_of} (noise alone {noise}).",
            if held_out {
                "Held-out error"
            } else {
                "Error on the same data, as none was held out,"
            },
        );
        text += &covered(f);
        text += &self.others(f);
        text += &found_again(f);
        if is_rejected(f) {
            text += " It increases the held-out error: it is not in the model.";
            return text;
        }
        if f.held_out.change == Change::Same {
            text += match held_out {
                true => " On held-out data its part of the error does not differ from chance.",
                false => " Predicted from the rest of the log, its part of the error does not differ from chance.",
            };
        }
        text += &self.what_remains(&shown);
        text
    }

    /// Joints to name: those of the effect, and of many those whose error changes most, in the order of the arm.
    fn shown(&self, f: &Finding, of: &dyn Fn(&RmsPair, usize) -> f64) -> Vec<usize> {
        let gain = |j: usize| 1.0 - of(&f.rms_after, j) / of(&f.rms_before, j).max(f64::MIN_POSITIVE);
        let mut joints: Vec<usize> = (0..self.robot.joint_count())
            .filter(|&j| f.joints.iter().any(|n| n == self.name(j)))
            .collect();
        // A joint without rows has no error to speak of.
        if joints.iter().any(|&j| of(&f.rms_before, j).is_finite()) {
            joints.retain(|&j| of(&f.rms_before, j).is_finite());
        }
        joints.sort_by(|&a, &b| gain(b).total_cmp(&gain(a)));
        joints.truncate(MOST_JOINTS);
        joints.sort_unstable();
        joints
    }

    /// By the share of the variance above the noise that is left: less than a tenth is all, less than half is most.
    fn how_much(&self, f: &Finding, shown: &[usize], of: &dyn Fn(&RmsPair, usize) -> f64) -> &'static str {
        let above = |pair: &RmsPair| -> f64 {
            let one = |&j: &usize| {
                (of(pair, j).powi(2) - self.report.noise_floor[j].powi(2)).max(0.0) / self.report.noise_floor[j].powi(2)
            };
            shown.iter().map(one).sum()
        };
        let squares = |pair: &RmsPair| shown.iter().map(|&j| of(pair, j).powi(2)).sum::<f64>();
        if squares(&f.rms_after) >= squares(&f.rms_before) {
            return "fits the data that it was found on, but does not lower the error here";
        }
        match above(&f.rms_after) / above(&f.rms_before).max(f64::MIN_POSITIVE) {
            left if left < 0.1 => "explains it",
            left if left < 0.5 => "explains most of it",
            _ => "explains a part of it",
        }
    }

    /// What else it could be, and what it is easily taken for and is not.
    fn others(&self, f: &Finding) -> String {
        let place = |joints: &[String]| {
            if joints == f.joints {
                String::new()
            } else {
                format!(" on {}", self.at(joints))
            }
        };
        let open: Vec<String> = f
            .rivals
            .iter()
            .map(|r| match &r.formula {
                Some(formula) => subject(&r.effect, Some(formula), &r.joints),
                None => format!("{}{}", phrase(&r.effect), place(&r.joints)),
            })
            .collect();
        let mut text = String::new();
        if !open.is_empty() {
            text += &format!(" The data do not exclude {}.", listed(&open, "or"));
        }
        let named = |code: &str| {
            let open = f.rivals.iter().any(|r| r.effect == code);
            let found = self
                .report
                .findings
                .iter()
                .any(|g| g.effect == code && g.joints.iter().any(|j| f.joints.contains(j)));
            // Others are not tried in the place of a finding.
            let tried = by_code(code).is_some_and(|e| matches!(e.kind(), EffectKind::Additive | EffectKind::Distortion));
            tried && !open && !found
        };
        let own = by_code(&f.effect).filter(|e| matches!(e.kind(), EffectKind::Additive | EffectKind::Distortion));
        let taken_for = own.map(|e| e.about().rivals).unwrap_or_default();
        let excluded: Vec<&str> = taken_for.iter().copied().filter(|code| named(code)).map(phrase).collect();
        if !excluded.is_empty() {
            let verb = if excluded.len() > 1 { "are" } else { "is" };
            text += &format!(" {}", sentence(&format!("{} {verb} excluded", listed(&excluded, "and"))));
        }
        text
    }

    /// With everything found in the model.
    fn what_remains(&self, shown: &[usize]) -> String {
        let in_rest = |j: usize| {
            self.report
                .remainder
                .as_ref()
                .is_some_and(|r| r.joints.iter().any(|n| n == self.name(j)))
        };
        let fit = |j: usize| self.report.lack_of_fit_after.get(j);
        let clean: Vec<&str> = shown
            .iter()
            .filter(|&&j| !in_rest(j) && fit(j).is_some_and(|f| f.p_value > STRUCTURED))
            .map(|&j| self.name(j))
            .collect();
        let open: Vec<String> = shown
            .iter()
            .filter(|&&j| !in_rest(j))
            .filter_map(|&j| fit(j).filter(|f| f.p_value <= STRUCTURED).map(|f| (j, f)))
            .map(|(j, f)| {
                let beyond = (f.residual_rms.powi(2) - f.expected_rms.powi(2)).max(0.0).sqrt();
                format!("{} {} on {}", significant(beyond, 2), self.effort(j), self.name(j))
            })
            .collect();
        let mut text = String::new();
        if !clean.is_empty() {
            text += &format!(" The residual on {} is noise.", listed(&clean, "and"));
        }
        if !open.is_empty() {
            let verb = if open.len() > 1 { "remain" } else { "remains" };
            text += &format!(" Above the noise, {} {verb} unexplained.", listed(&open, "and"));
        }
        text
    }
}

/// Where the variables of a law were.
fn covered(f: &Finding) -> String {
    let range = |c: &Covered| {
        let [low, high] = [c.low, c.high].map(|v| significant(v, 2));
        format!("{} from {low} to {high} {}", c.variable, unit(&c.unit))
    };
    let all: Vec<String> = f.covered.iter().map(range).collect();
    match all.is_empty() {
        true => String::new(),
        false => format!(" It is valid in the range of the log: {}.", listed(&all, "and")),
    }
}

/// In which changed copies of the data the effect is found again, and in which it is not.
fn found_again(f: &Finding) -> String {
    let (found, lost) = (changes(f, true), changes(f, false));
    let and = listed(&found, "and");
    match (found.is_empty(), lost.is_empty()) {
        (true, true) => String::new(),
        (false, true) => format!(" It is found again with {and}."),
        (true, false) => format!(" It is not found with {}.", listed(&lost, "or")),
        (false, false) => format!(" It is found again with {and}, but not with {}.", listed(&lost, "or")),
    }
}

/// The changes of the data with which the effect is found again, or is not; two of a kind in one phrase.
fn changes(f: &Finding, found: bool) -> Vec<&'static str> {
    use Perturbation::*;
    let has = |p: Perturbation| f.survivals.iter().any(|s| s.perturbation == p && s.survives == found);
    let pair = |[first, second]: [Perturbation; 2], [one, other, both]: [&'static str; 3]| match (has(first), has(second)) {
        (true, true) => Some(both),
        (true, false) => Some(one),
        (false, true) => Some(other),
        (false, false) => None,
    };
    let halves = [
        "the first half of the data",
        "the second half of the data",
        "either half of the data alone",
    ];
    let cutoffs = [
        "a cut-off a quarter lower",
        "a cut-off a quarter higher",
        "a cut-off a quarter lower or higher",
    ];
    [
        pair([FirstHalf, SecondHalf], halves),
        pair([LowerCutoff, HigherCutoff], cutoffs),
        has(EverySecondRow).then_some("every second row"),
        has(SixDigits).then_some("torques rounded to six digits"),
    ]
    .into_iter()
    .flatten()
    .collect()
}
