//! Sentences as they are read, and that every effect has words.

use super::*;
use crate::diagnosis::{
    DataFault, Evaluated, Evidence, FaultKind, FindingHeldOut, HeldOut, JointFit, Remedy, ReportedParameter, Rival, RmsPair,
};
use crate::documents::shipped::Shipped;
use crate::documents::{NamedRobots, RobotDocument};

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
    let joint = |at: usize, before: f64, after: f64, change: Change| JointHeldOut {
        joint: names[at].clone(),
        before,
        after,
        floor: 0.2,
        change,
        p_value: if change == Change::Same { 0.5 } else { 1e-9 },
    };
    let finding = Finding {
        survivals: Vec::new(),
        effect: "joint_spring".into(),
        joints: vec![names[1].clone()],
        formula: None,
        covered: Vec::new(),
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
            held_out_blocks: Evaluated::Value(1.0),
            held_out_periods: Evaluated::NotEvaluated,
        },
        held_out: FindingHeldOut {
            before: Evaluated::Value(3.32),
            after: Evaluated::Value(0.2),
            change: Change::Better,
            p_value: Evaluated::Value(1e-9),
        },
        in_model: true,
        rivals: vec![Rival {
            effect: "torque_offset".into(),
            joints: vec![names[1].clone()],
            evidence: 2.0,
            formula: None,
        }],
        note: None,
    };
    ResidualReport {
        explains_nothing: false,
        not_tested: Vec::new(),
        noise_floor: vec![0.3, 0.195],
        noise_source: "scatter between periods".into(),
        lack_of_fit: names.iter().map(|n| fit(n, 0.0)).collect(),
        verdict: Verdict::Explained,
        held_out: HeldOut {
            verdict: HeldOutVerdict::Confirmed,
            source: "validation logs".into(),
            p_value: Evaluated::Value(1e-9),
            joints: vec![joint(0, 0.3, 0.3, Change::Same), joint(1, 3.32, 0.2, Change::Better)],
        },
        data_faults: Vec::new(),
        findings: vec![finding],
        remainder: None,
        undetected: Vec::new(),
        lack_of_fit_after: names.iter().map(|n| fit(n, 0.4)).collect(),
        rms_before: pair([0.3, 3.32]),
        rms_after: pair([0.3, 0.2]),
        at_rest: None,
    }
}

#[test]
fn a_finding_is_reported_with_its_figures() {
    let robot = robot();
    let report = report(&robot, true);
    let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
    let name = &robot.joints()[1].name;
    let expected = format!(
        "The residual on joint {name} is 3.32 N·m; a joint spring explains it: stiffness 5.9963 ± 0.0057 N·m/rad \
         and rest position 0.2011 ± 0.0010 rad. Held-out error 3.32 → 0.2 N·m (noise alone 0.2). The data do not exclude a constant torque \
         offset. A base tilt, an encoder offset and position ripple are excluded. The residual on {name} is noise."
    );
    assert_eq!(document["findings"][0]["sentence"], expected);
    assert_eq!(
        document["findings"][0]["against"],
        serde_json::json!({"joint": name, "variable": "q"})
    );
    let summary = format!("One effect explains the residual. On held-out data, the error falls most on {name} (3.32 → 0.2 N·m).");
    assert_eq!(document["summary"], summary);
}

/// Above which noise, nobody knows there.
#[test]
fn of_a_remainder_without_periods_the_least_is_said() {
    let robot = robot();
    let mut report = report(&robot, true);
    report.noise_source = "the residual's own course".into();
    report.remainder = Some(Remainder {
        joints: vec![robot.joints()[1].name.clone()],
        depends_on: Vec::new(),
        predicted_share: 0.0,
        rms: vec![0.4],
        note: "what is left follows the motion; a motion that repeats would tell".into(),
    });
    let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
    let sentence = format!(
        "Joint {} has an unexplained residual of at least 0.4 N·m. It is predicted by no smooth function of one or two positions and speeds.",
        robot.joints()[1].name
    );
    assert_eq!(document["remainder"]["sentence"], sentence);
}

#[test]
fn what_was_not_seen_is_not_said() {
    let robot = robot();
    let mut report = report(&robot, false);
    report.findings[0].rms_after.identification[1] = 2.0;
    report.lack_of_fit_after[1].p_value = 0.0;
    report.lack_of_fit_after[1].residual_rms = 1.0;
    let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
    let text = document["findings"][0]["sentence"].as_str().unwrap().to_string();
    assert!(
        text.contains("explains most of it") && text.contains("as none was held out"),
        "{text}"
    );
    assert!(
        !text.contains("is noise") && text.contains("Above the noise, 0.99 N·m"),
        "{text}"
    );
}

#[test]
fn what_held_out_data_reject_is_said_to_be_rejected() {
    let robot = robot();
    let mut report = report(&robot, true);
    report.findings[0].in_model = false;
    report.findings[0].held_out.change = Change::Worse;
    report.verdict = Verdict::Unexplained;
    report.held_out.verdict = HeldOutVerdict::NotTested;
    let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
    let (summary, sentence) = (
        document["summary"].to_string(),
        document["findings"][0]["sentence"].to_string(),
    );
    assert!(
        summary.contains("No effect explains") && summary.contains("is not in the model"),
        "{summary}"
    );
    assert!(
        sentence.contains("it is not in the model") && !sentence.contains("is noise"),
        "{sentence}"
    );
}

#[test]
fn of_wrong_data_nothing_is_said_of_the_robot() {
    let robot = robot();
    let mut report = report(&robot, true);
    report.findings.clear();
    report.verdict = Verdict::NothingMissing;
    let fault = DataFault {
        fault: FaultKind::JointOrder,
        joints: Vec::new(),
        detail: "the columns are exchanged".into(),
        remedy: Remedy::Nothing,
        parameters: Vec::new(),
    };
    super::super::diagnose::report_faults(&mut report, vec![fault]);
    let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
    assert_eq!(document["verdict"], "unexplained");
    let summary = document["summary"].as_str().unwrap();
    assert!(
        summary.contains("No effect was tested") && !summary.contains("Nothing is missing"),
        "{summary}"
    );
}

/// Two halves and two cut-offs are one phrase each, and what is not found again is said.
#[test]
fn a_finding_says_with_which_changes_of_the_data_it_is_found_again() {
    use crate::diagnosis::{Perturbation, Survival};
    let robot = robot();
    let described = |survive: [bool; 6]| {
        use Perturbation::*;
        let all = [SixDigits, EverySecondRow, FirstHalf, SecondHalf, LowerCutoff, HigherCutoff];
        let mut report = report(&robot, true);
        report.findings[0].survivals = all
            .into_iter()
            .zip(survive)
            .map(|(perturbation, survives)| Survival { perturbation, survives })
            .collect();
        let document = serde_json::to_value(residual_document(&robot, &report)).unwrap();
        document["findings"][0]["sentence"].as_str().unwrap().to_string()
    };
    let all = "It is found again with either half of the data alone, a cut-off a quarter lower or higher, every second row and torques rounded to six digits.";
    assert!(described([true; 6]).contains(all), "{}", described([true; 6]));
    let some = "It is found again with the second half of the data, every second row and torques rounded to six digits, but not with the first half of \
                the data or a cut-off a quarter lower or higher.";
    let sentence = described([true, true, false, true, false, false]);
    assert!(sentence.contains(some), "{sentence}");
}
