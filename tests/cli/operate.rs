//! What an operator does on the command line.

use super::{Folder, PROGRAM, ROOT, run, stderr, stdout};
use serde_json::{Value, json};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_server_that_anyone_could_use_does_not_start_by_accident() {
    let folder = Folder::new("open");
    let data = folder.file("data");
    let output = run(&["serve", "--listen", "0.0.0.0:0", "--auth", "off", "--data", &data]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let text = stderr(&output);
    assert!(
        text.contains("error[forbidden]") && text.contains("--open-to-anyone"),
        "{text}"
    );
    assert!(!std::path::Path::new(&data).exists(), "nothing was begun");
}

#[test]
fn a_worker_without_a_shared_database_says_what_it_needs() {
    let folder = Folder::new("worker");
    let output = run(&["worker", "--data", &folder.file("data")]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("DATABASE_URL"), "{}", stderr(&output));
}

#[test]
fn tokens_are_made_listed_and_revoked_and_the_audit_log_knows() {
    let folder = Folder::new("tokens");
    let data = folder.file("data");
    let data = data.as_str();
    let made = run(&[
        "token", "create", "--robot", "arm", "--role", "read", "--name", "Ada", "--data", data, "--json",
    ]);
    assert!(made.status.success(), "{}", stderr(&made));
    let made: Value = serde_json::from_str(&stdout(&made)).unwrap();
    let (id, secret) = (made["id"].as_str().unwrap(), made["token"].as_str().unwrap());
    assert!(secret.starts_with(&format!("dynident_{id}_")));
    let list = || -> Value { serde_json::from_str(&stdout(&run(&["token", "list", "--data", data, "--json"]))).unwrap() };
    assert_eq!(list()[0]["name"], "Ada");
    assert_eq!(list()[0]["revoked"], false);
    assert!(!list().to_string().contains(secret));
    assert!(run(&["token", "revoke", id, "--data", data]).status.success());
    assert_eq!(list()[0]["revoked"], true);
    assert_eq!(run(&["token", "revoke", id, "--data", data]).status.code(), Some(2));
    assert_eq!(
        run(&["token", "create", "--robot", "arm", "--role", "king", "--data", data])
            .status
            .code(),
        Some(2)
    );
    let brief = [
        "token",
        "create",
        "--robot",
        "arm",
        "--name",
        "Guest",
        "--expires-in",
        "1s",
        "--data",
        data,
        "--json",
    ];
    let brief: Value = serde_json::from_str(&stdout(&run(&brief))).unwrap();
    let end = brief["expires_at"].as_str().unwrap().to_string();
    let listed = || {
        list()
            .as_array()
            .unwrap()
            .iter()
            .find(|t| t["id"] == brief["id"])
            .unwrap()
            .clone()
    };
    assert_eq!(
        (&listed()["expires_at"], &list()[0]["expires_at"]),
        (&brief["expires_at"], &Value::Null)
    );
    std::thread::sleep(std::time::Duration::from_millis(1100));
    assert_eq!(listed()["state"], "expired");
    let table = stdout(&run(&["token", "list", "--data", data]));
    let seconds = end.split_once('.').unwrap().0;
    let line = table.lines().find(|l| l.contains("Guest")).unwrap();
    assert!(line.contains("expired") && line.contains(seconds), "{table}");
    let wrong = run(&["token", "create", "--robot", "arm", "--expires-in", "soon", "--data", data]);
    assert!(
        wrong.status.code() == Some(2) && stderr(&wrong).contains("soon"),
        "{}",
        stderr(&wrong)
    );
    let audit = stdout(&run(&["audit", "--data", data]));
    let actions: Vec<bool> = audit
        .lines()
        .map(|l| l.contains("token_create") || l.contains("token_revoke"))
        .collect();
    assert_eq!(actions, [true, true, true], "{audit}");
}

#[test]
fn settings_are_printed_with_what_they_come_from() {
    let folder = Folder::new("settings");
    let file = folder.write("dynident.toml", "waiting_jobs = 12\n");
    let output = run(&["config", "--config", &file, "--lease-s", "30"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    for line in [
        "waiting_jobs = 12 # file",
        "lease_s = 30.0 # environment or flag",
        "auth = \"auto\" # default",
    ] {
        assert!(text.lines().any(|l| l == line), "{line} not in\n{text}");
    }
    folder.write("dynident.toml", "waiting_jobs = \"many\"\n");
    let output = run(&["config", "--config", &file]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("waiting_jobs"), "{}", stderr(&output));
}

/// The settings file that is shipped is one.
#[test]
fn the_example_of_a_settings_file_can_be_read() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/deploy/dynident.toml");
    let output = run(&["config", "--config", file]);
    assert!(output.status.success(), "{}", stderr(&output));
}

/// A log of two hidden laws that no effect has and some that one has, without periods: its diagnosis takes tens of seconds.
fn long_diagnosis(folder: &Folder) -> Vec<String> {
    let wave = |j: usize, k: usize| {
        let frequency = 0.07 * k as f64 + 0.013 * ((j * 3 + k * 5) % 7) as f64;
        json!([0.2 + 0.02 * ((j + 2 * k) % 5) as f64, frequency])
    };
    let terms: Vec<Vec<Value>> = (0..7).map(|j| (1..4).map(|k| wave(j, k)).collect()).collect();
    let request = json!({
        "trajectory": {"sines": {"terms": terms, "duration": 40}}, "sample_rate_hz": 200, "seed": 1,
        "noise": {"torque": [0.3, 0.3, 0.2, 0.2, 0.1, 0.05, 0.05], "position": 1e-5},
        "effects": [
            {"effect": "unmodelled", "joints": ["A2", "A4"], "amplitude": 8},
            {"effect": "unmodelled", "joints": ["A3", "A1"], "amplitude": 4},
            {"effect": "stribeck_friction", "joint": "A4", "amplitude": 3, "velocity": 0.05, "exponent": 2},
            {"effect": "position_ripple", "joint": "A1", "amplitude": 2, "cycles": 20, "phase": 0.3},
            {"effect": "joint_spring", "joint": "A5", "stiffness": 2, "rest": 0.1},
        ],
    });
    let request = folder.write("truth.json", &request.to_string());
    let (robot, log) = ("examples/robots/iiwa14.json", folder.file("long.csv"));
    let made = run(&["simulate", "--robot", robot, "--request", &request, "--out", &log]);
    assert!(made.status.success(), "{}", stderr(&made));
    let out = folder.file("result.json");
    ["identify", "--robot", robot, "--log", &log, "--out", &out]
        .map(str::to_string)
        .to_vec()
}

/// Reading takes a fraction of a second, so that these moments lie within the search. Its loops look at the switch every few
/// hundredths of a second; a busy machine may take a second for that.
#[test]
fn a_long_diagnosis_ends_soon_after_it_is_cancelled() {
    let folder = Folder::new("cancel");
    let arguments = long_diagnosis(&folder);
    for (i, moment) in [0.4, 0.8, 1.2].into_iter().enumerate() {
        let mut child = Command::new(PROGRAM)
            .args(&arguments)
            .current_dir(ROOT)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs_f64(moment));
        // A fast machine may be done by the later moments.
        if child.try_wait().unwrap().is_some() {
            assert!(i > 0, "after {moment} s there is still work");
            break;
        }
        let pid = rustix::process::Pid::from_child(&child);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
        let cancelled = Instant::now();
        let output = child.wait_with_output().unwrap();
        let took = cancelled.elapsed().as_secs_f64();
        eprintln!("cancelled after {moment} s: ended {took:.3} s later");
        assert!(took < 1.0, "cancelled after {moment} s, it ended {took} s later");
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        assert!(stderr(&output).contains("error[no_result]"), "{}", stderr(&output));
        assert!(!std::path::Path::new(&folder.file("result.json")).exists());
    }
}
