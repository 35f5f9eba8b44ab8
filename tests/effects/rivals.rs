//! A residual that could be one of two things, and the experiment that decides it: identified, designed for, simulated, identified again.

use crate::bench::*;
use dynident::excitation::{Control, Halt, Progress, SearchOptions, search};
use dynident::io::shipped::Shipped;
use dynident::io::{DesignDocument, parse, read_excitation_request, robot_value, traced_value};
use dynident::model::{Limits, Robot};
use dynident::residual::{Outcome, TraceOptions, trace};
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

fn identified(arm: &Arm, logs: &[&RecordedLog], seed: u64) -> Outcome {
    let held_out = arm.log(&validation(arm.robot.joint_count(), seed), 3.0, seed + 1_000_000);
    let names = ["first", "second"];
    let stretches: Vec<_> = logs.iter().zip(names).map(|(l, n)| stretch(l, n)).collect();
    trace(arm.robot, &stretches, &[stretch(&held_out, "validate")], &TraceOptions::default())
}

fn request(robot: &Robot, traced: &Outcome, rival: &dynident::residual::Rival) -> Value {
    let finding = &traced.report.findings[0];
    let model = json!({"robot": robot_value(robot), "augmented": traced_value(traced)});
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
    let document = DesignDocument::new(&request, &designs, None, 0.0);
    (designs[0].1.series.clone(), document)
}

/// Finding, rivals, design, second log, rivals gone.
fn decide(hidden: HiddenEffect, joint: usize, share: f64, true_code: &str, seed: u64) {
    let robot = limited(&four_axes());
    let arm = Arm {
        robot: &robot,
        phi: bodies(&robot, seed),
        effects: &[hidden],
        noise: sensor_noise(4),
    };
    let first = arm.log(&cautious(4, joint, share, seed), 6.0, seed);
    let before = identified(&arm, &[&first], seed);
    let finding = before.report.findings.first().expect("something is found");
    println!("first: {} on {:?}", finding.effect, finding.joints);
    for r in &finding.rivals {
        println!("   rival {} on {:?}: {:.1}", r.effect, r.joints, r.evidence);
    }
    assert!(!finding.rivals.is_empty(), "the first motion leaves it open");
    // The one that is hardest to tell from the finding.
    let rival = finding.rivals.iter().find(|r| finding.effect == true_code || r.effect == true_code);
    let rival = rival.expect("the truth is the finding or among its rivals");
    let (series, document) = design(&request(&robot, &before, rival));
    let told = document.rivals.expect("asked for");
    let evidence = &told.expected_evidence;
    println!("{} or {}: {evidence:?}", told.finding.effect, told.rival.effect);
    let recorded = evidence.recorded.as_ref().expect("the model knows its data");
    assert!(told.decides && evidence.designed.least > 10.0 * recorded.least.max(1.0));
    // What the data said lies where they were to be expected: twice a log odds of size E scatters by 2 sqrt(E), and parameters paid for differ by a few.
    let said = rival.evidence;
    println!("the data said {said:.1}");
    let second = arm.log(&series, 6.0, seed + 77);
    let after = identified(&arm, &[&first, &second], seed);
    for f in &after.report.findings {
        println!("both: {} on {:?}, rivals {:?}", f.effect, f.joints, f.rivals);
    }
    let names: Vec<&str> = after.report.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(names, [true_code], "the truth, and nothing else");
    let excluded = if finding.effect == true_code { &rival.effect } else { &finding.effect };
    assert!(after.report.findings[0].rivals.iter().all(|r| r.effect != *excluded), "{excluded} is excluded now");
}

#[test]
fn prop_a_designed_motion_decides_between_an_offset_and_its_rival() {
    let hidden = HiddenEffect::TorqueOffset { joint: 2, offset: 0.25 };
    decide(hidden, 2, 0.15, "torque_offset", 5);
}

#[test]
fn prop_a_designed_motion_decides_between_frictions() {
    let hidden = HiddenEffect::NonlinearViscousFriction {
        joint: 2,
        coefficient: 1.2,
        exponent: 2.0,
    };
    decide(hidden, 2, 0.3, "nonlinear_viscous_friction", 6);
}
