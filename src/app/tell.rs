//! Findings in sentences with figures, and the variables to draw them against: the one place where an answer says in words what was found.
//! Pages, reports and the command line show them as they are.

use crate::effects::{Kind, by_code};
use crate::io::{listed, measured, significant, unit};
use crate::model::Robot;
use crate::residual::{Finding, Remainder, ResidualReport, RmsPair, Verdict};
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

/// How an effect is spoken of.
struct Known {
    code: &'static str,
    /// As the subject of a sentence.
    phrase: &'static str,
    /// What of its joint it is a function of, for pictures: `q`, `qd`, `qdd`, `tau` or `time`.
    variable: &'static str,
}

const fn effect(code: &'static str, phrase: &'static str, variable: &'static str) -> Known {
    Known { code, phrase, variable }
}

const KNOWN: &[Known] = &[
    effect("torque_offset", "a constant torque offset", "time"),
    effect("stribeck_friction", "Stribeck friction", "qd"),
    effect(
        "nonlinear_viscous_friction",
        "viscous friction that is not linear in speed",
        "qd",
    ),
    effect(
        "asymmetric_viscous_friction",
        "viscous friction that differs between the directions",
        "qd",
    ),
    effect("load_dependent_friction", "friction that grows with the load", "tau"),
    effect("presliding_hysteresis", "hysteresis of friction before sliding", "q"),
    effect("rotor_inertia", "the inertia of the rotor", "qdd"),
    effect("transmission_coupling", "a coupling of the transmissions", "qd"),
    effect("joint_spring", "a spring at the joint", "q"),
    effect("position_ripple", "a ripple over position", "q"),
    effect("joint_elasticity", "elasticity between motor and link", "tau"),
    effect("encoder_offset", "an offset of the encoder", "q"),
    effect("base_tilt", "a tilt of the base", "q"),
    effect("payload", "a payload at the last link", "tau"),
    effect("torque_delay", "a delay of the torque signal", "qd"),
    effect("torque_gain", "a wrong scale of the torque", "tau"),
    effect("torque_crosstalk", "crosstalk between torques", "tau"),
    effect("friction_drift", "friction that changes over time", "time"),
    effect("external_contact", "a contact with something outside", "time"),
];

fn known(code: &str) -> Option<&'static Known> {
    KNOWN.iter().find(|k| k.code == code)
}

fn phrase(code: &str) -> &str {
    known(code).map_or(code, |k| k.phrase)
}

/// Joints that a sentence names; an effect of the whole robot changes more of them.
const MOST_JOINTS: usize = 3;
/// Chance of a lack of fit this large from noise, below which structure is said to remain: what single joints are tested at elsewhere.
const STRUCTURED: f64 = 1e-3;

struct Teller<'a> {
    robot: &'a Robot,
    report: &'a ResidualReport,
}

impl Teller<'_> {
    fn summary(&self) -> String {
        let is_effect = |f: &&Finding| !f.parameters.is_empty();
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

    fn finding(&self, index: usize, f: &Finding) -> String {
        if f.parameters.is_empty() {
            // A fault of the data: what was seen, and what to do.
            return sentence(f.note.as_deref().unwrap_or_default());
        }
        let first = index == 0
            || self.report.findings[..index]
                .iter()
                .all(|before| before.parameters.is_empty());
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
            "{} {} {} {values} that the model{} cannot explain; {} {}: {}. ",
            if several { "Joints" } else { "Joint" },
            listed(&names, "and"),
            if several { "leave" } else { "leaves" },
            if first { "" } else { " with the effects above" },
            phrase(&f.effect),
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
        text += &self.others(f);
        text += &self.what_remains(&shown);
        text
    }

    /// Joints to name: those of the effect, and of many those whose error changes most, in the order of the arm.
    fn shown(&self, f: &Finding, of: &dyn Fn(&RmsPair, usize) -> f64) -> Vec<usize> {
        let gain = |j: usize| 1.0 - of(&f.rms_after, j) / of(&f.rms_before, j).max(f64::MIN_POSITIVE);
        let mut joints: Vec<usize> = (0..self.robot.joint_count())
            .filter(|&j| f.joints.iter().any(|n| n == self.name(j)))
            .collect();
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
            .map(|r| format!("{}{}", phrase(&r.effect), place(&r.joints)))
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
            let tried = by_code(code).is_some_and(|e| matches!(e.kind(), Kind::Additive | Kind::Distortion));
            tried && !open && !found
        };
        let own = by_code(&f.effect).filter(|e| matches!(e.kind(), Kind::Additive | Kind::Distortion));
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
            text += &format!(" Nothing structured remains on {}.", listed(&clean, "and"));
        }
        if !open.is_empty() {
            text += &format!(" Beyond the noise there remain {}.", listed(&open, "and"));
        }
        text
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
        let what = format!("{} {values} above the noise that no effect explains.", what.trim_end_matches('.'));
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

