//! Laws: formulas for what no listed effect explains.

use crate::bench::*;
use dynident::diagnosis::{Diagnosis, DiagnosisOptions, Finding, Verdict, diagnose};
use dynident::documents::{Cursor, Findings, augmented_value, read_augmented};
use dynident::formats::logs::{ChannelColumn, Columns, read_log_file};
use dynident::formats::{Parsed, parse};
use dynident::model::Robot;
use dynident::preparation::{PreprocessOptions, prepare};
use dynident::regression::Stretch;
use dynident::simulate::{HiddenEffect, Noise};
use dynident::trajectory::Trajectory;
use std::path::{Path, PathBuf};

/// The folder of the virtual logs, beside that of the measured ones.
fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("DYNIDENT_REAL_DATA")
        .map(|p| PathBuf::from(p).join(".."))
        .filter(|p| p.join("laws").is_dir());
    if folder.is_none() {
        eprintln!("{test} skipped: DYNIDENT_REAL_DATA names no folder that `laws` stands beside");
    }
    folder
}

fn read(robot: &Robot, file: &Path, columns: &Columns) -> Stretch {
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let (log, _) = read_log_file(file, columns, &names).unwrap();
    let prepared = prepare(&log, robot.joint_count(), &PreprocessOptions::default()).unwrap();
    Stretch::new(&prepared, &log)
}

fn public(case: &Path, columns: &Columns) -> Diagnosis {
    let (robot, _) = published();
    let [own, held_out] = ["identify.csv.gz", "validate.csv.gz"].map(|f| read(&robot, &case.join(f), columns));
    diagnose(&robot, &[own], &[held_out], &DiagnosisOptions::default())
}

/// `A1: k*(q1 + r*q3)`.
fn described(f: &Finding) -> String {
    let formula = f.formula.as_ref().map(|formula| {
        let torques = formula.torques.iter().zip(&f.joints);
        torques
            .map(|((_, text), joint)| format!("{joint}: {text}"))
            .collect::<Vec<_>>()
            .join(", ")
    });
    let values: Vec<String> = f
        .parameters
        .iter()
        .map(|p| format!("{} = {:.4} ± {:.4} {}", p.name, p.value, p.std_dev, p.unit))
        .collect();
    format!(
        "{} on {:?} {} [{}]",
        f.effect,
        f.joints,
        formula.unwrap_or_default(),
        values.join(", ")
    )
}

/// Viscous friction that falls with the temperature of the gear: the law in the channel, with its constants, down to the noise on
/// another log. Without the channel the same log has a drift, and no more.
#[test]
fn val_friction_that_follows_a_temperature_is_a_law_in_it() {
    let Some(data) = folder("val_friction_that_follows_a_temperature_is_a_law_in_it") else {
        return;
    };
    let columns = Columns {
        channels: vec![ChannelColumn {
            name: "temperature".into(),
            header: "temperature".into(),
            unit: "degC".into(),
        }],
        ..Columns::default()
    };
    let report = public(&data.join("laws/temperature"), &columns).report;
    let all: Vec<String> = report.findings.iter().map(described).collect();
    println!("{all:?} {:?} floor {:?}", report.rms_after.held_out, report.noise_floor);
    let [finding] = &report.findings[..] else { panic!("{all:?}") };
    assert_eq!(finding.effect, "law_temperature_viscous_friction_exponential", "{all:?}");
    assert_eq!(finding.joints, ["A2"]);
    assert!(finding.in_model && report.verdict == Verdict::Explained);
    let formula = &finding.formula.as_ref().unwrap().torques[0].1;
    assert_eq!(formula, "k*exp(-(temperature - 22)/c)*qd2");
    for (name, truth) in [("k", 0.9), ("c", 14.0)] {
        let p = finding.parameters.iter().find(|p| p.name == name).unwrap();
        assert!((p.value - truth).abs() < 3.0 * p.std_dev, "{p:?}");
    }
    for (rms, floor) in report.rms_after.held_out.iter().zip(&report.noise_floor) {
        assert!(*rms < 1.1 * floor, "{rms} {floor}");
    }
    let without = public(&data.join("laws/temperature"), &Columns::default()).report;
    let effects: Vec<&str> = without.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(effects, ["friction_drift"]);
}

