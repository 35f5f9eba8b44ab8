//! Logs measured on real robots by others, from their own files with a request alone. They are not part of this repository:
//! `DYNIDENT_REAL_DATA` names the folder that holds them, and without it these tests say that they were skipped.

use dynident::app::{CancelFlag, Identified, LogFile, identify};
use dynident::documents::{NoExcitations, read_identify_request, shipped::Shipped};
use dynident::formats::Parsed;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

/// The folder of one robot; says so where there is none.
pub fn folder(test: &str, name: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/real");
    let root = std::env::var_os("DYNIDENT_REAL_DATA").map_or(beside, PathBuf::from);
    let folder = Some(root.join(name)).filter(|p| p.is_dir());
    if folder.is_none() {
        eprintln!("{test} skipped: DYNIDENT_REAL_DATA names no folder with {name}");
    }
    folder
}

fn run(mut request: Value, folder: &Path, files: &[&str]) -> Identified {
    request["trace"] = json!(false);
    let parsed = Parsed {
        value: request,
        problems: Vec::new(),
    };
    let request = read_identify_request(&parsed, &Shipped, &NoExcitations).unwrap_or_else(|e| panic!("{e:#?}"));
    let files: Vec<LogFile> = files.iter().map(|f| LogFile::at(&folder.join(f))).collect();
    identify(&request, &files, &[], &CancelFlag::default(), &|_| {}).unwrap_or_else(|e| panic!("{e:?}"))
}

pub fn urdf(folder: &Path, name: &str) -> Value {
    json!({"urdf": std::fs::read_to_string(folder.join(name)).unwrap()})
}

fn rms_percent(found: &Identified) -> Vec<f64> {
    found.document.rms.identification[0]
        .base
        .percent
        .iter()
        .flatten()
        .copied()
        .collect()
}

/// Estimates are numbers or said to be open, bodies are bodies. `most_percent` locks what the fit leaves of every joint's torque
/// today, rounded up: no outside figure exists for these logs; joints that carry the arm are explained to a few per cent, those
/// that carry little are mostly friction that the declared model lacks (what the tracing finds there is tested in
/// `tests/effects/measured.rs`).
fn check_sensible(found: &Identified, most_percent: &[f64]) {
    for p in &found.document.base_parameters {
        let given = p.value.is_some_and(f64::is_finite) && p.std_dev.is_some_and(f64::is_finite);
        assert!(given == p.identifiable, "{p:?}");
        // The arms here weigh some tens of kilograms and reach a metre; friction is up to some tens of newton metres.
        assert!(p.value.is_none_or(|v| v.abs() < 100.0), "{p:?}");
    }
    for (j, (percent, most)) in rms_percent(found).iter().zip(most_percent).enumerate() {
        assert!(percent < most, "joint {}: {percent} %, {:?}", j + 1, rms_percent(found));
    }
    for link in found.document.physical_parameters.as_ref().unwrap() {
        assert!(link.mass > 0.0 && link.mass < 100.0, "{link:?}");
        assert!(link.viscous >= -1e-9 && link.coulomb >= -1e-9, "{link:?}");
    }
    for m in &found.document.feasibility.as_ref().unwrap().margins {
        assert!(m.margin > -1e-9, "{m:?}");
    }
}

/// Published (Janot, Gautier, Brunot 2019): M 95.1089 kg, Fv 203.5034 N s/m, Fc 20.3935 N, offset −3.1648 N.
#[test]
fn val_emps_gives_its_published_parameters() {
    let Some(folder) = folder("val_emps_gives_its_published_parameters", "emps_janot") else {
        return;
    };
    // A horizontal axis: gravity does no work on it.
    let robot = json!({"name": "EMPS", "gravity": [0, 0, -9.81], "joints": [
        {"name": "axis", "kind": "prismatic", "placement": {"rpy": [FRAC_PI_2, 0, 0]}}]});
    let found = run(json!({"robot": robot, "offset": true}), &folder, &["DATA_EMPS.csv.gz"]);
    for (c, published) in [95.1089, 203.5034, 20.3935, -3.1648].into_iter().enumerate() {
        let (value, std_dev) = (found.found.estimate.values[c], found.found.estimate.std_dev(c));
        let error = value - published;
        assert!(error.abs() < 3.0 * std_dev, "{value} for {published} ± {std_dev}");
        assert!(error.abs() < 0.02 * f64::abs(published), "{value} for {published}");
    }
    assert_eq!(found.document.quality.verdict, "good");
}

