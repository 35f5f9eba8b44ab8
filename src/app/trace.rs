//! What the declared model leaves over, as the `residual` part of an answer: data faults first, then physics.

use super::identify::{ModelFiles, UsedLog};
use super::tell::tell;
use crate::dynamics::Motion;
use crate::io::log::{FindingKind, LogReport};
use crate::io::traced_value;
use crate::model::Robot;
use crate::residual::{
    AugmentedModel, DataFault, Evidence, FaultKind, Finding, Gravity, Mounting, Prior, Remedy, ReportedParameter, ResidualReport,
    RmsPair, Stretch, TraceOptions, Traced, column_faults, mounting, trace, trace_mounted,
};
use nalgebra::Vector3;
use serde_json::Value;

/// Traces the identification logs; the validation logs only measure.
///
/// Inverted torque signs are named and then undone, so that what else is there can be seen. With joints in another order, mixed-up units or a
/// column that was not recorded nothing physical can be said: the faults are all that comes back.
///
/// With `offsets` a torque offset of every joint belongs to the declared model. With an `existing` model the question is what has changed since it was made.
pub(super) fn residual(
    robot: &Robot,
    identification: &[UsedLog],
    validation: &[UsedLog],
    existing: Option<(AugmentedModel, Prior)>,
    offsets: bool,
) -> (Value, Traced) {
    let stretches = |logs: &[UsedLog]| logs.iter().filter_map(|l| l.stretch.clone()).collect::<Vec<_>>();
    let (mut measured, mut held_out) = (stretches(identification), stretches(validation));
    let mounted = match existing.is_none() {
        true => mounted(robot, identification),
        false => None,
    };
    let declared = robot;
    let corrected = mounted.map(|m| declared.with_gravity(m.gravity));
    let robot = corrected.as_ref().unwrap_or(declared);
    let faults = faults(robot, identification);
    let beyond_repair = faults.iter().any(|f| f.remedy == Remedy::Nothing);
    let options = TraceOptions {
        existing,
        offsets,
        ..TraceOptions::default()
    };
    let nothing_added = TraceOptions {
        most_effects_per_joint: 0,
        ..options.clone()
    };
    let as_recorded = match faults.is_empty() && mounted.is_none() {
        true => None,
        false => Some(trace(declared, &measured, &held_out, &nothing_added)),
    };
    for fault in faults.iter().filter(|f| f.fault == FaultKind::TorqueSign) {
        let joints = robot
            .joints()
            .iter()
            .enumerate()
            .filter(|(_, j)| fault.joints.contains(&j.name));
        for (j, _) in joints {
            measured.iter_mut().chain(&mut held_out).for_each(|s| invert(s, j));
        }
    }
    let options = if beyond_repair { &nothing_added } else { &options };
    let (traced, gravity) = match mounted {
        None => (trace(robot, &measured, &held_out, options), None),
        Some(_) => {
            let (traced, gravity) = trace_mounted(robot, &measured, &held_out, options);
            (traced, Some(gravity))
        }
    };
    let mut report = traced.report.clone();
    let mounting = gravity.map(|g| (mounting_fault(declared, &g), g));
    if let Some(before) = as_recorded {
        let first = mounting
            .iter()
            .map(|(fault, g)| gravity_finding(fault, g, &before.report, &report));
        let named = faults.iter().map(|f| fault_finding(f, &before.report, &report));
        report.findings = first.chain(named).chain(report.findings.iter().cloned()).collect();
    }
    report.data_faults = mounting.into_iter().map(|(fault, _)| fault).chain(faults).collect();
    let mut document = serde_json::to_value(&report).expect("plain numbers and words");
    tell(robot, &report, &mut document);
    (document, traced)
}

/// Where the logs say that gravity points, if that is another mounting than the declared one.
fn mounted(robot: &Robot, logs: &[UsedLog]) -> Option<Mounting> {
    let read: Vec<(&Motion, &[Vec<f64>])> = logs.iter().map(|l| (&*l.prepared.motion, &l.prepared.torque[..])).collect();
    // Positions in degrees or exchanged say nothing of gravity.
    let misread = logs.iter().any(|l| {
        let faults = column_faults(robot, &l.prepared.motion, &l.prepared.torque);
        faults.iter().any(|f| f.fault == FaultKind::UnitMismatch)
    });
    if misread { None } else { mounting(robot, &read) }
}

