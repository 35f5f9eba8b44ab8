//! Trajectories in files: every format has the samples of the series.

use dynident::formats::logs::log_overview;
use dynident::formats::{TrajectoryFile, TrajectoryFormat};
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;
use std::path::{Path, PathBuf};
use std::process::Command;

fn series(joints: usize) -> FourierSeries {
    let coefficient = |j: usize, l: usize| 0.1 * (1.0 + j as f64) * (if l == 0 { 1.0 } else { -0.7 });
    FourierSeries {
        fundamental_hz: 0.2,
        a: DMatrix::from_fn(joints, 2, coefficient),
        b: DMatrix::from_fn(joints, 2, |j, l| 0.3 * coefficient(j, l)),
        offset: (0..joints).map(|j| 0.5 - 0.2 * j as f64).collect(),
    }
}

fn names(joints: usize) -> Vec<String> {
    (1..=joints).map(|j| format!("arm_joint_{j}")).collect()
}

fn written(joints: usize, format: TrajectoryFormat) -> Result<Vec<u8>, String> {
    let file = TrajectoryFile {
        run_in: None,
        run_out: None,
        joints: &names(joints),
        series: &series(joints),
        rate_hz: 125.0,
        periods: 2,
    };
    Ok(file.parts(format)?.flatten().collect())
}

/// 2 periods of 5 s at 125 Hz, and the sample after them.
const ROWS: usize = 1251;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("dynident-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn prop_recordings_and_arrays_have_every_bit_of_the_samples() {
    let folder = folder("trajectories");
    for (format, name, column) in [
        (TrajectoryFormat::Npz, "motion.npz", "q2"),
        (TrajectoryFormat::Mcap, "motion.mcap", "/excitation/arm_joint_2/position"),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, written(6, format).unwrap()).unwrap();
        let seen = log_overview(&path, name).unwrap();
        assert_eq!(seen.rows, ROWS, "{name}");
        let column = seen
            .columns
            .iter()
            .find(|c| c.name == column)
            .unwrap_or_else(|| panic!("{name}: {column}"));
        for (s, value) in column.first.iter().enumerate() {
            assert_eq!(*value, Some(series(6).state(1, s as f64 / 125.0)[0]), "{name}, sample {s}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn prop_a_program_moves_to_the_start_and_through_every_sample() {
    let text = String::from_utf8(written(6, TrajectoryFormat::Urscript).unwrap()).unwrap();
    let moves: Vec<&str> = text.lines().filter(|l| l.contains("servoj(")).collect();
    assert_eq!(moves.len(), ROWS);
    let numbers = |line: &str| -> Vec<f64> {
        let inner = line.split(['[', ']']).nth(1).unwrap();
        inner.split(", ").map(|v| v.parse().unwrap()).collect()
    };
    let start = text.lines().find(|l| l.contains("movej(")).unwrap();
    for (line, t) in [(start, 0.0), (moves[0], 0.0), (moves[300], 2.4), (moves[ROWS - 1], 0.0)] {
        for (j, value) in numbers(line).iter().enumerate() {
            assert!((value - series(6).state(j, t)[0]).abs() < 1e-10, "{line}");
        }
    }
    assert!(moves[0].ends_with(", 0, 0, 0.008, 0.03, 300)"), "{}", moves[0]);
    let error = written(7, TrajectoryFormat::Urscript).unwrap_err();
    assert!(error.contains("6 joints"), "{error}");
}

#[test]
fn formats_are_known_by_the_endings_of_files() {
    for (name, format) in [
        ("a.csv", TrajectoryFormat::Csv),
        ("a", TrajectoryFormat::Csv),
        ("a.JSON", TrajectoryFormat::JointTrajectory),
        ("a.yml", TrajectoryFormat::Yaml),
        ("a.script", TrajectoryFormat::Urscript),
        ("a.mcap", TrajectoryFormat::Mcap),
        ("a.npz", TrajectoryFormat::Npz),
    ] {
        assert_eq!(TrajectoryFormat::of_file(Path::new(name)), format, "{name}");
    }
}

/// NumPy, PyYAML, `mcap` and `rosbags` read what is written; the script says what it has compared.
#[test]
fn val_python_libraries_read_every_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join("target/simulators/bin/python");
    assert!(python.exists(), "rosbags and mcap are missing: run scripts/setup test");
    let folder = folder("python");
    for (name, format) in TrajectoryFormat::ALL {
        std::fs::write(folder.join(name), written(6, format).unwrap()).unwrap();
    }
    let script = root.join("tests/data/check_trajectory_files.py");
    let output = Command::new(python).arg(script).arg(&folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("7 files agree"), "{said}");
    std::fs::remove_dir_all(&folder).unwrap();
}
