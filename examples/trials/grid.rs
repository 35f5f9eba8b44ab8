//! Logs with nothing in them, every effect at three sizes, and pairs: arms with random bodies on moderate motions.

use crate::bench::*;
use dynident::diagnosis::{Diagnosis, Verdict};
use dynident::model::Robot;
use dynident::simulate::{HiddenEffect, Noise};
use std::collections::BTreeMap;

/// What was found: codes with joints, or `nothing`, or `unexplained`.
pub fn found(outcome: &Diagnosis) -> Vec<String> {
    let mut list: Vec<String> = outcome
        .report
        .findings
        .iter()
        .map(|f| format!("{}:{}", f.effect, f.joints.join("+")))
        .collect();
    if let Some(rest) = &outcome.report.remainder {
        list.push(format!(
            "unexplained:{}({})",
            rest.joints.join("+"),
            rest.depends_on.join(",")
        ));
    }
    list
}

pub fn nothing(count: u64, first: u64) {
    let mut false_findings = 0;
    for seed in first..first + count {
        let robots = robots();
        let robot = &robots[(seed % 3) as usize];
        // Every second log with coloured noise, every fifth with jitter as well.
        let correlation = if seed % 2 == 1 { 0.7 } else { 0.0 };
        let jitter = if seed % 5 == 4 { 1e-4 } else { 0.0 };
        let noise = Noise {
            torque_correlation: correlation,
            jitter,
            ..sensor_noise(robot.joint_count())
        };
        let outcome = traced(robot, &[], &noise, 9000 + seed);
        let list = found(&outcome);
        if outcome.report.verdict != Verdict::NothingMissing {
            false_findings += 1;
            println!(
                "seed {seed} {} correlation {correlation} jitter {jitter}: {list:?}",
                robot.name()
            );
        }
    }
    println!("{false_findings} of {count} logs with nothing in them had a finding");
}

const SIZES: [f64; 3] = [0.15, 0.5, 1.5];

pub fn grid(only: &[String]) {
    let robot = seven_axes();
    let noise = sensor_noise(7);
    let mut confusion: BTreeMap<(String, String), usize> = BTreeMap::new();
    let mut right_at: BTreeMap<(String, usize), usize> = BTreeMap::new();
    let wanted = |code: &&&str| only.is_empty() || only.iter().any(|o| o == **code);
    for code in codes().iter().filter(wanted) {
        for (i, &size) in SIZES.iter().enumerate() {
            for joint in [1, 3, 5] {
                let hidden = effect(code, joint, size, &robot);
                let outcome = traced(
                    &robot,
                    std::slice::from_ref(&hidden),
                    &noise,
                    500 + joint as u64 * 10 + i as u64,
                );
                let list = found(&outcome);
                let named = list
                    .first()
                    .map_or("nothing", |f| f.split(':').next().unwrap_or(""))
                    .to_string();
                let right = list.len() == 1 && named == *code && on_joint(&list[0], &robot, &hidden);
                *right_at.entry((code.to_string(), i)).or_default() += usize::from(right);
                *confusion
                    .entry((code.to_string(), if list.len() > 1 { format!("{named}+more") } else { named }))
                    .or_default() += 1;
                let values: Vec<String> = outcome
                    .report
                    .findings
                    .iter()
                    .flat_map(|f| &f.parameters)
                    .take(4)
                    .map(|p| format!("{}={:.4}±{:.4}", p.name, p.value, p.std_dev))
                    .collect();
                println!(
                    "{} {hidden:?}: {list:?} {values:?}",
                    if right {
                        "right"
                    } else if list.is_empty() {
                        "missed"
                    } else {
                        "WRONG"
                    }
                );
            }
        }
    }
    println!("\n| effect | right of 3 at 0.15 | at 0.5 | at 1.5 |\n|---|---|---|---|");
    for code in codes().iter().filter(wanted) {
        let at = |i: usize| right_at[&(code.to_string(), i)];
        println!("| `{code}` | {} | {} | {} |", at(0), at(1), at(2));
    }
    println!("\nconfusion (in → named first: count)");
    confusion.iter().for_each(|((a, b), count)| println!("{a} -> {b}: {count}"));
}