/// What was found in every public log; run with `--nocapture`.
#[test]
#[ignore = "prints a table"]
fn table_of_the_public_logs() {
    let Some(data) = folder("table_of_the_public_logs") else {
        return;
    };
    let only = std::env::var("CASE").unwrap_or_default();
    for case in [
        "laws/cable",
        "virtual/unknown",
        "laws/counterbalance",
        "laws/eccentric_coulomb",
        "laws/shared_seal",
    ] {
        if !case.contains(&only) {
            continue;
        }
        let start = std::time::Instant::now();
        let report = public(&data.join(case), &Columns::default()).report;
        println!("{case}: {:?} in {:.1} s", report.verdict, start.elapsed().as_secs_f64());
        for f in &report.findings {
            println!(
                "  {} evidence {:.0}, in model {}",
                described(f),
                f.evidence.log_evidence_ratio,
                f.in_model
            );
            for r in &f.rivals {
                println!(
                    "    rival {} on {:?} {:?}: {:.1}",
                    r.effect,
                    r.joints,
                    r.formula.as_ref().map(|f| &f.torques),
                    r.evidence
                );
            }
        }
        if let Some(rest) = &report.remainder {
            println!("  remainder {rest:?}");
        }
        println!(
            "  held out {:.3?} -> {:.3?} floor {:.3?}",
            report.rms_before.held_out, report.rms_after.held_out, report.noise_floor
        );
    }
}

/// Torques, by joint, from `[q, qd]` of all joints.
type Torque = Box<dyn Fn(&[[f64; 2]]) -> Vec<(usize, f64)>>;

/// A law as nature has it: torques of the joints from `[q, qd]` of all, written apart from the library.
struct Nature {
    name: &'static str,
    /// Joints that it acts on.
    acts_on: Vec<usize>,
    torque: Torque,
    /// What names it right: the formula on the first joint, without its constants; empty for a law that no form has.
    formula: String,
}

/// Fourteen laws on joints `j < m`, at `size` times a torque of `level`; the last three are in no form of the library.
fn natures(j: usize, m: usize, level: f64) -> Vec<Nature> {
    let law = |name, acts_on: &[usize], formula: String, torque: Torque| Nature {
        name,
        acts_on: acts_on.to_vec(),
        torque,
        formula,
    };
    let (a, b) = (j + 1, m + 1);
    let both = [j, m];
    vec![
        law(
            "hose over two joints",
            &both,
            format!("k*(q{a} + r*q{b})"),
            Box::new(move |s| {
                let f = 0.8 * level * (s[j][0] + 0.7 * s[m][0]);
                vec![(j, f), (m, 0.7 * f)]
            }),
        ),
        law(
            "wave of a sum",
            &both,
            format!("a*cos(q{a} + q{b})"),
            Box::new(move |s| {
                let f = level * (s[j][0] + s[m][0]).cos();
                vec![(j, f), (m, f)]
            }),
        ),
        law(
            "bilinear energy",
            &both,
            format!("k*q{b}"),
            Box::new(move |s| vec![(j, 1.2 * level * s[m][0]), (m, 1.2 * level * s[j][0])]),
        ),
        law(
            "pin spring",
            &[m],
            format!("a*sin(q{b} + phi) + b*sin(q{b} + phi)/sqrt(1 - rho*cos(q{b} + phi))"),
            Box::new(move |s| {
                let u = s[m][0] + 0.4;
                vec![(
                    m,
                    12.0 * level * u.sin() - 7.0 * level * u.sin() / (1.0 - 0.85 * u.cos()).sqrt(),
                )]
            }),
        ),
        law(
            "eccentric friction",
            &[m],
            format!("a*cos(q{b})*sign(qd{b})"),
            Box::new(move |s| vec![(m, 0.8 * level * s[m][0].cos() * s[m][1].signum())]),
        ),
        law(
            "shared seal",
            &[j],
            format!("c*qd{b}"),
            Box::new(move |s| vec![(j, 0.6 * level * s[m][1])]),
        ),
        law(
            "viscous over position",
            &[m],
            format!("a*q{b}^2*qd{b}"),
            Box::new(move |s| vec![(m, 1.2 * level * s[m][0] * s[m][0] * s[m][1])]),
        ),
        law(
            "seal on a sum",
            &both,
            format!("c*(qd{a} + r*qd{b})"),
            Box::new(move |s| {
                let f = 0.6 * level * (s[j][1] - 0.8 * s[m][1]);
                vec![(j, f), (m, -0.8 * f)]
            }),
        ),
        law(
            "hardening hose",
            &[m],
            format!("a*q{b}^3"),
            Box::new(move |s| vec![(m, 1.5 * level * s[m][0].powi(3))]),
        ),
        law(
            "soft stop",
            &[m],
            format!("a*exp((q{b} - s)/c)"),
            Box::new(move |s| vec![(m, 0.4 * level * (2.5 * s[m][0]).exp())]),
        ),
        law(
            "saturating hose",
            &both,
            format!("a*tanh((q{a} + r*q{b})/c)"),
            Box::new(move |s| {
                let f = level * (2.0 * (s[j][0] - s[m][0])).tanh();
                vec![(j, f), (m, -f)]
            }),
        ),
        law(
            "bump",
            &[m],
            String::new(),
            Box::new(move |s| vec![(m, 1.2 * level * (-((s[m][0] - 0.1) / 0.15).powi(2)).exp())]),
        ),
        law(
            "product with a root",
            &[j],
            String::new(),
            Box::new(move |s| vec![(j, 1.2 * level * s[m][0].abs().sqrt() * (2.0 * s[j][0]).sin())]),
        ),
        law(
            "product of waves",
            &[j],
            String::new(),
            Box::new(move |s| vec![(j, 1.5 * level * (2.0 * s[j][0]).sin() * (3.0 * s[m][0]).cos())]),
        ),
    ]
}

