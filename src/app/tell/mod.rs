//! Findings in sentences with figures, and the variables to draw them against: the one place where an answer says in words what
//! was found. Pages, reports and the command line show them as they are.

mod finding;
#[cfg(test)]
mod tests;
mod words;

use self::words::{is_friction_over_time, phrase, sentence, variable, variable_in_words};
use super::diagnose::beyond_repair;
use crate::diagnosis::{
    Change, DataFault, Finding, HeldOutVerdict, JointHeldOut, NotTested, Remainder, Remedy, ResidualReport, Verdict,
};
use crate::documents::{Against, ResidualDocument};
use crate::effects::by_code;
use crate::formats::{listed, significant, unit};
use crate::model::Robot;

/// The document of `report`, with its summary and the sentences of findings and remainder.
pub(super) fn residual_document(robot: &Robot, report: &ResidualReport) -> ResidualDocument {
    let teller = Teller { robot, report };
    let mut document = ResidualDocument::from(report);
    document.summary = teller.summary();
    for (i, finding) in report.findings.iter().enumerate() {
        document.findings[i].sentence = teller.finding(i, finding);
        document.findings[i].against = Against {
            joint: finding.joints.first().cloned(),
            variable: variable_of(finding).into(),
        };
    }
    if let (Some(rest), Some(written)) = (&report.remainder, &mut document.remainder) {
        written.sentence = teller.remainder(rest);
    }
    document
}

/// What a finding is drawn against: of an own effect, the kind of the first of its variables.
fn variable_of(finding: &Finding) -> &str {
    let own = || finding.formula.as_ref()?.variables.first();
    match (by_code(&finding.effect), own()) {
        (Some(effect), _) => variable(effect),
        (None, Some(first)) => first.trim_end_matches(|c: char| c.is_ascii_digit()),
        (None, None) => "time",
    }
}

/// Whether held-out data speak against an effect; what was not held against them is none of the model's, but explains the log all
/// the same.
fn is_rejected(finding: &Finding) -> bool {
    !finding.in_model && finding.held_out.change != Change::NotTested
}

struct Teller<'a> {
    robot: &'a Robot,
    report: &'a ResidualReport,
}

