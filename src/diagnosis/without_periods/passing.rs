//! What comes once: stretches of a log over which a joint's residual is far from all the rest of it, as where somebody touched
//! the arm. Periods would tell whether it comes again.

use crate::diagnosis::report::Remainder;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, SETTINGS as REGRESSION_SETTINGS, System};

/// A stretch of time in which a joint is off.
struct Passing {
    joint: usize,
    log: usize,
    /// Since the first row (s).
    from_to: [f64; 2],
    /// Mean residual [N·m or N].
    level: f64,
    /// Share of the squares of what the joint leaves.
    share: f64,
}

/// All that comes once, as a remainder.
pub(super) fn passing(data: &Data, system: &System) -> Option<Remainder> {
    let found: Vec<Passing> = (0..data.noise.len()).flat_map(|j| on_joint(data, system, j)).collect();
    if found.is_empty() {
        return None;
    }
    let name = |joint: usize| system.model.robot.joints()[joint].name.clone();
    let mut joints: Vec<usize> = found.iter().map(|p| p.joint).collect();
    joints.dedup();
    let share = |joint: usize| found.iter().filter(|p| p.joint == joint).map(|p| p.share).sum::<f64>();
    let left = data.left_as_noise(system);
    let square = |joint: usize| left[joint].std_dev.powi(2);
    let each = |p: &Passing| {
        let [from, to] = p.from_to;
        let level = system.model.robot.joints()[p.joint].effort(p.level);
        let log = &data.stretches[p.log].name;
        format!("{} by {level} from {from:.1} to {to:.1} s of {log}", name(p.joint))
    };
    let all: f64 = joints.iter().map(|&j| square(j)).sum();
    Some(Remainder {
        joints: joints.iter().map(|&j| name(j)).collect(),
        depends_on: vec!["time".into()],
        predicted_share: joints.iter().map(|&j| share(j) * square(j)).sum::<f64>() / all,
        rms: joints.iter().map(|&j| (share(j) * square(j)).sqrt()).collect(),
        note: format!(
            "torques are off for a short time and nowhere else: {}; somebody may have touched the arm there, or the model lacks \
             something of that place alone; record again, or leave that time out",
            found.iter().map(each).collect::<Vec<_>>().join(", ")
        ),
    })
}

/// Nothing where what is far from the rest is a sliver, or so frequent that it is no exception.
fn on_joint(data: &Data, system: &System, joint: usize) -> Vec<Passing> {
    let logs: Vec<Vec<f64>> = (0..system.blocks.len()).map(|s| runs(system, s, joint)).collect();
    let mut sizes: Vec<f64> = logs.iter().flatten().map(|z| z.abs()).filter(|z| *z > 0.0).collect();
    if sizes.is_empty() {
        return Vec::new();
    }
    let middle = sizes.len() / 2;
    let usual = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let far = |z: f64| z.abs() > SETTINGS.without_periods.passing * usual;
    let exceptions = sizes.iter().filter(|z| far(**z)).count();
    if exceptions as f64 > SETTINGS.without_periods.exceptions * sizes.len() as f64 {
        return Vec::new();
    }
    let of_log = |(log, runs): (usize, &Vec<f64>)| {
        together(runs, far)
            .into_iter()
            .map(|r| passed(data, system, joint, log, r))
            .collect::<Vec<_>>()
    };
    let found: Vec<Passing> = logs.iter().enumerate().flat_map(of_log).collect();
    match found.iter().map(|p| p.share).sum::<f64>() > SETTINGS.without_periods.remainder_share {
        true => found,
        false => Vec::new(),
    }
}

/// Rows of a run.
fn length(system: &System, log: usize, joint: usize) -> usize {
    (system.blocks[log][joint].residual.len() / REGRESSION_SETTINGS.persistence_runs).max(1)
}

/// Sums of the whitened residual over runs of rows, each over the root of how many count.
fn runs(system: &System, log: usize, joint: usize) -> Vec<f64> {
    let block = &system.blocks[log][joint];
    let length = length(system, log, joint);
    let count = |rows: &[bool]| rows.iter().filter(|r| **r).count().max(1) as f64;
    let residuals = block.residual.as_slice().chunks(length);
    residuals
        .zip(block.rows.chunks(length))
        .map(|(r, rows)| r.iter().sum::<f64>() / count(rows).sqrt())
        .collect()
}

/// Ranges of neighbours that are far from the rest to the same side.
fn together(runs: &[f64], far: impl Fn(f64) -> bool) -> Vec<[usize; 2]> {
    let mut found: Vec<[usize; 2]> = Vec::new();
    for k in (0..runs.len()).filter(|&k| far(runs[k])) {
        match found.last_mut() {
            Some([_, to]) if *to == k && runs[k - 1] * runs[k] > 0.0 => *to = k + 1,
            _ => found.push([k, k + 1]),
        }
    }
    found
}

fn passed(data: &Data, system: &System, joint: usize, log: usize, [from, to]: [usize; 2]) -> Passing {
    let block = &system.blocks[log][joint];
    let length = length(system, log, joint);
    let rows = from * length..(to * length).min(block.residual.len());
    let own = &block.residual.as_slice()[rows.clone()];
    let count = block.rows[rows.clone()].iter().filter(|r| **r).count().max(1) as f64;
    let step = data.stretches[log].row_interval();
    Passing {
        joint,
        log,
        from_to: [rows.start as f64 * step, rows.end as f64 * step],
        level: data.noise[joint].innovation * own.iter().sum::<f64>() / count,
        share: own.iter().map(|v| v * v).sum::<f64>() / system.joint_chi_square(joint),
    }
}