/// The direction as a fault of what was declared.
fn mounting_fault(declared: &Robot, gravity: &Gravity) -> DataFault {
    let vector = |v: Vector3<f64>| format!("[{}]", v.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join(", "));
    let angle = declared.gravity().angle(&gravity.value).to_degrees();
    DataFault {
        fault: FaultKind::GravityDirection,
        joints: Vec::new(),
        detail: format!(
            "gravity points along {} m/s² in the base frame, {angle:.0}° from the declared {}: the arm is mounted otherwise than its description says; \
             set `gravity` of the robot to that. Everything below is with that direction",
            vector(gravity.value),
            vector(declared.gravity())
        ),
        remedy: Remedy::Turn,
    }
}

/// The fault in the form of a finding, with the vector to use.
fn gravity_finding(fault: &DataFault, gravity: &Gravity, before: &ResidualReport, after: &ResidualReport) -> Finding {
    let component = |(i, axis): (usize, &str)| ReportedParameter {
        name: format!("gravity_{axis}"),
        value: gravity.value[i],
        unit: "m/s^2".into(),
        std_dev: gravity.std_dev[i],
    };
    Finding {
        parameters: ["x", "y", "z"].into_iter().enumerate().map(component).collect(),
        ..fault_finding(fault, before, after)
    }
}

/// Writes the effects found into the model files: all of it into the JSON, what a URDF cannot hold as a comment into that.
pub(super) fn add_effects(files: &mut ModelFiles, traced: &Traced) {
    let robot = &traced.model.robot;
    let not_held: Vec<String> = traced
        .model
        .terms
        .iter()
        .map(|term| {
            let joints: Vec<&str> = term.joints.iter().map(|&j| robot.joints()[j].name.as_str()).collect();
            let place = if joints.is_empty() {
                "the whole robot".to_string()
            } else {
                joints.join(", ")
            };
            let code = term.effect.code();
            format!("{code} on {place}: URDF has bodies, damping and friction, and no place for it; the JSON model has it")
        })
        .collect();
    if let Some(map) = files.json.as_object_mut() {
        map.insert("augmented".into(), traced_value(traced));
        map.insert("not_in_urdf".into(), not_held.clone().into());
    }
    if let Some(end) = files.urdf.find("?>").filter(|_| !not_held.is_empty()) {
        // Two hyphens would end the comment.
        let comment = not_held.join("\n     ").replace("--", "- -");
        files.urdf.insert_str(end + 2, &format!("\n<!-- {comment} -->"));
    }
}

fn invert(stretch: &mut Stretch, joint: usize) {
    let periods = stretch.periods.iter_mut().map(|p| &mut p[joint]);
    periods.chain([&mut stretch.torque[joint]]).flatten().for_each(|v| *v = -*v);
}

/// Faults of all logs, each kind and joint once.
fn faults(robot: &Robot, logs: &[UsedLog]) -> Vec<DataFault> {
    let mut all: Vec<DataFault> = Vec::new();
    for log in logs {
        let columns = column_faults(robot, &log.prepared.motion, &log.prepared.torque);
        for fault in recording_faults(&log.report)
            .into_iter()
            .chain(log.sample_faults.clone())
            .chain(columns)
        {
            if !all
                .iter()
                .any(|f| f.fault == fault.fault && f.joints == fault.joints && f.detail == fault.detail)
            {
                all.push(fault);
            }
        }
    }
    all
}

/// Irregularities of the file that mean something went wrong in recording; jitter and skipped samples are everyday.
fn recording_faults(report: &LogReport) -> Vec<DataFault> {
    let serious = [
        FindingKind::GarbageRow,
        FindingKind::RepeatedTime,
        FindingKind::TimeOutOfOrder,
        FindingKind::MissingTime,
        FindingKind::Gap,
    ];
    let found = report.findings.iter().filter(|f| serious.contains(&f.kind));
    found
        .map(|f| DataFault {
            fault: FaultKind::BadSamples,
            joints: Vec::new(),
            detail: format!("{}: {}", report.file, f.detail),
            remedy: Remedy::LeaveOut,
        })
        .collect()
}

/// A fault in the form of a finding: the error with the data as recorded, and after what could be undone.
fn fault_finding(fault: &DataFault, before: &ResidualReport, after: &ResidualReport) -> Finding {
    let undone = fault.remedy == Remedy::Turn;
    let rms = |report: &ResidualReport| RmsPair {
        ..report.rms_before.clone()
    };
    Finding {
        effect: fault.fault.code().to_string(),
        joints: fault.joints.clone(),
        parameters: Vec::new(),
        rms_before: rms(before),
        rms_after: rms(if undone { after } else { before }),
        evidence: Evidence {
            gain: 0.0,
            log_evidence_ratio: 0.0,
            p_value: 0.0,
            held_out_blocks: 0.0,
            held_out_periods: None,
        },
        rivals: Vec::new(),
        note: Some(fault.detail.clone()),
    }
}
