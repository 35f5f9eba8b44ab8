//! simulate → identify → validate from the command line.

use crate::{Folder, run, stderr, stdout};
use serde_json::{Value, json};

pub fn trajectory(phase: f64) -> Value {
    let row = |j: usize, p: f64| -> Vec<f64> {
        (0..3)
            .map(|l| 0.5 * (p + 1.3 * j as f64 + 2.1 * f64::from(l)).sin())
            .collect()
    };
    json!({"fourier": {"fundamental_hz": 0.2, "a": [row(0, phase), row(1, phase)], "b": [row(0, phase + 1.0), row(1, phase + 1.0)]}})
}

/// Two links of 3 kg and 1 kg with friction.
pub fn robot(folder: &Folder) -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/robots/planar_two_link.json");
    let mut robot: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for (joint, mass) in robot["joints"].as_array_mut().unwrap().iter_mut().zip([3.0, 1.0]) {
        joint["prior"] = json!({"mass": mass, "center_of_mass": [0.2, 0.01, 0], "viscous": 0.3, "coulomb": 0.5,
            "inertia": {"xx": 0.01, "xy": 0, "xz": 0, "yy": 0.05, "yz": 0, "zz": 0.055}});
    }
    folder.write("truth.json", &robot.to_string())
}

fn simulate(folder: &Folder, robot: &str, name: &str, phase: f64, seed: u64) -> String {
    let request = json!({"trajectory": trajectory(phase), "periods": 3, "sample_rate_hz": 100, "seed": seed,
        "noise": {"torque": [0.01, 0.01]}});
    let request = folder.write(&format!("{name}.json"), &request.to_string());
    let out = folder.file(&format!("{name}.csv"));
    let output = run(&["simulate", "--robot", robot, "--request", &request, "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output), "1500 rows of 2 joints\n");
    out
}

#[test]
fn what_is_wrong_with_an_effect_is_told_at_its_place() {
    let folder = Folder::new("simulate");
    let effects = json!([{"effect": "torque_offset", "joint": "J1", "offset": 0.1}, {"effect": "torque_delay"}]);
    let request = json!({"trajectory": trajectory(0.3), "effects": effects, "faults": [{"fault": "sparks"}]});
    let request = folder.write("request.json", &request.to_string());
    let output = run(&["simulate", "--robot", &robot(&folder), "--request", &request]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    for words in ["/effects/1", "missing field `seconds`", "/faults/0", "sparks"] {
        assert!(stderr(&output).contains(words), "`{words}` in {}", stderr(&output));
    }
}

#[test]
fn a_simulated_log_is_identified_and_its_model_validates() {
    let folder = Folder::new("identify");
    let truth = robot(&folder);
    let (log, other) = (
        simulate(&folder, &truth, "run", 0.3, 1),
        simulate(&folder, &truth, "other", 2.0, 2),
    );
    let request = folder.write(
        "request.json",
        &json!({"trace": false, "feasible": {"method": "both", "starts": 3}}).to_string(),
    );
    let [out, model, urdf] = ["result.json", "model.json", "model.urdf"].map(|n| folder.file(n));
    let output = run(&[
        "identify",
        "--robot",
        "planar_two_link",
        "--request",
        &request,
        "--log",
        &log,
        "--validation",
        &other,
        "--out",
        &out,
        "--model",
        &model,
        "--urdf",
        &urdf,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "", "no bar of progress in a pipe");
    assert!(stdout(&output).contains("physical parameters"), "{}", stdout(&output));
    let found: Value = serde_json::from_str(&folder.read("result.json")).unwrap();
    assert_eq!(found["quality"]["verdict"], "good");
    let paper = &found["feasibility"]["paper"];
    assert_eq!(paper["status"], "Converged", "{paper}");
    // Costs are differences of sums of squares that are a million times as large.
    assert!(
        paper["objective"].as_f64().unwrap() >= paper["lower_bound"].as_f64().unwrap() * (1.0 - 1e-6),
        "{paper}"
    );
    assert_eq!(paper["starts"].as_array().unwrap().len(), 3);
    let output = run(&["--json", "validate", "--model", &model, "--log", &other]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let document: Value = serde_json::from_str(&stdout(&output)).unwrap();
    // Errors are of single measurements: the noise is 0.01 N m, and 1500 rows know it to two per cent.
    let rms = document["logs"][0]["rms"][0].as_f64().unwrap();
    assert!((rms - 0.01).abs() < 0.001, "{rms}");
    leaves_in_every_format(&folder, &model);
    // URDF knows no gravity, and this arm's is not the usual one: it is read back as a robot.
    let output = run(&["base-parameters", "--robot", &urdf]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

/// A stored model leaves in every format, by the endings of the files, and bodies go into a file of the user's.
fn leaves_in_every_format(folder: &Folder, model: &str) {
    let own = folder.write(
        "own.urdf",
        &folder
            .read("model.urdf")
            .replace("<link name=\"J2_link\">", "<!-- mine --><link name=\"J2_link\">"),
    );
    let names = ["out.urdf", "out.xml", "out.sdf", "out.csv", "out.c", "out.py"];
    let files = names.map(|n| folder.file(n));
    let mut arguments = vec!["model", model, "--patch-urdf", &own, "--base", "base_link", "--out"];
    arguments.extend(files.iter().map(String::as_str));
    let output = run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // Coulomb friction is a soft constraint in MuJoCo; all else is held.
    let notes = stderr(&output);
    assert!(
        notes.lines().all(|l| l.starts_with("note: out.xml: ")) && notes.contains("frictionloss"),
        "{notes}"
    );
    let words = [
        "<!-- mine -->",
        "<mujoco model=",
        "<sdf version=",
        "base_parameter,ZZR1,",
        "void planar_two_link_arm_gravity",
        "def mass_matrix(q)",
    ];
    for (name, words) in names.iter().zip(words) {
        assert!(folder.read(name).contains(words), "{name} has no {words}");
    }
    let xml = folder.read("out.xml").replace("mujoco", "mujocco");
    let output = run(&[
        "model",
        model,
        "--out",
        &folder.file("x.urdf"),
        "--patch-urdf",
        &folder.write("wrong.urdf", &xml),
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("mujocco"), "{}", stderr(&output));
}

#[test]
fn the_same_simulation_is_the_same_log_and_goes_to_standard_output() {
    let folder = Folder::new("simulate");
    let truth = robot(&folder);
    simulate(&folder, &truth, "run", 0.3, 1);
    let output = run(&["simulate", "--robot", &truth, "--request", &folder.file("run.json")]);
    assert_eq!(stdout(&output), folder.read("run.csv"));
    assert!(stdout(&output).starts_with("time,q1,q2,tau1,tau2\n"));
}

#[test]
fn logs_and_requests_that_are_wrong_end_with_status_2_and_a_remedy() {
    let folder = Folder::new("wrong");
    let truth = robot(&folder);
    let log = simulate(&folder, &truth, "run", 0.3, 1);
    let fails = |arguments: &[&str], words: &[&str]| {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "`{word}` in {}", stderr(&output));
        }
    };
    let robot = ["identify", "--robot", "planar_two_link", "--log"];
    let with = |log: &str| {
        [&robot[..], &[log]]
            .concat()
            .iter()
            .map(|s| s.to_string())
            .collect::<Vec<_>>()
    };
    let check = |log: &str, words: &[&str]| {
        let arguments = with(log);
        fails(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), words);
    };
    check(&folder.write("empty.csv", ""), &["invalid_log", "empty.csv", "is empty"]);
    check(&folder.file("absent.csv"), &["absent.csv", "cannot be read"]);
    check(
        &folder.write("header.csv", &"x".repeat(200_001)),
        &["header.csv", "longer than"],
    );
    check(
        &folder.write("short.csv", "time,q1,q2,tau1,tau2\n0,1,2,3,4\n"),
        &["short.csv", "1 usable rows"],
    );
    let request = folder.write(
        "request.json",
        &json!({"feasible": {"method": "papr", "slender_axes": ["w"]}, "period_s": 0}).to_string(),
    );
    fails(
        &["identify", "--robot", "planar_two_link", "--log", &log, "--request", &request],
        &["/feasible/method", "paper", "/feasible/slender_axes", "/period_s"],
    );
    fails(
        &["validate", "--model", "examples/robots/ur10.json", "--log", &log],
        &["has no mass and inertia", "give the model of an identification"],
    );
    let simulation = folder.write(
        "bad.json",
        &json!({"trajectory": trajectory(0.0), "noise": {"torque": [0.1]}}).to_string(),
    );
    fails(&["simulate", "--robot", &truth, "--request", &simulation], &["/noise/torque"]);
}
