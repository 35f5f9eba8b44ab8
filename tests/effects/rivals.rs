//! A residual that could be one of two things, and the experiment that decides it: identified, designed for, simulated,
//! identified again.

use crate::bench::*;
use dynident::diagnosis::{Change, Diagnosis, DiagnosisOptions, diagnose};
use dynident::documents::shipped::Shipped;
use dynident::documents::{DesignDocument, read_excitation_request, robot_value, written_diagnosis};
use dynident::excitation::{Control, Halt, Progress, SearchOptions, search};
use dynident::formats::parse;
use dynident::model::{Limits, Robot};
use dynident::simulate::{Experiment, HiddenEffect, Noise, RecordedLog, simulate};
use dynident::trajectory::{FourierSeries, Trajectory};
use serde_json::{Value, json};

struct Forever;

impl Control for Forever {
    fn halt(&self) -> Option<Halt> {
        None
    }

    fn progress(&self, _: &Progress) {}
}

fn limited(robot: &Robot) -> Robot {
    let limits = Limits {
        position: Some([-2.0, 2.0]),
        velocity: Some(1.5),
        ..Limits::unlimited()
    };
    let joints = robot.joints().iter().map(|j| j.clone().with_limits(limits)).collect();
    Robot::new(robot.name(), robot.gravity(), joints, robot.friction()).unwrap()
}

/// A cautious first experiment: one joint moves a little only.
fn cautious(joints: usize, joint: usize, share: f64, seed: u64) -> FourierSeries {
    let mut series = excitation(joints, seed);
    series.a.row_mut(joint).iter_mut().for_each(|v| *v *= share);
    series.b.row_mut(joint).iter_mut().for_each(|v| *v *= share);
    series
}

struct Arm<'a> {
    robot: &'a Robot,
    phi: Vec<f64>,
    effects: &'a [HiddenEffect],
    noise: Noise,
}

impl Arm<'_> {
    fn log(&self, trajectory: &dyn Trajectory, periods: f64, seed: u64) -> RecordedLog {
        simulate(&Experiment {
            robot: self.robot,
            parameters: &self.phi,
            trajectory,
            periods,
            rate_hz: RATE,
            effects: self.effects,
            noise: &self.noise,
            seed,
        })
    }
}

fn identified(arm: &Arm, logs: &[&RecordedLog], validation: &dyn Trajectory, seed: u64) -> Diagnosis {
    let held_out = arm.log(validation, 3.0, seed + 1_000_000);
    let names = ["first", "second"];
    let stretches: Vec<_> = logs.iter().zip(names).map(|(l, n)| stretch(l, n)).collect();
    diagnose(
        arm.robot,
        &stretches,
        &[stretch(&held_out, "validate")],
        &DiagnosisOptions::default(),
    )
}

fn request(robot: &Robot, traced: &Diagnosis, rival: &dynident::diagnosis::Rival) -> Value {
    let finding = &traced.report.findings[0];
    let model = json!({"robot": robot_value(robot), "augmented": written_diagnosis(traced)});
    json!({
        "fourier": {"order": 5, "fundamental_hz": 0.1}, "sample_rate_hz": 50, "periods": 6,
        "constraints": {"form": "exact", "start": "free"}, "criterion": "rival_evidence",
        "model": model, "given": [model],
        "rivals": {"finding": {"effect": finding.effect, "joints": finding.joints}, "rival": {"effect": rival.effect, "joints": rival.joints}},
        "search": {"max_evaluations": 1500, "starts": 8}
    })
}

fn design(document: &Value) -> (FourierSeries, DesignDocument) {
    let parsed = parse(document.to_string().as_bytes()).unwrap();
    let request = read_excitation_request(&parsed, &Shipped).unwrap();
    let options = SearchOptions {
        jobs_per_round: 4,
        ..request.search.options
    };
    let found = search(&request.problem, &options, &Forever);
    let designs = [(request.problem.clone(), found)];
    let document = DesignDocument::new(&request, &designs, None, None, 0.0);
    (designs[0].1.series.clone(), document)
}