/// The tracing of logs with a law in them.
fn with_law(robot: &Robot, hidden: &[HiddenEffect], law: Option<&Nature>, noise: &Noise, seed: u64) -> Diagnosis {
    let n = robot.joint_count();
    let mut both = logs(robot, hidden, noise, seed);
    let motions: [Box<dyn Trajectory>; 2] = [Box::new(excitation(n, seed)), Box::new(validation(n, seed))];
    for (log, motion) in both.iter_mut().zip(&motions) {
        for (s, t) in log.time.iter().enumerate() {
            let state = |j| {
                let [q, v, _] = motion.state(j, t.rem_euclid(motion.duration()));
                [q, v]
            };
            let states: Vec<[f64; 2]> = (0..n).map(state).collect();
            for (j, torque) in law.map_or(Vec::new(), |law| (law.torque)(&states)) {
                log.tau[j][s] += torque;
            }
        }
    }
    let [identify, validate] = both;
    let held_out = [stretch(&validate, "validate")];
    diagnose(
        robot,
        &[stretch(&identify, "identify")],
        &held_out,
        &DiagnosisOptions::default(),
    )
}

/// What came of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// The formula.
    Correct,
    /// Another formula, or listed effects, with a held-out error at the noise floor on its joints.
    Equivalent,
    /// Not named, and the remainder says so.
    Described,
    /// Not seen at all.
    Missed,
    /// Something else is named, and the error stays.
    Wrong,
}

fn outcome(robot: &Robot, law: &Nature, diagnosis: &Diagnosis) -> Outcome {
    let report = &diagnosis.report;
    let named = |f: &&Finding| f.in_model && f.formula.as_ref().is_some_and(|formula| formula.torques[0].1 == law.formula);
    if report.findings.iter().any(|f| named(&f)) {
        return Outcome::Correct;
    }
    let open = |&&j: &&usize| report.rms_after.held_out[j] > 1.05 * report.noise_floor[j];
    let joints: Vec<&String> = law.acts_on.iter().map(|&j| &robot.joints()[j].name).collect();
    let touched = report
        .findings
        .iter()
        .any(|f| f.in_model && f.joints.iter().any(|j| joints.contains(&j)));
    let rest = report
        .remainder
        .as_ref()
        .is_some_and(|r| r.joints.iter().any(|j| joints.contains(&j)));
    match (touched, rest, law.acts_on.iter().any(|j| open(&j))) {
        (true, false, false) => Outcome::Equivalent,
        (false, true, _) => Outcome::Described,
        (false, false, _) => Outcome::Missed,
        _ => Outcome::Wrong,
    }
}

