//! Effects with formulas of their own: found, not found, declared, and the same as listed ones.

use crate::bench::*;
use dynident::diagnosis::{Diagnosis, DiagnosisOptions, Finding, HeldOutVerdict, Verdict, diagnose};
use dynident::documents::{Cursor, Findings, augmented_value, read_augmented};
use dynident::effects::own::ParameterDefinition;
use dynident::effects::{Definition, OwnEffect};
use dynident::model::Robot;
use dynident::regression::{Estimator, Stretch};
use dynident::simulate::{HiddenEffect, RecordedLog};
use dynident::trajectory::Trajectory;
use std::sync::Arc;

/// A parameter: name, unit, lowest, highest.
type Given<'a> = (&'a str, &'a str, Option<f64>, Option<f64>);

fn own(robot: &Robot, name: &str, joint: usize, expression: &str, parameters: &[Given], declared: bool) -> Arc<OwnEffect> {
    let parameter = |&(name, unit, low, high): &Given| ParameterDefinition {
        name: name.into(),
        unit: unit.into(),
        low,
        high,
    };
    let definition = Definition {
        channels: Vec::new(),
        name: name.into(),
        joint: robot.joints()[joint].name.clone(),
        expression: expression.into(),
        parameters: parameters.iter().map(parameter).collect(),
        declared,
    };
    Arc::new(OwnEffect::new(definition, robot).unwrap_or_else(|e| panic!("{e:?}")))
}

/// What a hidden formula adds to its joint, from `[q, qd, qdd]` of all joints.
type Nature = (usize, fn(&[[f64; 3]]) -> f64);

/// Adds formulas to the torques of a log.
fn add(log: &mut RecordedLog, motion: &dyn Trajectory, natures: &[Nature]) {
    for (s, t) in log.time.iter().enumerate() {
        let phase = t.rem_euclid(motion.duration());
        let states: Vec<[f64; 3]> = (0..motion.joints()).map(|j| motion.state(j, phase)).collect();
        natures.iter().for_each(|(j, torque)| log.tau[*j][s] += torque(&states));
    }
}

/// Identification and validation log with hidden effects, and formulas that no listed effect has.
fn recordings(robot: &Robot, hidden: &[HiddenEffect], natures: &[Nature], seed: u64) -> [Stretch; 2] {
    let n = robot.joint_count();
    let mut both = logs(robot, hidden, &sensor_noise(n), seed);
    let motions: [Box<dyn Trajectory>; 2] = [Box::new(excitation(n, seed)), Box::new(validation(n, seed))];
    for (log, motion) in both.iter_mut().zip(&motions) {
        add(log, &**motion, natures);
    }
    let [identify, validate] = both;
    [stretch(&identify, "identify"), stretch(&validate, "validate")]
}

fn diagnosed(robot: &Robot, [identify, validate]: &[Stretch; 2], own: Vec<Arc<OwnEffect>>, search: bool) -> Diagnosis {
    let options = DiagnosisOptions {
        own,
        search,
        ..DiagnosisOptions::default()
    };
    diagnose(
        robot,
        std::slice::from_ref(identify),
        std::slice::from_ref(validate),
        &options,
    )
}

fn names(outcome: &Diagnosis) -> Vec<String> {
    let findings = outcome.report.findings.iter();
    findings.map(|f| format!("{} on {:?}", f.effect, f.joints)).collect()
}

/// The only finding, within four standard deviations of the truth in all its parameters: one in 16 000 by chance.
fn only<'a>(outcome: &'a Diagnosis, name: &str, truth: &[(&str, f64)]) -> &'a Finding {
    let report = &outcome.report;
    assert_eq!(report.findings.len(), 1, "{:?} {:?}", names(outcome), report.remainder);
    let finding = &report.findings[0];
    assert_eq!(finding.effect, name);
    assert!(
        finding.in_model && report.verdict == Verdict::Explained,
        "{:?}",
        report.remainder
    );
    assert_eq!(report.held_out.verdict, HeldOutVerdict::Confirmed);
    for (name, truth) in truth {
        let p = finding.parameters.iter().find(|p| p.name == *name).unwrap();
        assert!(
            (p.value - truth).abs() < 4.0 * p.std_dev,
            "{} = {} ± {}, truth {truth}",
            p.name,
            p.value,
            p.std_dev
        );
    }
    for (rms, floor) in report.rms_after.held_out.iter().zip(&report.noise_floor) {
        assert!(*rms < 1.1 * floor, "held out {rms} above the floor {floor}");
    }
    finding
}

