//! What was hidden, and whether it was found: effect and joint named, values within three standard deviations, held-out errors at
//! the noise, and nothing else named. The right one among the rivals counts half.

use crate::bench::noise_levels;
use dynident::diagnosis::{Diagnosis, Finding};
use dynident::effects::by_code;
use dynident::model::Robot;
use dynident::simulate::HiddenEffect;

/// What an answer has to say about a hidden effect.
pub struct Truth {
    pub code: &'static str,
    /// None for an effect of the whole robot.
    pub joints: Vec<usize>,
    pub values: Vec<(&'static str, f64)>,
}

pub fn truth(hidden: &HiddenEffect) -> Truth {
    use HiddenEffect::*;
    let (code, joints, values) = match hidden {
        Listed(listed) => {
            let code = by_code(&listed.code).expect("a listed effect").code();
            (code, listed.joints.clone(), Vec::new())
        }
        TorqueOffset { joint, offset } => ("torque_offset", vec![*joint], vec![("offset", *offset)]),
        StribeckFriction {
            joint,
            amplitude,
            velocity,
            ..
        } => (
            "stribeck_friction",
            vec![*joint],
            vec![("amplitude", *amplitude), ("velocity", *velocity)],
        ),
        NonlinearViscousFriction { joint, coefficient, .. } => (
            "nonlinear_viscous_friction",
            vec![*joint],
            vec![("coefficient", *coefficient)],
        ),
        AsymmetricViscousFriction { joint, coefficient } => (
            "asymmetric_viscous_friction",
            vec![*joint],
            vec![("coefficient", *coefficient)],
        ),
        LoadDependentFriction { joint, coefficient } => {
            ("load_dependent_friction", vec![*joint], vec![("coefficient", *coefficient)])
        }
        PreslidingHysteresis { joint, amplitude, width } => (
            "presliding_hysteresis",
            vec![*joint],
            vec![("amplitude", *amplitude), ("width", *width)],
        ),
        SmoothCoulombFriction {
            joint,
            amplitude,
            velocity,
        } => (
            "smooth_coulomb_friction",
            vec![*joint],
            vec![("amplitude", *amplitude), ("velocity", *velocity)],
        ),
        RotorInertia { joint, inertia } => ("rotor_inertia", vec![*joint], vec![("inertia", *inertia)]),
        TransmissionCoupling {
            joints,
            viscous,
            coulomb,
            inertia,
            ratio,
        } => (
            "transmission_coupling",
            joints.to_vec(),
            vec![
                ("viscous", *viscous),
                ("coulomb", *coulomb),
                ("inertia", *inertia),
                ("ratio", *ratio),
            ],
        ),
        JointSpring { joint, stiffness, rest } => (
            "joint_spring",
            vec![*joint],
            vec![("stiffness", *stiffness), ("rest_position", *rest)],
        ),
        PositionRipple {
            joint,
            amplitude,
            cycles,
            ..
        } => (
            "position_ripple",
            vec![*joint],
            vec![("amplitude", *amplitude), ("cycles", *cycles)],
        ),
        JointElasticity { joint, stiffness } => ("joint_elasticity", vec![*joint], vec![("compliance", 1.0 / stiffness)]),
        EncoderOffset { joint, offset } => ("encoder_offset", vec![*joint], vec![("offset", *offset)]),
        BaseTilt { roll, pitch } => ("base_tilt", vec![], vec![("roll", *roll), ("pitch", *pitch)]),
        Payload { mass, .. } => ("payload", vec![], vec![("mass", *mass)]),
        TorqueDelay { seconds } => ("torque_delay", vec![], vec![("delay", *seconds)]),
        TorqueGain { joint, gain } => ("torque_gain", vec![*joint], vec![("gain", *gain)]),
        TorqueCrosstalk {
            joint,
            from,
            coefficient,
        } => ("torque_crosstalk", vec![*joint, *from], vec![("coefficient", *coefficient)]),
        FrictionDrift {
            joint,
            viscous,
            coulomb,
            time_constant,
        } => (
            "friction_drift",
            vec![*joint],
            vec![
                ("viscous_change_over_log", -viscous * faded(*time_constant)),
                ("coulomb_change_over_log", -coulomb * faded(*time_constant)),
                ("time_constant", *time_constant),
            ],
        ),
        ExternalContact { start, end, torque } => (
            "external_contact",
            torque.iter().enumerate().filter(|t| *t.1 != 0.0).map(|t| t.0).collect(),
            vec![("start", *start), ("end", *end)],
        ),
        TorqueDrift { joint, .. } => ("unexplained", vec![*joint], vec![]),
        Unmodelled { joints, .. } => ("unexplained", joints.to_vec(), vec![]),
    };
    Truth { code, joints, values }
}

/// Share of a drift that is over by the end of the log: six periods of 10 s.
fn faded(time_constant: f64) -> f64 {
    1.0 - (-60.0 / time_constant).exp()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    Wrong,
    Half,
    Right,
}

/// Mark of the whole log, and why it is no better.
pub fn judge(outcome: &Diagnosis, hidden: &[HiddenEffect], robot: &Robot) -> (Mark, Vec<String>) {
    let (mut worst, mut reasons) = (Mark::Right, Vec::new());
    let mut open: Vec<&Finding> = outcome.report.findings.iter().collect();
    let mut unexplained = outcome.report.remainder.is_some();
    for hidden in hidden {
        let truth = truth(hidden);
        let (mark, reason) = if truth.code == "unexplained" {
            std::mem::take(&mut unexplained);
            remainder(outcome, &truth)
        } else {
            named(&mut open, &truth, robot)
        };
        worst = worst.min(mark);
        reasons.extend(reason);
    }
    for extra in open {
        worst = Mark::Wrong;
        reasons.push(format!("additional {}:{}", extra.effect, extra.joints.join("+")));
    }
    if unexplained {
        worst = Mark::Wrong;
        reasons.push("additional remainder".into());
    }
    if let Some(reason) = held_out(outcome, hidden) {
        worst = Mark::Wrong;
        reasons.push(reason);
    }
    (worst, reasons)
}

fn same_place(effect: &str, joints: &[String], truth: &Truth, robot: &Robot) -> bool {
    let wanted: Vec<&str> = truth.joints.iter().map(|&j| robot.joints()[j].name.as_str()).collect();
    let place = match truth.code {
        "external_contact" => wanted.iter().all(|w| joints.iter().any(|j| j == w)),
        _ => wanted.is_empty() || joints == wanted,
    };
    effect == truth.code && place
}

/// Takes the finding that names the effect, or that has it among its rivals, out of `open`.
fn named(open: &mut Vec<&Finding>, truth: &Truth, robot: &Robot) -> (Mark, Option<String>) {
    if let Some(at) = open.iter().position(|f| same_place(&f.effect, &f.joints, truth, robot)) {
        let found = open.remove(at);
        return match off(found, truth) {
            Some(reason) => (Mark::Wrong, Some(reason)),
            None => (Mark::Right, None),
        };
    }
    let rival = |f: &&Finding| f.rivals.iter().any(|r| same_place(&r.effect, &r.joints, truth, robot));
    if let Some(at) = open.iter().position(rival) {
        let found = open.remove(at);
        return (Mark::Half, Some(format!("{} as a rival of {}", truth.code, found.effect)));
    }
    (Mark::Wrong, Some(format!("{} missed", truth.code)))
}

/// A value further off than three of its own standard deviations.
fn off(found: &Finding, truth: &Truth) -> Option<String> {
    let wrong = truth.values.iter().filter_map(|(name, value)| {
        let p = found.parameters.iter().find(|p| p.name == *name)?;
        let sigmas = (p.value - value).abs() / p.std_dev;
        (sigmas.is_nan() || sigmas > 3.0)
            .then(|| format!("{} {name} {:.4} ± {:.4} for {value:.4}", truth.code, p.value, p.std_dev))
    });
    let said: Vec<String> = wrong.collect();
    (!said.is_empty()).then(|| said.join(", "))
}

fn remainder(outcome: &Diagnosis, truth: &Truth) -> (Mark, Option<String>) {
    let Some(rest) = &outcome.report.remainder else {
        return (Mark::Wrong, Some("unexplained missed".into()));
    };
    // What goes with the motion goes with the positions of two joints, what does not with time.
    let mut wanted: Vec<String> = match truth.joints.len() {
        1 => vec!["time".into()],
        _ => truth.joints.iter().map(|j| format!("q{}", j + 1)).collect(),
    };
    let mut have = rest.depends_on.clone();
    wanted.sort();
    have.sort();
    match wanted == have {
        true => (Mark::Right, None),
        false => (Mark::Wrong, Some(format!("depends on {have:?}, not {wanted:?}"))),
    }
}

/// Whether the held-out error of a joint stays more than a tenth above its noise. What is not explained stays; a contact is over,
/// and a drift begins again with every log.
fn held_out(outcome: &Diagnosis, hidden: &[HiddenEffect]) -> Option<String> {
    let stays = |h: &HiddenEffect| {
        matches!(
            h,
            HiddenEffect::Unmodelled { .. }
                | HiddenEffect::TorqueDrift { .. }
                | HiddenEffect::FrictionDrift { .. }
                | HiddenEffect::ExternalContact { .. }
        )
    };
    let after = &outcome.report.rms_after.held_out;
    let noise = noise_levels(after.len());
    let above: Vec<String> = after
        .iter()
        .zip(&noise)
        .enumerate()
        .filter(|(_, (rms, noise))| **rms > 1.1 * **noise)
        .map(|(j, (rms, noise))| format!("held out joint {} {rms:.3} for {noise:.3}", j + 1))
        .collect();
    (!above.is_empty() && !hidden.iter().any(stays)).then(|| above.join(", "))
}

/// Findings in a few words.
pub fn outcome_text(outcome: &Diagnosis) -> String {
    let value = |p: &dynident::diagnosis::ReportedParameter| format!("{} {:.4} ± {:.4}", p.name, p.value, p.std_dev);
    let finding = |f: &Finding| {
        let values: Vec<String> = f.parameters.iter().take(4).map(value).collect();
        let rivals: Vec<String> = f
            .rivals
            .iter()
            .map(|r| format!("{}:{} {:.1}", r.effect, r.joints.join("+"), r.evidence))
            .collect();
        let place = if f.joints.len() < 4 {
            f.joints.join("+")
        } else {
            "all".into()
        };
        format!(
            "{}:{place} [{}] evidence {:.0}{}",
            f.effect,
            values.join(", "),
            f.evidence.log_evidence_ratio,
            if rivals.is_empty() {
                String::new()
            } else {
                format!(" rivals {}", rivals.join(" "))
            }
        )
    };
    let mut all: Vec<String> = outcome.report.findings.iter().map(finding).collect();
    if let Some(rest) = &outcome.report.remainder {
        all.push(format!(
            "unexplained:{} ({})",
            rest.joints.join("+"),
            rest.depends_on.join(",")
        ));
    }
    if all.is_empty() { "nothing".into() } else { all.join("; ") }
}
