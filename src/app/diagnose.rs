//! The diagnosis as the `residual` part of an answer, and what is done about faults of the data.

use super::CancelFlag;
use super::identify::UsedLog;
use crate::diagnosis::{
    DataFault, FaultKind, Gravity, Mounting, Remedy, ReportedParameter, ResidualReport, Verdict, column_faults_until,
    mounting_until,
};
use crate::dynamics::Motion;
use crate::formats::logs::{FindingKind, LogReport};
use crate::model::Robot;
use crate::preparation::Exclusion;
use nalgebra::Vector3;

/// With joints in another order, mixed-up units or a column that was not recorded nothing physical can be said: the faults are
/// all that is reported.
pub(super) fn beyond_repair(faults: &[DataFault]) -> bool {
    faults.iter().any(|f| f.remedy == Remedy::Nothing)
}

/// Puts the faults of the data into the report. Beyond repair the search was not made, and that it found nothing does not say
/// that nothing is missing.
pub(super) fn report_faults(report: &mut ResidualReport, faults: Vec<DataFault>) {
    if beyond_repair(&faults) {
        report.verdict = Verdict::Unexplained;
    }
    report.data_faults.splice(..0, faults);
}

/// Where the logs say that gravity points, if that is another mounting than the declared one.
pub(super) fn mounted(robot: &Robot, logs: &[UsedLog], cancel: &CancelFlag) -> Option<Mounting> {
    let read: Vec<(&Motion, &[Vec<f64>])> = logs.iter().map(|l| (&*l.prepared.motion, &l.prepared.torque[..])).collect();
    // Positions in degrees, and torques without gravity or in other units, say nothing of its direction; a missing torque column
    // leaves too little of an arm to accuse its mounting.
    let misread = logs.iter().any(|l| {
        cancel.leave_if_set();
        if l.prepared.excluded.iter().flatten().any(|e| *e != Exclusion::Still) {
            return true;
        }
        let faults = column_faults_until(robot, &l.prepared.motion, &l.prepared.torque, cancel);
        let other_torques = [
            FaultKind::UnitMismatch,
            FaultKind::UnitUnknown,
            FaultKind::GravityCompensatedTorque,
        ];
        faults.iter().any(|f| other_torques.contains(&f.fault))
    });
    if misread { None } else { mounting_until(robot, &read, cancel) }
}

/// The direction as a fault of what was declared, with the vector to use.
pub(super) fn mounting_fault(declared: &Robot, gravity: &Gravity) -> DataFault {
    let vector = |v: Vector3<f64>| format!("[{}]", v.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join(", "));
    let angle = declared.gravity().angle(&gravity.value).to_degrees();
    let component = |(i, axis): (usize, &str)| ReportedParameter {
        name: format!("gravity_{axis}"),
        value: gravity.value[i],
        unit: "m/s^2".into(),
        std_dev: gravity.std_dev[i],
    };
    DataFault {
        fault: FaultKind::GravityDirection,
        joints: Vec::new(),
        detail: format!(
            "gravity points along {} m/s² in the base frame, {angle:.0}° from the declared {}: the arm is mounted otherwise than its description says{}",
            vector(gravity.value),
            vector(declared.gravity()),
            if gravity.is_all_seen {
                ""
            } else {
                "; what this arm does not show of the direction is as declared"
            }
        ),
        remedy: Remedy::Reorient,
        parameters: ["x", "y", "z"].into_iter().enumerate().map(component).collect(),
    }
}

/// Faults of all logs, each kind and joint once.
pub(super) fn data_faults(robot: &Robot, logs: &[UsedLog], cancel: &CancelFlag) -> Vec<DataFault> {
    let mut all: Vec<DataFault> = Vec::new();
    for log in logs {
        cancel.leave_if_set();
        let columns = column_faults_until(robot, &log.prepared.motion, &log.prepared.torque, cancel);
        // What concerns all of a joint's torque comes first.
        for fault in log
            .sample_faults
            .clone()
            .into_iter()
            .chain(recording_faults(&log.report))
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
        FindingKind::ImplausibleValue,
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
            parameters: Vec::new(),
        })
        .collect()
}