const COUNTERBALANCE: &[Given] = &[("k", "N m", Some(0.0), None), ("q0", "rad", None, None)];

/// A spring between two pins.
fn pin_spring(robot: &Robot, declared: bool) -> Arc<OwnEffect> {
    let parameters = [
        ("a", "N m", Some(0.0), None),
        ("b", "N m", None, Some(0.0)),
        ("phi", "rad", Some(-1.5), Some(1.5)),
        ("rho", "1", Some(0.05), Some(0.995)),
    ];
    let formula = "a*sin(q4 + phi) + b*sin(q4 + phi)/sqrt(1 - rho*cos(q4 + phi))";
    own(robot, "counterbalance", 3, formula, &parameters, declared)
}

const PINS: Nature = (3, |s| {
    let u = s[3][0] + 0.4;
    12.0 * u.sin() - 7.0 * u.sin() / (1.0 - 0.85 * u.cos()).sqrt()
});

#[test]
fn prop_a_spring_between_pins_is_found_by_its_formula() {
    let robot = seven_axes();
    let logs = recordings(&robot, &[], &[PINS], 11);
    let outcome = diagnosed(&robot, &logs, vec![pin_spring(&robot, false)], true);
    let finding = only(
        &outcome,
        "counterbalance",
        &[("a", 12.0), ("b", -7.0), ("phi", 0.4), ("rho", 0.85)],
    );
    let formula = finding.formula.as_ref().unwrap();
    assert_eq!(formula.variables, ["q4"]);
    assert_eq!(finding.covered.len(), 1);
    assert!(finding.note.as_deref().is_none_or(|note| !note.contains("provisional")));
}

#[test]
fn prop_a_counterbalance_with_twice_the_angle_goes_round_to_its_phase() {
    let robot = seven_axes();
    let nature: Nature = (1, |s| 1.1 * (2.0 * (s[1][0] - 2.9)).sin() * s[1][1].abs());
    let logs = recordings(&robot, &[], &[nature], 12);
    let parameters = [("k", "N m s/rad", Some(0.0), None), ("q0", "rad", None, None)];
    let effect = own(&robot, "cam", 1, "k*sin(2*(q2 - q0))*abs(qd2)", &parameters, false);
    let outcome = diagnosed(&robot, &logs, vec![effect], true);
    let finding = only(&outcome, "cam", &[("k", 1.1)]);
    // Half a turn more is the same.
    let q0 = finding.parameters.iter().find(|p| p.name == "q0").unwrap();
    let off = (q0.value - 2.9).rem_euclid(std::f64::consts::PI);
    assert!(off.min(std::f64::consts::PI - off) < 4.0 * q0.std_dev, "{q0:?}");
}

#[test]
fn prop_a_shape_parameter_is_found_beside_another_joints_state() {
    let robot = seven_axes();
    let nature: Nature = (2, |s| 0.9 * (s[2][1] / 0.25).tanh() * s[4][0].cos());
    let logs = recordings(&robot, &[], &[nature], 13);
    let parameters = [("c", "N m", Some(0.0), None), ("s", "rad/s", Some(0.02), Some(2.0))];
    let effect = own(&robot, "seal", 2, "c*tanh(qd3/s)*cos(q5)", &parameters, false);
    let outcome = diagnosed(&robot, &logs, vec![effect], true);
    only(&outcome, "seal", &[("c", 0.9), ("s", 0.25)]);
}