/// Finding, rivals, design, second log: the truth alone is left.
///
/// `found_first` is what the first log, in which the joint moves by a tenth to a half only (`shares`, of it and of its validation
/// log), takes for the truth, and `rival` what it does not exclude.
fn decide(
    hidden: HiddenEffect,
    truth: (&str, &str),
    shares: [f64; 2],
    seed: u64,
    [found_first, rival]: [(&str, &str); 2],
) -> Option<&'static str> {
    let robot = limited(&four_axes());
    let joint = truth.1[1..].parse::<usize>().unwrap() - 1;
    let arm = Arm {
        robot: &robot,
        phi: bodies(&robot, seed),
        effects: &[hidden],
        noise: sensor_noise(4),
    };
    let first = arm.log(&cautious(4, joint, shares[0], seed), 6.0, seed);
    let before = identified(&arm, &[&first], &cautious_validation(4, joint, shares[1], seed), seed);
    let is = |(effect, place): (&str, &str), e: &str, joints: &[String]| e == effect && joints == [place];
    let finding = before.report.findings.first().expect("something is found");
    assert!(is(found_first, &finding.effect, &finding.joints), "{finding:?}");
    let open = finding.rivals.iter().find(|r| is(rival, &r.effect, &r.joints));
    let open = open.unwrap_or_else(|| panic!("the first motion leaves it open: {:?}", finding.rivals));
    let (series, document) = design(&request(&robot, &before, open));
    let reported = document.rivals.expect("asked for");
    let evidence = &reported.expected_evidence;
    let recorded = evidence.recorded.as_ref().expect("the model knows its data");
    println!("{truth:?}: the data said {:.1}; expected {evidence:?}", open.evidence);
    // Of the data themselves: twice a logarithm of odds that is E on average scatters by 2 sqrt(E), and what parameters cost
    // differs by up to ln N = 8.
    let scatter = 3.0 * 2.0 * recorded.least.max(1.0).sqrt();
    assert!(
        (open.evidence - recorded.least).abs() < scatter + 8.0,
        "{} {recorded:?}",
        open.evidence
    );
    assert!(reported.decides && evidence.designed.least > 5.0 * recorded.least);
    // Data only add: a rival has to imitate on both motions with one set of parameters.
    let either = evidence.designed.least.max(recorded.least);
    assert!(evidence.together.least >= either * (1.0 - 1e-6), "{evidence:?}");
    let second = arm.log(&series, 6.0, seed + 77);
    let after = identified(&arm, &[&first, &second], &validation(4, seed), seed);
    let findings = &after.report.findings;
    assert!(
        findings.len() == 1 && is(truth, &findings[0].effect, &findings[0].joints),
        "{findings:?}"
    );
    let other = if truth == found_first { rival } else { found_first };
    let excluded = |r: &dynident::diagnosis::Rival| !is(other, &r.effect, &r.joints);
    assert!(findings[0].rivals.iter().all(excluded), "{:?}", findings[0].rivals);
    reported.nested
}

#[test]
fn prop_a_designed_motion_decides_between_an_offset_and_a_spring() {
    let hidden = effect("torque_offset", 3, 1.2, &four_axes());
    let pair = [("torque_offset", "J4"), ("joint_spring", "J4")];
    // A spring with any rest angle holds the offset: only its own direction is to be decided by the residual.
    assert_eq!(decide(hidden, pair[0], [0.1, 1.0], 2, pair), Some("finding"));
}

#[test]
fn prop_a_designed_motion_decides_between_a_spring_and_an_offset() {
    let hidden = effect("joint_spring", 1, 3.0, &four_axes());
    let pair = [("joint_spring", "J2"), ("torque_offset", "J2")];
    assert_eq!(decide(hidden, pair[0], [0.5, 1.0], 3, pair), Some("rival"));
}

