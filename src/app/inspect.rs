//! What is understood of logs, before anything is estimated.

use super::identify::{Companions, split_companions};
use super::{CancelFlag, Code, Error, LogFile};
use crate::diagnosis::{DataFault, RawLog, column_faults_until, sample_faults};
use crate::documents::{FindingDocument, IdentifyRequest, InspectDocument, InspectedJoint, InspectedLog, LogDocument};
use crate::formats::logs::{found_columns, read_joined_log_until};
use crate::model::Joint;
use crate::preparation::{Log, PreparedLog, keep_peaks, prepare_until};

/// Points of every series: as many as a small plot shows.
const POINTS: usize = 600;

/// Reads and prepares the logs of a request; `None` where `cancel` was set meanwhile.
///
/// # Errors
/// `invalid_log` with what is wrong with which file.
pub fn inspect(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
) -> Result<Option<InspectDocument>, Error> {
    if logs.is_empty() && validation.is_empty() {
        let error = Error::new(Code::InvalidLog, "there is no log to look at");
        return Err(error.with_hint("send at least one part called `log`"));
    }
    let kinds = [(logs, "identification"), (validation, "validation")];
    let all = || {
        let of_kind = |(files, role)| -> Result<Vec<InspectedLog>, Error> {
            let (logs, beside) = split_companions(&request.columns, files)?;
            logs.iter().map(|log| one(request, log, &beside, role, cancel)).collect()
        };
        kinds.into_iter().map(of_kind).collect::<Result<Vec<_>, _>>()
    };
    let Ok(seen) = CancelFlag::run(all) else {
        return Ok(None);
    };
    let seen = seen?;
    Ok(Some(InspectDocument {
        robot: request.robot.name().to_string(),
        logs: seen.concat(),
        notes: request.notes.clone(),
    }))
}

fn one(
    request: &IdentifyRequest,
    file: &LogFile,
    beside: &Companions,
    role: &'static str,
    cancel: &CancelFlag,
) -> Result<InspectedLog, Error> {
    let robot = &request.robot;
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let invalid = |e: String| Error::new(Code::InvalidLog, e);
    let columns = found_columns(&file.path, &file.name, beside, &request.columns, &names).map_err(|e| invalid(e.to_string()))?;
    let (mut log, mut report) = read_joined_log_until(&file.path, beside, &request.columns, &names, cancel)
        .map_err(|e| invalid(e.named(&file.name).to_string()))?;
    log.name.clone_from(&file.name);
    report.file.clone_from(&file.name);
    let prepared = prepare_until(&log, names.len(), &request.preprocess, cancel).map_err(|e| invalid(e.to_string()))?;
    let joints = robot
        .joints()
        .iter()
        .enumerate()
        .map(|(j, joint)| inspected(joint, j, &log, &prepared))
        .collect();
    let raw = RawLog {
        time: Vec::new(),
        q: log.q,
        tau: log.tau,
    };
    let faults =
        sample_faults(robot, &raw)
            .into_iter()
            .chain(column_faults_until(robot, &prepared.motion, &prepared.torque, cancel));
    Ok(InspectedLog {
        log: LogDocument::new(&report, role, &prepared.choices),
        columns,
        period_s: prepared.periods.as_ref().map(|p| p.period_s),
        periods: prepared.periods.as_ref().map_or(0, |p| p.count),
        faults: faults.map(fault).collect(),
        joints,
    })
}

fn fault(fault: DataFault) -> FindingDocument {
    FindingDocument {
        code: fault.fault.code().into(),
        count: fault.joints.len().max(1),
        lines: Vec::new(),
        detail: fault.detail,
    }
}

fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| {
        [low.min(v), high.max(v)]
    })
}

fn inspected(joint: &Joint, j: usize, log: &Log, prepared: &PreparedLog) -> InspectedJoint {
    let (q, tau) = (&log.q[j], &log.tau[j]);
    let picked = keep_peaks(&[q, tau], POINTS);
    let position_range = range(q);
    let travel = position_range[1] - position_range[0];
    InspectedJoint {
        joint: joint.name.clone(),
        position_unit: joint.position_unit(),
        effort_unit: joint.effort_unit(),
        position_range,
        range_used: joint.limits.position.map(|[low, high]| travel / (high - low)),
        top_speed: prepared.motion.velocities(j).iter().fold(0.0f64, |a, v| a.max(v.abs())),
        torque_range: range(tau),
        time: picked.iter().map(|&s| log.start_s + s as f64 / log.rate_hz).collect(),
        position: picked.iter().map(|&s| q[s]).collect(),
        torque: picked.iter().map(|&s| tau[s]).collect(),
    }
}