impl Teller<'_> {
    fn summary(&self) -> String {
        let searched = !self.report.explains_nothing && !beyond_repair(&self.report.data_faults);
        let held_out = self.held_out().filter(|_| searched);
        let parts = [
            self.faults(),
            Some(self.physics()),
            self.not_tested(),
            self.rejected(),
            held_out,
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
    }

    fn faults(&self) -> Option<String> {
        let filtered = |f: &DataFault| f.remedy == Remedy::Filter;
        match self.report.data_faults.len() {
            0 => None,
            _ if self.report.data_faults.iter().all(filtered) => {
                Some("The torques were filtered before they were recorded; the model allows for it, as described below.".into())
            }
            1 => Some("The data have a fault, named below.".into()),
            _ => Some("The data have faults, named below.".into()),
        }
    }

    fn physics(&self) -> String {
        if self.report.explains_nothing {
            return "The model explains no more of the torques than a constant per joint: the torques do not depend on the logged motion. No effect was \
                    tested."
                .into();
        }
        if beyond_repair(&self.report.data_faults) {
            return "No effect was tested: the residual of faulty data carries no information about the robot.".into();
        }
        let count = self.report.findings.iter().filter(|f| !is_rejected(f)).count();
        let effects = if count == 1 {
            "One effect explains".into()
        } else {
            format!("{count} effects explain")
        };
        let rest = self.report.remainder.as_ref().map(|r| self.at(&r.joints));
        match (self.report.verdict, count, rest) {
            (Verdict::NothingMissing | Verdict::Explained, 0, _) => "Nothing is missing: the residual is noise.".into(),
            (Verdict::NothingMissing | Verdict::Explained, ..) => format!("{effects} the residual."),
            (Verdict::PartlyExplained, _, Some(rest)) => {
                format!("{effects} a part of the residual; on {rest} a part remains unexplained.")
            }
            (Verdict::PartlyExplained, ..) => format!("{effects} a part of the residual."),
            (Verdict::Unexplained, _, Some(rest)) => {
                format!("No effect explains the residual on {rest}.")
            }
            (Verdict::Unexplained, ..) => "No effect explains the residual.".into(),
        }
    }

    /// Effects that held-out data speak against.
    fn rejected(&self) -> Option<String> {
        let rejected: Vec<String> = self
            .report
            .findings
            .iter()
            .filter(|f| is_rejected(f))
            .map(|f| format!("{} on {}", phrase(&f.effect), self.at(&f.joints)))
            .collect();
        (!rejected.is_empty()).then(|| {
            let [fit, increase, are] = match rejected.len() {
                1 => ["fits", "increases", "is"],
                _ => ["fit", "increase", "are"],
            };
            sentence(&format!(
                "{} {fit} the identification data, {increase} the held-out error and {are} not in the model",
                listed(&rejected, "and")
            ))
        })
    }

    /// What held-out data say of all effects together, and the joints whose error changed most in either direction.
    fn held_out(&self) -> Option<String> {
        let held_out = &self.report.held_out;
        if held_out.verdict == HeldOutVerdict::NotTested {
            return None;
        }
        let ratio = |j: &JointHeldOut| j.after / j.before.max(f64::MIN_POSITIVE);
        let of = |change: Change| held_out.joints.iter().filter(move |j| j.change == change);
        let described = |j: &JointHeldOut| {
            let at = (0..self.robot.joint_count()).find(|&k| self.name(k) == j.joint).unwrap_or(0);
            let (before, after) = (significant(j.before, 3), significant(j.after, 3));
            format!("{} ({before} → {after} {})", j.joint, self.effort(at))
        };
        let best = of(Change::Better).min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        let worst = of(Change::Worse).max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        let whose = match self.report.rms_before.held_out.is_empty() {
            true => "Predicted from the rest of the log, block by block",
            false => "On held-out data",
        };
        let fell = best.map(|j| format!("the error falls most on {}", described(j)));
        let rose = worst.map(|j| format!("it rises on {}", described(j)));
        let changes: Vec<String> = fell.into_iter().chain(rose).collect();
        Some(match (held_out.verdict, changes.is_empty()) {
            (HeldOutVerdict::NotConfirmed, true) => format!("{whose}, the error did not change beyond chance."),
            (HeldOutVerdict::NotConfirmed, false) => {
                format!(
                    "{whose}, the error over all joints did not fall beyond chance; {}.",
                    changes.join("; ")
                )
            }
            (_, true) => format!("{whose}, the error over all joints falls beyond chance."),
            (_, false) => format!("{whose}, {}.", changes.join("; ")),
        })
    }

    /// Joints that nothing was looked for on.
    fn not_tested(&self) -> Option<String> {
        let of = |n: &NotTested| format!("{} ({})", n.joint, n.reason);
        let said: Vec<String> = self.report.not_tested.iter().map(of).collect();
        (!said.is_empty()).then(|| format!("Not tested: {}.", said.join("; ")))
    }

    fn remainder(&self, r: &Remainder) -> String {
        let joints: Vec<usize> = r
            .joints
            .iter()
            .filter_map(|n| (0..self.robot.joint_count()).find(|&j| self.name(j) == n))
            .collect();
        let values = self.with_units(&joints, |j| {
            let at = joints.iter().position(|&k| k == j).unwrap_or(0);
            significant(r.rms.get(at).copied().unwrap_or(f64::NAN), 3)
        });
        let what = sentence(&format!(
            "{} {}",
            self.at(&r.joints),
            if joints.len() > 1 { "have" } else { "has" }
        ));
        // Without measured noise only the least is known.
        let measured = self.report.noise_is_measured();
        let of = match measured {
            true => format!("{values} above the noise"),
            false => format!("at least {values}"),
        };
        let what = format!("{} an unexplained residual of {of}.", what.trim_end_matches('.'));
        if r.depends_on.is_empty() {
            let verb = if measured { "depends on" } else { "is predicted by" };
            return format!("{what} It {verb} no smooth function of one or two positions and speeds.");
        }
        if is_friction_over_time(&r.depends_on) {
            return format!(
                "{what} Friction changes over the log: that predicts {} % of it. The periods of a motion that repeats would tell how fast.",
                significant(100.0 * r.predicted_share, 2),
            );
        }
        let unsteady = |name: &String| ["time", "period"].contains(&name.as_str());
        let predicting = match (r.depends_on.iter().all(unsteady), r.depends_on.len()) {
            (true, _) => "this predicts",
            (false, 1) => "smooth functions of this predict",
            (false, _) => "smooth functions of these predict",
        };
        let on: Vec<&str> = r.depends_on.iter().map(|name| variable_in_words(name)).collect();
        format!(
            "{what} It depends on {}: {predicting} {} % of it.",
            listed(&on, "and"),
            significant(100.0 * r.predicted_share, 2),
        )
    }

    /// `5.4 and 1.9 N·m`; the unit after each where they differ.
    fn with_units(&self, joints: &[usize], value: impl Fn(usize) -> String) -> String {
        let alike = joints.windows(2).all(|w| self.effort(w[0]) == self.effort(w[1]));
        let one = |&j: &usize| {
            if alike {
                value(j)
            } else {
                format!("{} {}", value(j), self.effort(j))
            }
        };
        let text = listed(&joints.iter().map(one).collect::<Vec<_>>(), "and");
        match joints.first().filter(|_| alike) {
            Some(&j) => format!("{text} {}", self.effort(j)),
            None => text,
        }
    }

    /// `joint A4`, `joints A5 and A6`, `the whole robot`.
    fn at(&self, joints: &[String]) -> String {
        match joints.len() {
            1 => format!("joint {}", joints[0]),
            n if n == self.robot.joint_count() => "the whole robot".into(),
            _ => format!("joints {}", listed(joints, "and")),
        }
    }

    fn name(&self, joint: usize) -> &str {
        &self.robot.joints()[joint].name
    }

    fn effort(&self, joint: usize) -> String {
        unit(self.robot.joints()[joint].effort_unit())
    }
}
