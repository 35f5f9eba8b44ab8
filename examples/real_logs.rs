//! Traces measured logs: `real_logs DIRECTORY [NAME…]`, the directory as of the data's documentation. Nothing happens for a folder that is absent.

use dynident::dynamics::Motion;
use dynident::identification::preprocess::Period;
use dynident::identification::{Log, PreprocessOptions, prepare};
use dynident::io::log::{Columns, JointColumns, read_log_file};
use dynident::model::*;
use dynident::residual::*;
use nalgebra::Vector3;
use std::path::Path;
use std::time::Instant;

const FRICTION: Friction = Friction {
    viscous: true,
    coulomb: true,
};

fn urdf(path: &Path) -> Robot {
    let text = std::fs::read_to_string(path).unwrap();
    from_urdf(&text, Vector3::new(0.0, 0.0, -9.81), FRICTION, None).unwrap().robot
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
    /// Factor on the torque once its sign has been told.
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

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(root) = arguments.first().map(Path::new) else {
        return eprintln!("usage: real_logs DIRECTORY [NAME…]");
    };
    for trial in trials(root)
        .iter()
        .filter(|t| arguments.len() == 1 || arguments[1..].iter().any(|a| t.name.contains(a.as_str())))
    {
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
    let first = &identify[0];
    let step = (first.motion.samples() / 1000).max(1);
    let motion = Motion::from_fn(first.joints(), first.motion.samples() / step, |j, s| {
        first.motion.get(j, s * step)
    });
    let log = read(trial, root, trial.identify[0]);
    let torque: Vec<Vec<f64>> = log
        .tau
        .iter()
        .map(|t| (0..motion.samples()).map(|s| t[s * step]).collect())
        .collect();
    let raw = RawLog {
        time: Vec::new(),
        q: log.q.clone(),
        tau: log.tau.clone(),
    };
    sample_faults(&trial.robot, &raw)
        .iter()
        .chain(&column_faults(&trial.robot, &motion, &torque))
        .for_each(|f| println!("  FAULT {f:?}"));
    let t = Instant::now();
    let out = trace(&trial.robot, &identify, &held_out, &TraceOptions::default());
    println!("  traced in {:.1?}", t.elapsed());
    show(&out.report);
}

fn show(r: &ResidualReport) {
    let fits = |l: &[JointFit]| {
        l.iter()
            .map(|f| format!("{:.2}/{:.0e}", f.statistic, f.p_value))
            .collect::<Vec<_>>()
            .join(" ")
    };
    println!(
        "  verdict {:?} floor {:.4?} ({})\n  lack of fit {}\n  afterwards  {}",
        r.verdict,
        r.noise_floor,
        r.noise_source,
        fits(&r.lack_of_fit),
        fits(&r.lack_of_fit_after)
    );
    for f in &r.findings {
        println!(
            "  FOUND {} {:?} evidence {:.1}",
            f.effect, f.joints, f.evidence.log_evidence_ratio
        );
        f.parameters
            .iter()
            .for_each(|p| println!("     {} = {:.5} ± {:.5} {}", p.name, p.value, p.std_dev, p.unit));
        f.rivals
            .iter()
            .for_each(|v| println!("     rival {} {:?} {:.1}", v.effect, v.joints, v.evidence));
        println!("     held out {:.3?} -> {:.3?}", f.rms_before.held_out, f.rms_after.held_out);
    }
    if let Some(x) = &r.remainder {
        println!("  REMAINDER {x:?}");
    }
    println!(
        "  identification {:.3?} -> {:.3?}\n  held out {:.3?} -> {:.3?}",
        r.rms_before.identification, r.rms_after.identification, r.rms_before.held_out, r.rms_after.held_out
    );
}