fn constant(f: &Finding, name: &str, truth: f64) {
    let p = f
        .parameters
        .iter()
        .find(|p| p.name == name)
        .unwrap_or_else(|| panic!("{}", described(f)));
    // Four standard deviations: one in 16 000 by chance.
    assert!((p.value - truth).abs() < 4.0 * p.std_dev, "{truth}: {}", described(f));
}

/// The only law among the findings, at the noise floor on all joints.
fn only_law<'a>(diagnosis: &'a Diagnosis, law: &Nature) -> &'a Finding {
    let report = &diagnosis.report;
    let all: Vec<String> = report.findings.iter().map(described).collect();
    let laws: Vec<&Finding> = report.findings.iter().filter(|f| f.effect == "law").collect();
    assert_eq!(laws.len(), 1, "{}: {all:?} {:?}", law.name, report.remainder);
    let formula = laws[0].formula.as_ref().unwrap();
    assert_eq!(formula.torques[0].1, law.formula, "{all:?}");
    assert_eq!(
        formula.torques.iter().map(|t| t.0).collect::<Vec<_>>(),
        law.acts_on,
        "{all:?}"
    );
    assert!(
        laws[0].in_model && report.verdict == Verdict::Explained,
        "{all:?} {:?}",
        report.remainder
    );
    for (rms, floor) in report.rms_after.held_out.iter().zip(&report.noise_floor) {
        assert!(*rms < 1.1 * floor, "held out {rms} above the floor {floor}: {all:?}");
    }
    laws[0]
}

#[test]
fn prop_a_hose_over_two_joints_is_one_law_with_one_stiffness_and_its_energy() {
    let robot = six_axes();
    let law = &natures(1, 3, 1.0)[0];
    let diagnosis = with_law(&robot, &[], Some(law), &sensor_noise(6), 41);
    let found = only_law(&diagnosis, law);
    assert_eq!(found.formula.as_ref().unwrap().energy.as_deref(), Some("0.5*k*(q2 + r*q4)^2"));
    constant(found, "k", 0.8);
    constant(found, "r", 0.7);
    assert_eq!(found.joints, ["J2", "J4"]);
    assert_eq!(
        found.covered.iter().map(|c| c.variable.as_str()).collect::<Vec<_>>(),
        ["q2", "q4"]
    );
}

#[test]
fn prop_a_law_is_found_beside_two_effects() {
    let robot = seven_axes();
    let law = &natures(1, 4, 1.0)[4];
    let hidden = [
        HiddenEffect::TorqueOffset { joint: 2, offset: 0.4 },
        HiddenEffect::JointSpring {
            joint: 3,
            stiffness: 1.8,
            rest: 0.2,
        },
    ];
    let diagnosis = with_law(&robot, &hidden, Some(law), &sensor_noise(7), 43);
    let found = only_law(&diagnosis, law);
    constant(found, "a", 0.8);
    let others: Vec<&str> = diagnosis
        .report
        .findings
        .iter()
        .map(|f| f.effect.as_str())
        .filter(|e| *e != "law")
        .collect();
    assert_eq!(others.len(), 2, "{others:?}");
    assert!(
        others.contains(&"torque_offset") && others.contains(&"joint_spring"),
        "{others:?}"
    );
}