/// The first log takes the wrong joint for the truth.
#[test]
fn prop_a_designed_motion_corrects_a_finding() {
    let hidden = effect("encoder_offset", 2, 1.2, &four_axes());
    let pair = [("encoder_offset", "J2"), ("encoder_offset", "J3")];
    assert_eq!(decide(hidden, pair[1], [0.1, 1.0], 2, pair), None);
}

/// The first log takes a wrong shape of friction for the truth, and so does a validation log that is as cautious.
#[test]
fn prop_a_designed_motion_decides_between_frictions() {
    let hidden = effect("stribeck_friction", 1, 1.2, &four_axes());
    let pair = [("nonlinear_viscous_friction", "J2"), ("stribeck_friction", "J2")];
    assert_eq!(decide(hidden, pair[1], [0.1, 0.1], 2, pair), None);
}

/// A validation log in which the joint moves as far as it can decides at once: the wrong law makes it worse, is reported with the
/// rival that the first log leaves open, and is not in the model, so that there is nothing to design for, and the answer to a
/// request for a design says why.
#[test]
fn prop_a_wide_validation_log_rejects_a_wrong_law() {
    let robot = limited(&four_axes());
    let hidden = effect("stribeck_friction", 1, 1.2, &four_axes());
    let arm = Arm {
        robot: &robot,
        phi: bodies(&robot, 2),
        effects: &[hidden],
        noise: sensor_noise(4),
    };
    let first = arm.log(&cautious(4, 1, 0.1, 2), 6.0, 2);
    let found = identified(&arm, &[&first], &validation(4, 2), 2);
    let finding = &found.report.findings[0];
    println!("{finding:?}");
    assert!(!finding.in_model && finding.held_out.change == Change::Worse);
    let rival = finding.rivals.first().expect("the first log leaves one open");
    let parsed = parse(request(&robot, &found, rival).to_string().as_bytes()).unwrap();
    let Err(refused) = read_excitation_request(&parsed, &Shipped) else {
        panic!("nothing to design for");
    };
    let hint = refused[0].hint.as_deref().unwrap_or_default();
    assert!(hint.contains("held-out"), "{refused:?}");
}

/// Rivals of the one finding on a joint whose motion is a share of the others'.
fn rivals_of(hidden: HiddenEffect, share: f64, seed: u64) -> (String, Vec<String>) {
    let robot = limited(&four_axes());
    let arm = Arm {
        robot: &robot,
        phi: bodies(&robot, seed),
        effects: &[hidden],
        noise: sensor_noise(4),
    };
    let first = arm.log(&cautious(4, 3, share, seed), 6.0, seed);
    let found = identified(&arm, &[&first], &validation(4, seed), seed);
    let finding = &found.report.findings[0];
    let there = finding.rivals.iter().filter(|r| r.joints == ["J4"]);
    (finding.effect.clone(), there.map(|r| r.effect.clone()).collect())
}

/// A spring fits what an offset does, with a parameter more. That is no reason to exclude it as long as the data allow a spring
/// that could be there; where they leave only those with a rest turns away, it is.
#[test]
fn prop_a_spring_is_excluded_by_data_and_not_by_its_parameters() {
    let offset = || effect("torque_offset", 3, 1.2, &four_axes());
    for seed in 2..5 {
        let (found, rivals) = rivals_of(offset(), 0.1, seed);
        assert_eq!(found, "torque_offset", "{seed}");
        assert!(rivals.iter().any(|r| r == "joint_spring"), "{seed}: {rivals:?}");
        let (found, rivals) = rivals_of(offset(), 1.0, seed);
        assert_eq!(found, "torque_offset", "{seed}");
        assert!(rivals.iter().all(|r| r != "joint_spring"), "{seed}: {rivals:?}");
    }
}
