//! Robot files on the command line.

use super::{Folder, ROOT, run, stderr, stdout};
use crate::mesh::{binary_stl, box_of};
use serde_json::{Value, json};
use std::io::Write;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

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

fn stl() -> Vec<u8> {
    binary_stl(&box_of([0.05, 0.08, 0.3]))
}

#[test]
fn meshes_beside_a_urdf_file_give_its_links_a_shape() {
    let folder = Folder::new("meshes");
    for part in ["ws/my_arm/urdf", "ws/my_arm/meshes"] {
        std::fs::create_dir_all(folder.file(part)).unwrap();
    }
    std::fs::write(folder.file("ws/my_arm/meshes/l1.stl"), stl()).unwrap();
    let mesh = |file: &str| format!(r#"<collision><geometry><mesh filename="{file}"/></geometry></collision>"#);
    let text = format!(
        r#"<robot name="m"><link name="l0"/><link name="l1">{}</link><link name="l2">{}</link><link name="l3">{}</link>
        <joint name="j1" type="continuous"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/></joint>
        <joint name="j2" type="continuous"><origin xyz="0 0 0.3"/><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint>
        <joint name="j3" type="continuous"><origin xyz="0 0 0.3"/><parent link="l2"/><child link="l3"/><axis xyz="0 1 0"/></joint></robot>"#,
        mesh("package://my_arm/meshes/l1.stl"),
        mesh("../meshes/l1.stl"),
        mesh("package://my_arm/meshes/missing.stl"),
    );
    let robot = folder.write("ws/my_arm/urdf/arm.urdf", &text);
    let output = run(&["--json", "robot", &robot]);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)));
    let capsules: Vec<u64> = report["joints"]
        .as_array()
        .unwrap()
        .iter()
        .map(|j| j["capsules"].as_u64().unwrap())
        .collect();
    assert_eq!(capsules, [1, 1, 0], "{report}");
    // The same as one archive.
    let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in [("my_arm/urdf/arm.urdf", text.into_bytes()), ("my_arm/meshes/l1.stl", stl())] {
        writer.start_file(name, SimpleFileOptions::default()).unwrap();
        writer.write_all(&content).unwrap();
    }
    let archive = folder.file("arm.zip");
    std::fs::write(&archive, writer.finish().unwrap().into_inner()).unwrap();
    let output = run(&["--json", "robot", &archive]);
    let packed: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)));
    assert_eq!(packed["joints"], report["joints"]);
    assert!(stderr(&output).contains("not in the archive"), "{}", stderr(&output));
}

/// The same for MJCF: the compiler names the folder, a default class the scale, and `geometry` of a document of one's own goes
/// before.
#[test]
fn meshes_beside_an_mjcf_file_give_its_bodies_a_shape() {
    let folder = Folder::new("mjcf-meshes");
    std::fs::create_dir_all(folder.file("arm/assets")).unwrap();
    std::fs::write(folder.file("arm/assets/link.stl"), stl()).unwrap();
    let text = r#"<mujoco model="m"><compiler meshdir="assets"/><default><mesh scale="0.5 0.5 0.5"/></default>
        <asset><mesh file="link.stl"/><mesh file="missing.stl"/></asset><worldbody>
        <body name="l1"><joint name="j1"/><geom type="mesh" mesh="link"/>
        <body name="l2" pos="0 0 0.3"><joint name="j2" axis="0 1 0"/><geom type="mesh" mesh="link" contype="0" conaffinity="0"/>
        <body name="l3" pos="0 0 0.3"><joint name="j3" axis="0 1 0"/><geom type="mesh" mesh="missing"/></body></body></body></worldbody></mujoco>"#;
    let robot = folder.write("arm/arm.xml", text);
    let counts = |file: &str| -> Vec<u64> {
        let output = run(&["--json", "robot", file]);
        let report: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)));
        let joints = report["joints"].as_array().unwrap().iter();
        joints.map(|j| j["capsules"].as_u64().unwrap()).collect()
    };
    assert_eq!(counts(&robot), [1, 1, 0]);
    let capsule = json!({"from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.05});
    let document = json!({"mjcf": text, "geometry": {"l3": [capsule, capsule]}});
    assert_eq!(counts(&folder.write("own.json", &document.to_string())), [0, 0, 2]);
}