/// Whether a finding names the joint the effect sits on.
fn on_joint(finding: &str, robot: &Robot, hidden: &HiddenEffect) -> bool {
    use HiddenEffect::*;
    let joint = match hidden {
        BaseTilt { .. } | TorqueDelay { .. } | Payload { .. } => return true,
        TorqueOffset { joint, .. }
        | StribeckFriction { joint, .. }
        | NonlinearViscousFriction { joint, .. }
        | AsymmetricViscousFriction { joint, .. }
        | LoadDependentFriction { joint, .. }
        | PreslidingHysteresis { joint, .. }
        | SmoothCoulombFriction { joint, .. }
        | RotorInertia { joint, .. }
        | JointSpring { joint, .. }
        | PositionRipple { joint, .. }
        | JointElasticity { joint, .. }
        | EncoderOffset { joint, .. }
        | TorqueGain { joint, .. }
        | TorqueCrosstalk { joint, .. }
        | FrictionDrift { joint, .. }
        | TorqueDrift { joint, .. } => *joint,
        TransmissionCoupling { joints, .. } | Unmodelled { joints, .. } => joints[0],
        Listed(listed) => listed.joints[0],
        ExternalContact { torque, .. } => torque.iter().position(|t| *t != 0.0).unwrap_or(0),
    };
    finding
        .split(':')
        .nth(1)
        .is_some_and(|joints| joints.starts_with(&robot.joints()[joint].name))
}

/// Values and evidence of everything found, and the lack of fit that stays.
fn explain(outcome: &Diagnosis) {
    for f in &outcome.report.findings {
        let values: Vec<String> = f
            .parameters
            .iter()
            .take(4)
            .map(|p| format!("{} = {:.4} ± {:.4}", p.name, p.value, p.std_dev))
            .collect();
        println!(
            "    {} on {}: evidence {:.1}, p {:.1e}, {}",
            f.effect,
            f.joints.join("+"),
            f.evidence.log_evidence_ratio,
            f.evidence.p_value,
            values.join(", ")
        );
    }
    let left: Vec<String> = outcome
        .report
        .lack_of_fit_after
        .iter()
        .map(|f| format!("{:.3}", f.statistic))
        .collect();
    println!("    lack of fit afterwards {}", left.join(" "));
}

pub fn pairs(count: u64, first: u64) {
    let robot = seven_axes();
    let noise = sensor_noise(7);
    let (all, mut right) = (codes(), 0);
    for k in first..first + count {
        let (a, b) = (all[(k * 5 % 16) as usize], all[((k * 7 + 3) % 16) as usize]);
        if a == b {
            continue;
        }
        let effects = [
            effect(a, 1 + (k % 3) as usize, 1.0, &robot),
            effect(b, 4 + (k % 2) as usize, 1.0, &robot),
        ];
        let outcome = traced(&robot, &effects, &noise, 700 + k);
        let list = found(&outcome);
        let both = list.len() == 2 && [a, b].iter().all(|c| list.iter().any(|f| f.starts_with(c)));
        right += usize::from(both);
        println!("{k} {} {a} with {b}: {list:?}", if both { "right" } else { "WRONG" });
        if !both {
            explain(&outcome);
        }
    }
    println!("{right} pairs right");
}

/// What hides on one joint: every effect of `only` (all, where empty) alone, and every pair of them.
fn alone_and_in_pairs(only: &[String]) -> Vec<Vec<&'static str>> {
    let wanted = |code: &&'static str| only.is_empty() || only.iter().any(|o| o == code);
    let all: Vec<&'static str> = codes().into_iter().filter(wanted).collect();
    let pairs = (0..all.len())
        .flat_map(|i| (0..i).map(move |k| (i, k)))
        .map(|(i, k)| vec![all[i], all[k]]);
    all.iter().map(|code| vec![*code]).chain(pairs).collect()
}

/// Effects on one joint, alone and in pairs, at `size`, on logs that `recorded` makes and traces: what is found instead where
/// not all are.
pub fn together(joint: usize, size: f64, only: &[String], recorded: impl Fn(&[HiddenEffect]) -> Diagnosis) {
    let robot = seven_axes();
    let (mut right, cases) = (0, alone_and_in_pairs(only));
    for hidden in &cases {
        let effects: Vec<HiddenEffect> = hidden.iter().map(|code| effect(code, joint, size, &robot)).collect();
        let started = std::time::Instant::now();
        let outcome = recorded(&effects);
        let list = found(&outcome);
        let all = list.len() == hidden.len() && hidden.iter().all(|c| list.iter().any(|f| f.starts_with(c)));
        right += usize::from(all);
        let word = if all { "right" } else { "WRONG" };
        println!(
            "{word} {}: {list:?} {:.1} s",
            hidden.join(" with "),
            started.elapsed().as_secs_f64()
        );
        if !all {
            explain(&outcome);
        }
    }
    println!("{right} of {} right", cases.len());
}

/// A log with periods of [`together`].
pub fn periodic(effects: &[HiddenEffect]) -> Diagnosis {
    traced(&seven_axes(), effects, &sensor_noise(7), 900)
}

/// A log without periods of [`together`].
pub fn single_run(effects: &[HiddenEffect]) -> Diagnosis {
    once(&seven_axes(), effects, &sensor_noise(7), 11)
}