fn parameters(f: &Finding) -> String {
    let one = |p: &crate::residual::ReportedParameter| {
        let value = format!(
            "{} {} {}",
            p.name.replace('_', " "),
            measured(p.value, p.std_dev),
            unit(&p.unit)
        );
        value.trim_end().to_string()
    };
    listed(&f.parameters.iter().map(one).collect::<Vec<_>>(), "and")
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// A variable of a remainder as it is said: states of joints by their symbols.
fn variable_in_words(name: &str) -> &str {
    match name {
        "time" => "the time of the log, whatever the motion",
        "period" => "which period of the log it is",
        symbol => symbol,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::all;
    use crate::io::shipped::Shipped;
    use crate::io::{NamedRobots, RobotDocument};
    use crate::residual::{Evidence, JointFit, ReportedParameter, Rival};

    fn robot() -> Robot {
        let RobotDocument { robot, .. } = Shipped.named("planar_two_link").expect("is shipped");
        robot
    }

    fn parameter(name: &str, value: f64, unit: &str, std_dev: f64) -> ReportedParameter {
        ReportedParameter {
            name: name.into(),
            value,
            unit: unit.into(),
            std_dev,
        }
    }

    fn report(robot: &Robot, held_out: bool) -> ResidualReport {
        let pair = |rms: [f64; 2]| RmsPair {
            identification: rms.to_vec(),
            held_out: if held_out { rms.to_vec() } else { Vec::new() },
        };
        let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
        let fit = |joint: &String, p_value: f64| JointFit {
            joint: joint.clone(),
            statistic: 1.0,
            p_value,
            degrees_of_freedom: [100.0, 300.0],
            residual_rms: 0.1,
            expected_rms: 0.1,
        };
        let finding = Finding {
            effect: "joint_spring".into(),
            joints: vec![names[1].clone()],
            parameters: vec![
                parameter("stiffness", 5.9963, "N m/rad", 0.0057),
                parameter("rest_position", 0.2011, "rad", 0.001),
            ],
            rms_before: pair([0.3, 3.32]),
            rms_after: pair([0.3, 0.2]),
            evidence: Evidence {
                gain: 1e4,
                log_evidence_ratio: 1e4,
                p_value: 0.0,
                held_out_blocks: 1.0,
                held_out_periods: None,
            },
            rivals: vec![Rival {
                effect: "torque_offset".into(),
                joints: vec![names[1].clone()],
                evidence: 2.0,
            }],
            note: None,
        };
        ResidualReport {
            noise_floor: vec![0.3, 0.195],
            noise_source: "scatter between periods".into(),
            lack_of_fit: names.iter().map(|n| fit(n, 0.0)).collect(),
            verdict: Verdict::Explained,
            data_faults: Vec::new(),
            findings: vec![finding],
            remainder: None,
            lack_of_fit_after: names.iter().map(|n| fit(n, 0.4)).collect(),
            rms_before: pair([0.3, 3.32]),
            rms_after: pair([0.3, 0.2]),
        }
    }

    #[test]
    fn every_effect_has_words() {
        for effect in all() {
            assert!(known(effect.code()).is_some(), "{}", effect.code());
        }
    }

    #[test]
    fn a_finding_is_told_with_its_figures() {
        let robot = robot();
        let report = report(&robot, true);
        let mut document = serde_json::to_value(&report).unwrap();
        tell(&robot, &report, &mut document);
        let name = &robot.joints()[1].name;
        let expected = format!(
            "Joint {name} leaves 3.32 N·m that the model cannot explain; a spring at the joint explains it: stiffness 5.9963 ± 0.0057 N·m/rad \
             and rest position 0.2011 ± 0.0010 rad. Held-out error 3.32 → 0.2 N·m (noise alone 0.2). The data do not exclude a constant torque \
             offset. A tilt of the base, an offset of the encoder and a ripple over position are excluded. Nothing structured remains on {name}."
        );
        assert_eq!(document["findings"][0]["sentence"], expected);
        assert_eq!(document["findings"][0]["against"], json!({"joint": name, "variable": "q"}));
        assert_eq!(document["summary"], "One effect explains what the model leaves over.");
    }

    #[test]
    fn what_was_not_seen_is_not_said() {
        let robot = robot();
        let mut report = report(&robot, false);
        report.findings[0].rms_after.identification[1] = 2.0;
        report.lack_of_fit_after[1].p_value = 0.0;
        report.lack_of_fit_after[1].residual_rms = 1.0;
        let mut document = serde_json::to_value(&report).unwrap();
        tell(&robot, &report, &mut document);
        let text = document["findings"][0]["sentence"].as_str().unwrap().to_string();
        assert!(
            text.contains("explains most of it") && text.contains("as none was held out"),
            "{text}"
        );
        assert!(
            !text.contains("Nothing structured") && text.contains("Beyond the noise there remain 0.99 N·m"),
            "{text}"
        );
    }
}