/// Values and deviations of a finding that is a listed effect, and of the own effect that is the same.
fn same(robot: &Robot, hidden: HiddenEffect, effect: Arc<OwnEffect>, seed: u64, pairs: &[(&str, &str)]) {
    let logs = recordings(robot, &[hidden], &[], seed);
    let name = effect.definition().name.clone();
    let [listed, own] = [Vec::new(), vec![effect]].map(|own| diagnosed(robot, &logs, own, true));
    assert_eq!(own.report.findings.len(), 1, "{:?}", names(&own));
    assert_eq!(listed.report.findings.len(), 1, "{:?}", names(&listed));
    let [a, b] = [&listed.report.findings[0], &own.report.findings[0]];
    assert_eq!(b.effect, name);
    for (theirs, ours) in pairs {
        let [x, y] = [(a, theirs), (b, ours)].map(|(f, name)| f.parameters.iter().find(|p| p.name == **name).unwrap());
        // Rounding of normal equations.
        assert!((x.value - y.value).abs() < 1e-6 * x.value.abs(), "{x:?} {y:?}");
        assert!((x.std_dev - y.std_dev).abs() < 1e-6 * x.std_dev, "{x:?} {y:?}");
    }
    assert!((a.evidence.gain - b.evidence.gain).abs() < 1e-6 * a.evidence.gain);
    let errors = a.rms_after.held_out.iter().zip(&b.rms_after.held_out);
    assert!(errors.into_iter().all(|(x, y)| (x - y).abs() < 1e-9 * x));
}

#[test]
fn prop_the_formula_of_a_listed_effect_has_its_values_and_deviations() {
    let robot = seven_axes();
    let spring = HiddenEffect::JointSpring {
        joint: 3,
        stiffness: 1.8,
        rest: 0.2,
    };
    let parameters = [("k", "N m/rad", Some(0.0), None), ("c", "N m", None, None)];
    same(
        &robot,
        spring,
        own(&robot, "hose", 3, "k*q4 + c", &parameters, false),
        3,
        &[("stiffness", "k")],
    );
    let friction = HiddenEffect::AsymmetricViscousFriction {
        joint: 4,
        coefficient: 0.5,
    };
    let parameters = [("c", "N m s/rad", None, None)];
    let effect = own(&robot, "one_way", 4, "c*abs(qd5)", &parameters, false);
    let logs = recordings(&robot, std::slice::from_ref(&friction), &[], 4);
    let listed = diagnosed(&robot, &logs, Vec::new(), true);
    let name = listed.report.findings[0].parameters[0].name.clone();
    same(&robot, friction, effect, 4, &[(&name, "c")]);
}

/// A spring with its rest as a shape parameter is the listed one, whose rest follows from a coefficient.
#[test]
fn prop_a_rest_that_is_searched_is_the_one_that_is_computed() {
    let robot = seven_axes();
    let spring = HiddenEffect::JointSpring {
        joint: 3,
        stiffness: 1.8,
        rest: 0.2,
    };
    let logs = recordings(&robot, &[spring], &[], 3);
    let parameters = [("k", "N m/rad", Some(0.0), None), ("q0", "rad", Some(-1.5), Some(1.5))];
    let effect = own(&robot, "hose", 3, "k*(q4 - q0)", &parameters, true);
    let [listed, own] = [Vec::new(), vec![effect]].map(|own| diagnosed(&robot, &logs, own, true));
    let found = &own.estimates.as_ref().unwrap().found;
    let term = &found.model.terms[0];
    let deviations = found.term_covariance(0).diagonal().map(f64::sqrt);
    for (p, (value, std_dev)) in listed.report.findings[0]
        .parameters
        .iter()
        .zip([(term.coefficients[0], deviations[0]), (term.shape[0], deviations[1])])
    {
        // Gauss-Newton ends within a thousandth of a deviation, and differences of a shape are good to 1e-4.
        assert!((p.value - value).abs() < 0.01 * p.std_dev, "{p:?} {value}");
        assert!((p.std_dev / std_dev - 1.0).abs() < 0.01, "{p:?} {std_dev}");
    }
}