/// The model with the law predicts the same after it has been written and read.
#[test]
fn prop_a_model_with_a_law_is_the_same_after_writing_and_reading() {
    let robot = four_axes();
    let law = &natures(1, 3, 1.0)[1];
    let diagnosis = with_law(&robot, &[], Some(law), &sensor_noise(4), 44);
    only_law(&diagnosis, law);
    let text = augmented_value(&diagnosis.model, &diagnosis.information).to_string();
    assert!(text.contains(r#""expression":"a*cos(q2 + q4)""#), "{text}");
    let findings = Findings::default();
    let Parsed { value, .. } = parse(text.as_bytes()).unwrap();
    let (model, _) = read_augmented(&Cursor::root(&value, &findings), &robot).unwrap();
    assert!(findings.into_list().is_empty());
    let along = Stretch::of_motion(excitation(4, 9).sample(50.0), 0.02, true);
    assert_eq!(model.predict(&along), diagnosis.model.predict(&along));
}

/// What no form has is no law: the remainder says what it depends on, as ever.
#[test]
fn prop_what_no_formula_explains_is_described() {
    let robot = seven_axes();
    let law = &natures(1, 4, 1.0)[13];
    let diagnosis = with_law(&robot, &[], Some(law), &sensor_noise(7), 45);
    let report = &diagnosis.report;
    assert!(
        report.findings.iter().all(|f| f.effect != "law"),
        "{:?}",
        report.findings.iter().map(described).collect::<Vec<_>>()
    );
    let rest = report.remainder.as_ref().expect("something is left");
    assert_eq!(rest.joints, ["J2"]);
}

/// Laws by size, on two arms and `DYNIDENT_LAW_SEEDS` seeds (one): correct, equivalent, described, missed, wrong. Run as
/// `cargo test --release --test effects -- --ignored --nocapture table_of_generated_laws`.
#[test]
#[ignore = "prints a table; 5 s for every law"]
fn table_of_generated_laws() {
    let seeds: u64 = std::env::var("DYNIDENT_LAW_SEEDS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(1);
    let only = std::env::var("CASE").unwrap_or_default();
    let arms = [seven_axes(), six_axes()];
    for kind in 0..natures(1, 3, 1.0).len() {
        let name = natures(1, 3, 1.0)[kind].name;
        if !name.contains(&only) {
            continue;
        }
        for size in [0.3, 1.0, 3.0] {
            let mut counts = std::collections::BTreeMap::new();
            for (a, robot) in arms.iter().enumerate() {
                for seed in 0..seeds {
                    let n = robot.joint_count();
                    let (j, m) = (1 + (seed as usize + a) % 2, 3 + (seed as usize + a) % (n - 3));
                    let noise = sensor_noise(n);
                    let law = &natures(j, m, size * noise_levels(n)[m] / 0.2)[kind];
                    let diagnosis = with_law(robot, &[], Some(law), &noise, 7000 + 10 * kind as u64 + seed);
                    let out = outcome(robot, law, &diagnosis);
                    *counts.entry(out).or_insert(0) += 1;
                    let found: Vec<String> = diagnosis.report.findings.iter().map(described).collect();
                    if out != Outcome::Correct {
                        println!(
                            "    {name} on {j}, {m} of {}: {out:?} {found:?} {:?}",
                            robot.name(),
                            diagnosis.report.remainder.as_ref().map(|r| &r.depends_on)
                        );
                    }
                }
            }
            println!("{name} at {size}: {counts:?}");
        }
    }
}

/// Logs with nothing in them, on several robots, in white and coloured noise: how many have a law.
fn laws_on_empty_logs(count: u64) -> Vec<String> {
    let mut found = Vec::new();
    for (i, robot) in (0..count).zip(robots().iter().cycle()) {
        let noise = Noise {
            torque_correlation: [0.0, 0.7][(i / 3 % 2) as usize],
            ..sensor_noise(robot.joint_count())
        };
        let report = traced(robot, &[], &noise, 9000 + i).report;
        found.extend(
            report
                .findings
                .iter()
                .map(|f| format!("{i} {}: {}", robot.name(), described(f))),
        );
    }
    found
}

/// `DYNIDENT_EMPTY_LOGS` of them (forty).
#[test]
#[ignore = "takes minutes"]
fn table_of_empty_logs() {
    let count = std::env::var("DYNIDENT_EMPTY_LOGS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(40);
    let found = laws_on_empty_logs(count);
    println!("{} findings on {count} empty logs: {found:#?}", found.len());
    assert!(found.iter().filter(|f| f.contains("law on")).count() as u64 <= count / 200);
}
