//! Velocities that a log has.

use crate::simulated::{TORQUE_NOISE, Virtual, noisy, way_points};
use dynident::preparation::{Log, PreparedLog, PreprocessOptions, prepare};
use dynident::trajectory::Trajectory;

/// A motion that does not repeat, with coarse positions and good velocities.
fn logged() -> Log {
    let robot = Virtual::iiwa14();
    let path = way_points(3);
    let mut log = noisy(&robot.clean(&path, 200.0, 1), 2e-4, &TORQUE_NOISE, 1);
    let velocity = |j: usize| (0..log.samples()).map(|s| path.state(j, s as f64 / 200.0)[1]).collect();
    log.qd = Some((0..7).map(velocity).collect());
    log
}

fn prepared(log: &Log) -> (PreparedLog, String, String) {
    let prepared = prepare(log, 7, &PreprocessOptions::default()).unwrap();
    let choice = prepared
        .choices
        .iter()
        .find(|c| c.what == "logged_velocities")
        .unwrap()
        .clone();
    (prepared, choice.value, choice.why)
}

fn acceleration_error(prepared: &PreparedLog) -> f64 {
    let path = way_points(3);
    let (from, to) = (prepared.samples() / 5, prepared.samples() * 4 / 5);
    let square = |s: usize| (prepared.motion.accelerations(1)[s] - path.state(1, s as f64 / 200.0)[2]).powi(2);
    ((from..to).map(square).sum::<f64>() / (to - from) as f64).sqrt()
}

#[test]
fn prop_velocities_that_agree_with_the_positions_are_used_and_better_for_it() {
    let log = logged();
    let (with, value, _) = prepared(&log);
    assert_eq!(value, "used");
    let without = prepare(&Log { qd: None, ..log }, 7, &PreprocessOptions::default()).unwrap();
    assert!(without.choices.iter().all(|c| c.what != "logged_velocities"));
    assert!(acceleration_error(&with) < acceleration_error(&without));
}

#[test]
fn prop_velocities_in_another_unit_are_not_used_and_the_answer_says_why() {
    let mut log = logged();
    log.qd.as_mut().unwrap()[4].iter_mut().for_each(|v| *v *= 57.3);
    let (_, value, why) = prepared(&log);
    assert_eq!(value, "not used");
    assert!(why.contains("joint 5") && why.contains("unit"), "{why}");
}
