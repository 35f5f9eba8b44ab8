//! What a log holds, and what shells and `man` know of the program.

use super::{Folder, ROOT, run, stderr, stdout};
use serde_json::Value;

fn log(name: &str) -> String {
    format!("{ROOT}/tests/data/logs/formats/{name}")
}

#[test]
fn the_columns_of_a_log_are_printed_with_what_they_are_taken_for() {
    let folder = Folder::new("log-columns");
    let robot = std::fs::read_to_string(format!("{ROOT}/examples/robots/planar_two_link.json")).unwrap();
    let robot = robot.replace("\"J1\"", "\"shoulder\"").replace("\"J2\"", "\"elbow\"");
    let path = folder.write("robot.json", &robot);
    let output = run(&["log", &log("joint_states.mcap"), "--robot", &path]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let line = |name: &str| {
        text.lines()
            .find(|l| l.starts_with(name))
            .unwrap_or_else(|| panic!("{name}: {text}"))
    };
    assert!(line("/joint_states/elbow/effort").contains("torque 2"), "{text}");
    assert!(line("/joint_states/stamp").contains("time"), "{text}");
    let output = run(&["--json", "log", &log("ur_rtde.csv"), "--robot", &path]);
    let seen: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(seen["taken"]["torque"][1], "actual_current_as_torque_1");
    // What is there is shown, and what is missing is said.
    let output = run(&["log", &log("ur_rtde_currents.csv"), "--robot", &path]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stdout(&output).contains("actual_current_1") && stderr(&output).contains("are currents"),
        "{}",
        stderr(&output)
    );
    let output = run(&["log", &log("single.npy")]);
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("numpy.savez_compressed"),
        "{}",
        stderr(&output)
    );
}

/// A recording of rosbag2 is a folder with a description.
#[test]
fn a_folder_of_rosbag2_is_read_by_its_metadata() {
    let folder = Folder::new("bag");
    let bag = folder.file("bag");
    std::fs::create_dir(&bag).unwrap();
    std::fs::copy(log("joint_states.mcap"), format!("{bag}/bag_0.mcap")).unwrap();
    let missing = run(&["log", &bag]);
    assert!(
        missing.status.code() != Some(0) && stderr(&missing).contains("metadata.yaml"),
        "{}",
        stderr(&missing)
    );
    let metadata = "rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:\n    - ../bag_0.mcap\n    - \"bag_0.mcap\"\n  duration:\n    nanoseconds: 1\n";
    folder.write("bag/metadata.yaml", metadata);
    let (whole, alone) = (run(&["log", &bag]), run(&["log", &log("joint_states.mcap")]));
    assert_eq!(whole.status.code(), Some(0), "{}", stderr(&whole));
    assert_eq!(stdout(&whole), stdout(&alone));
}

#[test]
fn shells_and_manuals_know_every_command() {
    let output = run(&["completions", "bash"]);
    let text = stdout(&output);
    for word in ["excite", "identify", "--trajectory", "base-parameters"] {
        assert!(text.contains(word), "{word}");
    }
    let folder = Folder::new("manual");
    let output = run(&["man", "--out", &folder.file("man1")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = std::fs::read_to_string(folder.file("man1/dynident-excite.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("trajectory"), "{page}");
}