#[test]
fn prop_an_own_effect_that_is_absent_is_not_found() {
    let robot = seven_axes();
    let seal = [("c", "N m", Some(0.0), None), ("s", "rad/s", Some(0.02), Some(2.0))];
    for seed in 0..3 {
        let candidates = vec![
            pin_spring(&robot, false),
            own(&robot, "seal", 2, "c*tanh(qd3/s)*cos(q5)", &seal, false),
            own(&robot, "cubic", 5, "a*q6^3", &[("a", "N m/rad^3", None, None)], false),
        ];
        let logs = recordings(&robot, &[], &[], 60 + seed);
        let outcome = diagnosed(&robot, &logs, candidates.clone(), true);
        assert_eq!(outcome.report.verdict, Verdict::NothingMissing, "{:?}", names(&outcome));
        // Beside another effect, that one alone is found.
        let offset = HiddenEffect::TorqueOffset { joint: 2, offset: 0.4 };
        let logs = recordings(&robot, &[offset], &[], 60 + seed);
        let outcome = diagnosed(&robot, &logs, candidates, true);
        assert_eq!(names(&outcome), ["torque_offset on [\"J3\"]"]);
    }
}

#[test]
fn prop_a_declared_effect_is_in_the_model_from_the_start() {
    let robot = seven_axes();
    let logs = recordings(&robot, &[], &[PINS], 11);
    for search in [true, false] {
        let outcome = diagnosed(&robot, &logs, vec![pin_spring(&robot, true)], search);
        assert!(outcome.report.findings.is_empty(), "{:?}", names(&outcome));
        let estimates = outcome.estimates.as_ref().unwrap();
        for fitted in [&estimates.found, &estimates.declared] {
            let term = &fitted.model.terms[0];
            let deviations = fitted.term_covariance(0).diagonal().map(f64::sqrt);
            let values = [term.coefficients[0], term.coefficients[1], term.shape[0], term.shape[1]];
            for ((value, truth), std_dev) in values.iter().zip([12.0, -7.0, 0.4, 0.85]).zip(&deviations) {
                assert!((value - truth).abs() < 4.0 * std_dev, "{value} ± {std_dev}, truth {truth}");
            }
        }
        for (rms, floor) in outcome.report.rms_before.held_out.iter().zip(&outcome.report.noise_floor) {
            assert!(*rms < 1.1 * floor, "held out {rms} above the floor {floor}");
        }
    }
    // What is declared does not hide what is not.
    let spring = HiddenEffect::JointSpring {
        joint: 5,
        stiffness: 0.9,
        rest: 0.2,
    };
    let logs = recordings(&robot, &[spring], &[PINS], 14);
    let outcome = diagnosed(&robot, &logs, vec![pin_spring(&robot, true)], true);
    assert_eq!(names(&outcome), ["joint_spring on [\"J6\"]"]);
    assert_eq!(outcome.model.terms.len(), 2);
}

/// A declared effect that is not there has no size, within its deviations, and every estimator fits it.
#[test]
fn prop_a_declared_effect_without_a_cause_is_zero_within_its_deviations() {
    let robot = six_axes();
    let logs = recordings(&robot, &[], &[], 21);
    let effect = own(&robot, "cubic", 3, "a*q4^3", &[("a", "N m/rad^3", None, None)], true);
    for estimator in [Estimator::Ordinary, Estimator::Weighted, Estimator::Robust] {
        let options = DiagnosisOptions {
            own: vec![effect.clone()],
            search: false,
            estimator,
            ..DiagnosisOptions::default()
        };
        let [identify, validate] = &logs;
        let outcome = diagnose(
            &robot,
            std::slice::from_ref(identify),
            std::slice::from_ref(validate),
            &options,
        );
        let found = &outcome.estimates.as_ref().unwrap().found;
        let std_dev = found.term_covariance(0)[(0, 0)].sqrt();
        let value = found.model.terms[0].coefficients[0];
        assert!(
            value.abs() < 4.0 * std_dev && std_dev > 0.0 && std_dev < 0.1,
            "{value} ± {std_dev}"
        );
    }
}

