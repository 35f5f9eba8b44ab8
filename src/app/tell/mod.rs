//! Findings in sentences with figures, and the variables to draw them against: the one place where an answer says in words what was found.
//! Pages, reports and the command line show them as they are.

mod finding;
#[cfg(test)]
mod tests;
mod words;

use self::words::{known, sentence, variable_in_words};
use crate::io::{listed, significant, unit};
use crate::model::Robot;
use crate::residual::{Finding, Remainder, ResidualReport, Verdict};
use serde_json::{Value, json};

/// Adds to the document of `report`: `summary`, to every finding `sentence` and `against`, to the remainder `sentence`.
pub(super) fn tell(robot: &Robot, report: &ResidualReport, document: &mut Value) {
    let teller = Teller { robot, report };
    document["summary"] = teller.summary().into();
    for (i, finding) in report.findings.iter().enumerate() {
        let told = &mut document["findings"][i];
        told["sentence"] = teller.finding(i, finding).into();
        told["against"] =
            json!({"joint": finding.joints.first(), "variable": known(&finding.effect).map_or("time", |k| k.variable)});
    }
    if let Some(rest) = &report.remainder {
        document["remainder"]["sentence"] = teller.remainder(rest).into();
    }
}

struct Teller<'a> {
    robot: &'a Robot,
    report: &'a ResidualReport,
}

impl Teller<'_> {
    fn summary(&self) -> String {
        let is_effect = |f: &&Finding| !finding::is_fault(f);
        let count = self.report.findings.iter().filter(is_effect).count();
        let faults = self.report.findings.len() - count;
        let effects = if count == 1 {
            "One effect explains".into()
        } else {
            format!("{count} effects explain")
        };
        let rest = self.report.remainder.as_ref().map(|r| self.at(&r.joints)).unwrap_or_default();
        let physics = match (self.report.verdict, count) {
            (Verdict::NothingMissing | Verdict::Explained, 0) => {
                "Nothing is missing: what the model leaves over is noise.".into()
            }
            (Verdict::NothingMissing | Verdict::Explained, _) => format!("{effects} what the model leaves over."),
            (Verdict::PartlyExplained, _) => {
                format!("{effects} a part of what the model leaves over; on {rest} something remains that no effect explains.")
            }
            (Verdict::Unexplained, _) => format!("On {rest} the model leaves over something that no effect explains."),
        };
        match faults {
            0 => physics,
            1 => format!("The data have a fault, named below. {physics}"),
            _ => format!("The data have faults, named below. {physics}"),
        }
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
            if joints.len() > 1 { "keep" } else { "keeps" }
        ));
        let what = format!(
            "{} {values} above the noise that no effect explains.",
            what.trim_end_matches('.')
        );
        if r.depends_on.is_empty() {
            return format!("{what} Nor does a smooth function of one or two positions and speeds.");
        }
        let unsteady = |name: &String| ["time", "period"].contains(&name.as_str());
        let predicting = match (r.depends_on.iter().all(unsteady), r.depends_on.len()) {
            (true, _) => "that predicts",
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
