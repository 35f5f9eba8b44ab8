//! Robot files on the command line.

use super::{Folder, ROOT, run, stderr, stdout};
use serde_json::Value;

fn data(file: &str) -> String {
    format!("{ROOT}/tests/data/{file}")
}

#[test]
fn robot_files_are_read_with_notes_or_refused() {
    let read = |arguments: &[&str]| {
        let mut all = vec!["base-parameters", "--robot"];
        all.extend(arguments);
        let output = run(&all);
        (output.status.code(), stdout(&output), stderr(&output))
    };
    let (status, _, notes) = read(&[&data("robots/mimic_gripper.urdf"), "--tip", "l2"]);
    assert_eq!(status, Some(0), "{notes}");
    assert!(notes.contains("note: joint `g2` follows `g1` (mimic)"), "{notes}");
    let (status, _, error) = read(&[&data("robots/urdf_cycle_tip.json")]);
    assert!(status == Some(2) && error.contains("closed loop"), "{error}");
    let (status, _, error) = read(&[&data("robots/deep_link_4000.urdf")]);
    assert!(status == Some(2) && error.contains("200 levels"), "{error}");
    let (status, _, error) = read(&[&data("robots/cater_rev_300.urdf.gz")]);
    assert!(status == Some(2) && error.contains("300 chains"), "{error}");
    let (status, _, error) = read(&["iiwa14", "--tip", "x"]);
    assert!(
        status == Some(2) && error.contains("--tip goes with a robot from a URDF or MJCF file"),
        "{error}"
    );
    let (status, text, notes) = read(&[&data("robots/two_joint_31416.urdf")]);
    assert!(status == Some(0) && notes.contains("half turn"), "{notes}");
    let (_, exact, _) = read(&[&data("robots/latin1.urdf")]);
    assert_eq!(
        text.lines().next(),
        exact.lines().next(),
        "a half turn about x changes no number of parameters"
    );
}

/// The rounded half turn has the design of the exact one.
#[test]
fn regress_a_rounded_half_turn_is_excited_like_an_exact_one() {
    let folder = Folder::new("rounded");
    let mut request: Value = serde_json::from_str(&std::fs::read_to_string(data("requests/ex5.json")).unwrap()).unwrap();
    request["search"] = serde_json::json!({"seed": 1, "starts": 8, "max_evaluations": 4000});
    let request = folder.write("request.json", &request.to_string());
    let rounded = std::fs::read_to_string(data("robots/two_joint_31416.urdf")).unwrap();
    let design = |text: &str| -> Value {
        let (robot, out) = (folder.write("robot.urdf", text), folder.file("design.json"));
        let output = run(&["excite", "--robot", &robot, "--request", &request, "--out", &out]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_str(&folder.read("design.json")).unwrap()
    };
    let (exact, rounded) = (
        design(&rounded.replace("3.1416", &std::f64::consts::PI.to_string())),
        design(&rounded),
    );
    let condition = rounded["condition_number"].as_f64().unwrap();
    // With two parameters too many it was 277,380; five seconds of search come to 18.3.
    assert!(condition < 20.0, "{condition}");
    assert_eq!(rounded["condition_number"], exact["condition_number"]);
    assert!(rounded["notes"].to_string().contains("half turn"), "{}", rounded["notes"]);
}

/// A robot without velocity limits is identified, and its URDF is read again.
#[test]
fn regress_a_robot_without_velocity_limits_round_trips() {
    let folder = Folder::new("no-velocity");
    let (out, xml) = (folder.file("result.json"), folder.file("model.urdf"));
    let output = run(&[
        "identify",
        "--request",
        &data("requests/req_vel_null.json"),
        "--log",
        &data("logs/n_ok.csv.gz"),
        "--out",
        &out,
        "--urdf",
        &xml,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let read = run(&["base-parameters", "--robot", &xml]);
    assert_eq!(read.status.code(), Some(0), "{}", stderr(&read));
    assert!(
        stderr(&read).contains("the velocity limit 1e16 is taken as none"),
        "{}",
        stderr(&read)
    );
}

#[test]
fn regress_logs_with_stamps_of_other_units_are_read_or_refused() {
    let folder = Folder::new("stamps");
    let request = folder.write("request.json", r#"{"columns": {"sample_rate_hz": 100}}"#);
    let identify = |log: &str, more: &[&str]| {
        let log = data(log);
        let mut all = vec!["identify", "--robot", "planar_two_link", "--log", &log, "--json"];
        all.extend(more);
        let output = run(&all);
        (output.status.code(), stdout(&output), stderr(&output))
    };
    let (status, _, error) = identify("logs/last_stamp_1e12.csv.gz", &[]);
    assert!(status == Some(2) && error.contains("line 41"), "{error}");
    let (status, text, error) = identify("logs/ns_stamps.csv.gz", &["--request", &request]);
    assert!(status == Some(0) && text.contains("nanoseconds"), "{error}");
}