/// A log without periods has all of what the model leaves for its noise.
#[test]
fn prop_without_periods_an_own_effect_is_found_and_a_declared_one_fitted() {
    let robot = seven_axes();
    let mut log = recorded_once(&robot, &[], &sensor_noise(7), 15);
    add(&mut log, &single_run(7, 15), &[PINS]);
    for declared in [false, true] {
        let options = DiagnosisOptions {
            own: vec![pin_spring(&robot, declared)],
            ..DiagnosisOptions::default()
        };
        let outcome = diagnose(&robot, &[stretch(&log, "once")], &[], &options);
        let found = names(&outcome);
        match declared {
            true => assert!(found.is_empty(), "{found:?}"),
            false => assert_eq!(found, ["counterbalance on [\"J4\"]"]),
        }
        let term = &outcome.estimates.as_ref().unwrap().found.model.terms[0];
        assert_eq!(term.effect.own().unwrap().definition().name, "counterbalance");
        // What is left is noise, as on the joint beside it that has the same, with fewer columns.
        let left = &outcome.report.rms_after.identification;
        assert!((0.8..1.2).contains(&(left[3] / left[2])), "{left:?}");
    }
}

#[test]
fn prop_a_model_with_own_effects_reads_back_and_predicts_the_same() {
    let robot = seven_axes();
    let logs = recordings(&robot, &[], &[PINS], 11);
    let cubic = own(&robot, "cubic", 5, "a*q6^3", &[("a", "N m/rad^3", None, None)], true);
    let outcome = diagnosed(&robot, &logs, vec![pin_spring(&robot, false), cubic], true);
    let written = augmented_value(&outcome.model, &outcome.information);
    assert_eq!(written["effects"][0]["definition"]["expression"], "a*q6^3");
    let law = &written["effects"][1]["law"];
    assert_eq!(
        law["expression"],
        "a*sin(q4 + phi) + b*sin(q4 + phi)/sqrt(1 - rho*cos(q4 + phi))"
    );
    assert!(law["mathml"][0].as_str().unwrap().contains("<msqrt>") && law["energy"].is_null());
    let findings = Findings::default();
    let read = read_augmented(&Cursor::root(&written, &findings), &robot);
    let (model, prior) = read.unwrap_or_else(|| panic!("{:?}", findings.into_list()));
    assert_eq!(prior.mean, outcome.model.vector());
    for stretch in &logs {
        assert_eq!(model.predict(stretch), outcome.model.predict(stretch));
    }
    // Another name, or a definition that is none, is refused.
    for (pointer, value) in [("effect", "joint"), ("definition", "")] {
        let mut changed = written.clone();
        changed["effects"][0][pointer] = value.into();
        let findings = Findings::default();
        assert!(read_augmented(&Cursor::root(&changed, &findings), &robot).is_none());
        assert!(!findings.is_empty());
    }
    // What a validation would find: nothing has changed.
    let options = DiagnosisOptions {
        existing: Some((model, prior)),
        ..DiagnosisOptions::default()
    };
    let [_, later] = logs;
    let report = diagnose(&robot, &[later], &[], &options).report;
    assert_eq!(report.verdict, Verdict::NothingMissing, "{:?}", report.findings);
}

/// A name that is used for a joint's spring in a formula, at the edge of what is hidden: gravity and `k sin(q2 − q0)` on a joint
/// that turns about a level axis.
#[test]
fn prop_what_base_parameters_hide_is_not_found() {
    let robot = seven_axes();
    let effect = own(&robot, "balance", 1, "k*sin(q2 - q0)", COUNTERBALANCE, false);
    let logs = recordings(&robot, &[], &[(1, |s| 4.0 * (s[1][0] - 0.3).sin())], 41);
    let outcome = diagnosed(&robot, &logs, vec![effect], true);
    assert!(
        outcome.report.findings.iter().all(|f| f.effect == "balance"),
        "{:?}",
        names(&outcome)
    );
    assert!(outcome.report.rms_after.held_out.iter().all(|v| v.is_finite()));
}