/// The Panda of Gaz et al. 2019, from its modified DH table.
pub fn panda() -> Value {
    let q = FRAC_PI_2;
    let table = [
        (0.0, 0.0, 0.333),
        (-q, 0.0, 0.0),
        (q, 0.0, 0.316),
        (q, 0.0825, 0.0),
        (-q, -0.0825, 0.384),
        (q, 0.0, 0.0),
        (q, 0.088, 0.0),
    ];
    let joint = |(k, (alpha, d, r)): (usize, &(f64, f64, f64))| json!({"name": format!("J{}", k + 1), "kind": "revolute", "mdh": {"alpha": alpha, "d": d, "theta": 0, "r": r}});
    let joints: Vec<Value> = table.iter().enumerate().map(joint).collect();
    json!({"name": "Panda", "joints": joints})
}

#[test]
fn val_panda_runs_from_its_own_file() {
    let Some(folder) = folder("val_panda_runs_from_its_own_file", "panda_gaz2019") else {
        return;
    };
    let request = json!({"robot": panda(), "offset": true});
    let found = run(request, &folder, &["exciting_trajectory_1.csv.gz"]);
    check_sensible(&found, &[8.0, 2.0, 2.0, 2.0, 8.0, 5.0, 25.0]);
    let velocities = found.document.log_report[0]
        .choices
        .iter()
        .find(|c| c.what == "logged_velocities");
    assert!(
        velocities.is_some(),
        "the file has velocities, and the answer says what became of them"
    );
    let polled = found.document.log_report[0]
        .findings
        .iter()
        .find(|f| f.code == "repeated_row");
    assert!(
        polled.is_some_and(|f| f.count > 500),
        "{:?}",
        found.document.log_report[0].findings
    );
}

#[test]
fn val_med7_runs_from_its_own_file() {
    let Some(folder) = folder("val_med7_runs_from_its_own_file", "lbr_med7_r800") else {
        return;
    };
    let names = |stem: &str| (0..7).map(|k| format!("{stem}_{k}")).collect::<Vec<_>>();
    let columns =
        json!({"sample_rate_hz": 100, "position": {"headers": names("q")}, "torque": {"headers": names("tau"), "sign": -1}});
    let request = json!({"robot": urdf(&folder, "med7dock.urdf"), "columns": columns, "offset": true});
    let found = run(request, &folder, &["measurements_with_ext_tau_1_dgr.csv"]);
    check_sensible(&found, &[80.0, 3.0, 15.0, 5.0, 25.0, 20.0, 40.0]);
    // It moves so slowly that inertias are not to be had, and that is reported.
    assert_ne!(found.document.quality.verdict, "good");
}

/// Motor positions in one file and motor torques in another; gear ratios and the wrist's coupling in `columns`.
#[test]
fn val_tx40_runs_from_its_two_raw_files() {
    let Some(folder) = folder("val_tx40_runs_from_its_two_raw_files", "staubli_tx40_figaroh") else {
        return;
    };
    let robot = urdf(&folder, "tx40_mdh_modified.urdf");
    let names: Vec<String> = (1..=6).map(|k| format!("Joint_{k}")).collect();
    let mut ratios = vec![vec![0.0; 6]; 6];
    for (k, ratio) in [32.0, 32.0, 45.0, -48.0, 45.0, 32.0].into_iter().enumerate() {
        ratios[k][k] = ratio;
    }
    ratios[5][4] = 32.0;
    let columns = json!({"sample_rate_hz": 5000, "coupling": ratios,
        "position": {"headers": names, "offset": [0, -PI / 2.0, PI / 2.0, 0, 0, 0]},
        "torque": {"headers": names, "file": "curr_data.csv"}});
    let request = json!({"robot": robot, "columns": columns, "offset": true});
    let found = run(request, &folder, &["pos_read_data.csv", "curr_data.csv"]);
    check_sensible(&found, &[8.0, 8.0, 15.0, 15.0, 60.0, 45.0]);
    // The source gives the same log on the joint side as well: the mapping makes that of the raw files.
    let joint_side = run(json!({"robot": robot, "offset": true}), &folder, &["joint_side.csv.gz"]);
    for (raw, joint) in rms_percent(&found).iter().zip(rms_percent(&joint_side)) {
        assert!((raw / joint - 1.0).abs() < 0.05, "{raw} {joint}");
    }
}

#[test]
fn val_lwr4_trained_on_its_poor_excitation_is_flagged() {
    let Some(folder) = folder(
        "val_lwr4_trained_on_its_poor_excitation_is_flagged",
        "kuka_lwr4plus_flobaroid",
    ) else {
        return;
    };
    let request = json!({"robot": urdf(&folder, "kuka_lwr4.urdf")});
    let found = run(request, &folder, &["measurements_1.csv.gz", "measurements_2.csv.gz"]);
    assert_eq!(found.document.quality.verdict, "poor_excitation");
    // Joint 7 carries 0.26 N m, nearly all of it friction that the declared model lacks: weighted by what is left there, its rows
    // count for so little that its own torque is predicted worse than by zero (116 %).
    check_sensible(&found, &[100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 120.0]);
}
