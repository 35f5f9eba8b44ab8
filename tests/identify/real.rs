//! Logs measured on real robots by others. They are not part of this repository: `DYNIDENT_REAL_DATA` names the folder that holds
//! them, and without it these tests say that they were skipped.

use dynident::identification::{Estimate, Estimator, Observation, PreprocessOptions, Quality, estimate, prepare, quality};
use dynident::io::log::{Columns, read_log_file};
use dynident::model::{Friction, Joint, JointKind, Robot, from_urdf};
use dynident::parameters::BaseParameters;
use dynident::spatial::Transform;
use nalgebra::Vector3;
use std::path::PathBuf;

const FRICTION: Friction = Friction {
    viscous: true,
    coulomb: true,
};

fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("DYNIDENT_REAL_DATA")
        .map(PathBuf::from)
        .filter(|p| p.is_dir());
    if folder.is_none() {
        eprintln!("{test} skipped: DYNIDENT_REAL_DATA names no folder");
    }
    folder
}

fn fit(robot: &Robot, files: &[PathBuf], offset: bool) -> (BaseParameters, Estimate, Quality) {
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let base = BaseParameters::exact(robot);
    let prepared: Vec<_> = files
        .iter()
        .map(|f| {
            prepare(
                &read_log_file(f, &Columns::default(), &names).unwrap().0,
                names.len(),
                &PreprocessOptions::default(),
            )
            .unwrap()
        })
        .collect();
    let observe = |log| {
        let mut observation = Observation::new(robot, &base, log);
        if offset {
            observation.push_offsets(log);
        }
        observation
    };
    let observations: Vec<_> = prepared.iter().map(observe).collect();
    let logs: Vec<_> = prepared.iter().collect();
    let found = estimate(&observations, &logs, Estimator::Weighted);
    let judged = quality(robot, &base, &logs, &found);
    (base, found, judged)
}

/// Published (Janot, Gautier, Brunot 2019): M 95.1089 kg, Fv 203.5034 N s/m, Fc 20.3935 N, offset −3.1648 N.
#[test]
fn val_emps_gives_its_published_parameters() {
    let Some(folder) = folder("val_emps_gives_its_published_parameters") else {
        return;
    };
    // A horizontal axis: gravity does no work on it.
    let axis = Joint::from_placement("axis", JointKind::Prismatic, Transform::rot_x(std::f64::consts::FRAC_PI_2));
    let robot = Robot::new("EMPS", Vector3::new(0.0, 0.0, -9.81), vec![axis], FRICTION).unwrap();
    let (_, found, judged) = fit(&robot, &[folder.join("emps_janot/DATA_EMPS.csv.gz")], true);
    for (c, published) in [95.1089, 203.5034, 20.3935, -3.1648].into_iter().enumerate() {
        let error = found.values[c] - published;
        assert!(
            error.abs() < 3.0 * found.std_dev(c),
            "{} for {published} ± {}",
            found.values[c],
            found.std_dev(c)
        );
        assert!(
            error.abs() < 0.02 * f64::abs(published),
            "{} for {published}",
            found.values[c]
        );
    }
    assert_eq!(judged.verdict.code(), "good");
}

#[test]
fn val_lwr4_trained_on_its_poor_excitation_is_flagged() {
    let Some(folder) = folder("val_lwr4_trained_on_its_poor_excitation_is_flagged") else {
        return;
    };
    let folder = folder.join("kuka_lwr4plus_flobaroid");
    let urdf = std::fs::read_to_string(folder.join("kuka_lwr4.urdf")).unwrap();
    let robot = from_urdf(&urdf, Vector3::new(0.0, 0.0, -9.81), FRICTION, None).unwrap().robot;
    let files = [1, 2].map(|k| folder.join(format!("measurements_{k}.csv.gz")));
    let (_, found, judged) = fit(&robot, &files, false);
    assert_eq!(judged.verdict.code(), "poor_excitation");
    assert!(found.values.iter().all(|v| v.is_finite()));
}
