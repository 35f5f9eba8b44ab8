//! Two effects on one joint, which imitate or hide each other.

use crate::bench::*;
use dynident::diagnosis::Verdict;

/// What is found on the fourth joint of the seven-axis arm with these two effects at one and a half times a well visible size:
/// `effect:joint`, sorted.
fn found_with(codes: [&'static str; 2], seed: u64) -> (Vec<String>, Verdict) {
    let robot = seven_axes();
    let hidden = codes.map(|code| effect(code, 3, 1.5, &robot));
    let report = traced(&robot, &hidden, &sensor_noise(7), seed).report;
    let name = |f: &dynident::diagnosis::Finding| format!("{}:{}", f.effect, f.joints.join("+"));
    let mut all: Vec<String> = report.findings.iter().map(name).collect();
    all.sort();
    (all, report.verdict)
}

fn both_alone(codes: [&'static str; 2], seed: u64) {
    let (all, verdict) = found_with(codes, seed);
    let mut expected = codes.map(|code| format!("{code}:J4"));
    expected.sort();
    assert_eq!(all, expected);
    assert_eq!(verdict, Verdict::Explained, "{all:?}");
}

/// Neither earns its place without the other: they are found as a pair.
#[test]
fn prop_two_laws_of_friction_that_hide_each_other_are_found_together() {
    both_alone(["smooth_coulomb_friction", "nonlinear_viscous_friction"], 906);
}

/// A Stribeck law of the wrong width comes first, and a smooth Coulomb law makes up for it: one law takes the place of the two.
#[test]
fn prop_two_effects_that_imitate_one_give_way_to_it() {
    both_alone(["nonlinear_viscous_friction", "stribeck_friction"], 902);
}

/// Hysteresis stands where the arm stood before the log, and builds up as far as the joint moves: with a reversal in the first
/// second in more than one piece. None of them is a touch.
#[test]
fn prop_hysteresis_that_builds_up_at_the_start_is_no_contact() {
    both_alone(["presliding_hysteresis", "torque_offset"], 905);
}
