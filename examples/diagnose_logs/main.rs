//! Diagnoses the residual of a declared model.
//!
//! `trace_logs measured DIRECTORY [NAME…]`: logs of real robots, the directory as of the data's documentation.
//! `trace_logs virtual DIRECTORY…`: logs of an iiwa 14, each directory with `identify.csv.gz` and `validate.csv.gz`.

mod measured;
mod show;

use dynident::diagnosis::{DiagnosisOptions, diagnose};
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::formats::logs::{Columns, read_log_file};
use dynident::model::{Joint, Robot};
use dynident::preparation::{PreprocessOptions, prepare};
use dynident::regression::Stretch;
use show::show;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.split_first() {
        Some((what, rest)) if what == "measured" && !rest.is_empty() => measured::measured(rest[0].as_ref(), &rest[1..]),
        Some((what, rest)) if what == "virtual" => simulated(rest),
        _ => eprintln!("usage: trace_logs measured DIRECTORY [NAME…] | virtual DIRECTORY…"),
    }
}

/// The arm as declared: without priors.
fn iiwa14() -> Robot {
    let shipped = Shipped.named("iiwa14").expect("comes with the program").robot;
    let bare = |joint: &Joint| Joint {
        prior: None,
        ..joint.clone()
    };
    let joints = shipped.joints().iter().map(bare).collect();
    Robot::new(shipped.name(), shipped.gravity(), joints, shipped.friction()).expect("valid without priors")
}

fn load(robot: &Robot, path: &str) -> Stretch {
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let (log, _) = read_log_file(path.as_ref(), &Columns::default(), &names).unwrap();
    let prepared = prepare(&log, robot.joint_count(), &PreprocessOptions::default()).unwrap();
    Stretch::new(&prepared, &log)
}

fn simulated(directories: &[String]) {
    let robot = iiwa14();
    for dir in directories {
        let [a, b] = ["identify", "validate"].map(|name| load(&robot, &format!("{dir}/{name}.csv.gz")));
        println!("== {dir}: {a:?} {b:?}");
        let t = Instant::now();
        let out = diagnose(&robot, &[a], std::slice::from_ref(&b), &DiagnosisOptions::default());
        println!("  identification traced in {:?}", t.elapsed());
        show(&out.report);
        let t = Instant::now();
        let options = DiagnosisOptions {
            existing: Some(out.existing()),
            ..DiagnosisOptions::default()
        };
        let again = diagnose(&robot, &[b], &[], &options);
        println!("  validation traced in {:?}", t.elapsed());
        show(&again.report);
    }
}
