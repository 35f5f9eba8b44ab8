//! Logs of real robots, published by others.

use crate::show::show;
use dynident::diagnosis::*;
use dynident::formats::logs::{Columns, JointColumns, read_log_file};
use dynident::model::*;
use dynident::preparation::{Log, Period, PreprocessOptions, prepare};
use dynident::regression::*;
use nalgebra::Vector3;
use std::path::Path;
use std::time::Instant;

const FRICTION: Friction = Friction {
    viscous: true,
    coulomb: true,
};

fn urdf(path: &Path) -> Robot {
    let text = std::fs::read_to_string(path).unwrap();
    from_urdf(&text, Vector3::new(0.0, 0.0, -9.81), FRICTION, ChainEnds::default())
        .unwrap()
        .robot
}

fn panda() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    let table = [
        (0.0, 0.0, 0.333),
        (-q, 0.0, 0.0),
        (q, 0.0, 0.316),
        (q, 0.0825, 0.0),
        (-q, -0.0825, 0.384),
        (q, 0.0, 0.0),
        (q, 0.088, 0.0),
    ];
    let joint = |(i, &(alpha, d, r)): (usize, &(f64, f64, f64))| {
        Joint::from_mdh(format!("J{}", i + 1), JointKind::Revolute, Mdh { alpha, d, theta: 0.0, r })
    };
    Robot::new(
        "Panda",
        Vector3::new(0.0, 0.0, -9.81),
        table.iter().enumerate().map(joint).collect(),
        FRICTION,
    )
    .unwrap()
}

fn emps() -> Robot {
    let joint = Joint::from_mdh(
        "axis",
        JointKind::Prismatic,
        Mdh {
            alpha: 0.0,
            d: 0.0,
            theta: 0.0,
            r: 0.0,
        },
    );
    Robot::new("EMPS", Vector3::zeros(), vec![joint], FRICTION).unwrap()
}

struct Trial {
    name: &'static str,
    robot: Robot,
    identify: Vec<&'static str>,
    held_out: Vec<&'static str>,
    columns: Columns,
    /// Held out of the identification logs where there is no other.
    last_share: f64,
    /// Factor on the torque once its sign is known.
    sign: f64,
}

fn numbered(prefix: &str, count: usize) -> JointColumns {
    JointColumns {
        headers: (0..count).map(|i| format!("{prefix}{i}")).collect(),
        ..JointColumns::default()
    }
}

fn trials(root: &Path) -> Vec<Trial> {
    let plain = Columns::default;
    let med = Columns {
        sample_rate_hz: Some(100.0),
        position: numbered("q_", 7),
        torque: numbered("tau_", 7),
        ..Columns::default()
    };
    let trial = |name, robot, identify, held_out, columns, last_share, sign| Trial {
        name,
        robot,
        identify,
        held_out,
        columns,
        last_share,
        sign,
    };
    let mut list = vec![
        trial(
            "emps_janot",
            emps(),
            vec!["DATA_EMPS.csv.gz"],
            vec!["DATA_EMPS_PULSES.csv.gz"],
            plain(),
            0.0,
            1.0,
        ),
        trial(
            "panda_gaz2019",
            panda(),
            vec!["exciting_trajectory_1.csv.gz"],
            vec![],
            plain(),
            0.3,
            1.0,
        ),
    ];
    let tx40 = root.join("staubli_tx40_figaroh/tx40_mdh_modified.urdf");
    if tx40.exists() {
        list.push(trial(
            "staubli_tx40_figaroh",
            urdf(&tx40),
            vec!["joint_side.csv.gz"],
            vec![],
            plain(),
            0.3,
            1.0,
        ));
    }
    let lwr = root.join("kuka_lwr4plus_flobaroid/kuka_lwr4.urdf");
    if lwr.exists() {
        list.push(trial(
            "kuka_lwr4plus_flobaroid",
            urdf(&lwr),
            vec!["measurements_1.csv.gz", "measurements_2.csv.gz"],
            vec!["measurements_3.csv.gz"],
            plain(),
            0.0,
            1.0,
        ));
    }
    let med7 = root.join("lbr_med7_r800/med7dock.urdf");
    if med7.exists() {
        let log = "measurements_with_ext_tau_1_dgr.csv";
        list.push(trial("lbr_med7_r800", urdf(&med7), vec![log], vec![], med.clone(), 0.3, 1.0));
        list.push(trial("lbr_med7_r800", urdf(&med7), vec![log], vec![], med, 0.3, -1.0));
    }
    list
}

fn read(trial: &Trial, root: &Path, file: &str) -> Log {
    let names: Vec<String> = trial.robot.joints().iter().map(|j| j.name.clone()).collect();
    let (mut log, report) = read_log_file(&root.join(trial.name).join(file), &trial.columns, &names).unwrap();
    report.findings.iter().for_each(|f| println!("  log: {f:?}"));
    log.tau.iter_mut().for_each(|t| t.iter_mut().for_each(|v| *v *= trial.sign));
    log
}

/// The log with every fifth block of a fiftieth of its length left out, or with nothing but those.
fn masked(log: &Log, share: f64, only: bool) -> Log {
    let n = log.samples();
    let mut part = log.clone();
    if share > 0.0 {
        part.usable
            .iter_mut()
            .enumerate()
            .for_each(|(s, u)| *u &= ((s * 25 / n) % 5 == 4) == only);
    }
    part
}

fn made(trial: &Trial, log: &Log) -> Stretch {
    let prepared = prepare(
        log,
        trial.robot.joint_count(),
        &PreprocessOptions {
            period: if trial.last_share > 0.0 {
                Period::None
            } else {
                Period::Detect
            },
            ..PreprocessOptions::default()
        },
    )
    .unwrap();
    let stretch = Stretch::new(&prepared, log);
    println!("  {stretch:?}, {} rows", stretch.rows());
    stretch
}

/// Traces the data sets whose names contain one of `names`, all of them without names.
pub fn measured(root: &Path, names: &[String]) {
    let wanted = |t: &&Trial| names.is_empty() || names.iter().any(|a| t.name.contains(a.as_str()));
    for trial in trials(root).iter().filter(wanted) {
        if !root.join(trial.name).exists() {
            println!("{} is absent", trial.name);
            continue;
        }
        println!("== {} (torque sign {})", trial.name, trial.sign);
        run(trial, root);
    }
}

fn run(trial: &Trial, root: &Path) {
    let (mut identify, mut held_out) = (Vec::new(), Vec::new());
    for file in &trial.identify {
        let log = read(trial, root, file);
        identify.push(made(trial, &masked(&log, trial.last_share, false)));
        if trial.last_share > 0.0 {
            held_out.push(made(trial, &masked(&log, trial.last_share, true)));
        }
    }
    held_out.extend(trial.held_out.iter().map(|f| made(trial, &read(trial, root, f))));
    let log = read(trial, root, trial.identify[0]);
    let raw = RawLog {
        time: Vec::new(),
        q: log.q.clone(),
        tau: log.tau.clone(),
    };
    let prepared = prepare(&log, trial.robot.joint_count(), &PreprocessOptions::default()).unwrap();
    sample_faults(&trial.robot, &raw)
        .iter()
        .chain(&column_faults(&trial.robot, &prepared.motion, &prepared.torque))
        .for_each(|f| println!("  FAULT {f:?}"));
    let t = Instant::now();
    let out = diagnose(&trial.robot, &identify, &held_out, &DiagnosisOptions::default());
    println!("  traced in {:.1?}", t.elapsed());
    show(&out.report);
}
