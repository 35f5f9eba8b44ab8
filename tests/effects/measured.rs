//! Logs measured on real robots, read where they are at hand.

use dynident::diagnosis::{DiagnosisOptions, diagnose};
use dynident::formats::logs::{Columns, read_log_file};
use dynident::model::{Friction, Joint, JointKind, Mdh, Robot};
use dynident::preparation::{PreprocessOptions, prepare};
use dynident::regression::Stretch;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("DYNIDENT_REAL_DATA")
        .map(PathBuf::from)
        .filter(|p| p.is_dir());
    if folder.is_none() {
        eprintln!("{test} skipped: DYNIDENT_REAL_DATA names no folder");
    }
    folder
}

fn stretch(robot: &Robot, file: &Path) -> Stretch {
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let (log, _) = read_log_file(file, &Columns::default(), &names).unwrap();
    let prepared = prepare(&log, robot.joint_count(), &PreprocessOptions::default()).unwrap();
    Stretch::new(&prepared, &log)
}

/// Janot, Gautier & Brunot 2019: offset −3.16 N. On moves at constant speed friction that differs between the directions explains
/// a little more; it has to be among the rivals.
#[test]
fn val_emps_has_the_published_offset() {
    let Some(data) = folder("val_emps_has_the_published_offset") else {
        return;
    };
    let data = data.join("emps_janot");
    let mdh = Mdh {
        alpha: 0.0,
        d: 0.0,
        theta: 0.0,
        r: 0.0,
    };
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    let axis = Joint::from_mdh("axis", JointKind::Prismatic, mdh);
    let robot = Robot::new("EMPS", Vector3::zeros(), vec![axis], friction).unwrap();
    let [own, pulses] = ["DATA_EMPS.csv.gz", "DATA_EMPS_PULSES.csv.gz"].map(|f| stretch(&robot, &data.join(f)));
    let report = diagnose(&robot, &[own], &[pulses], &DiagnosisOptions::default()).report;
    let offset = &report.findings[0];
    assert_eq!(offset.effect, "torque_offset", "{:?}", report.findings);
    assert!(offset.rivals.iter().any(|r| r.effect == "asymmetric_viscous_friction"));
    let value = &offset.parameters[0];
    assert!((value.value + 3.1648).abs() < 3.0 * value.std_dev, "{value:?}");
    assert!(offset.rms_after.held_out[0] < 0.8 * offset.rms_before.held_out[0]);
}
