//! Logs of every format over HTTP, and trajectories in every format.

use crate::server::{Answer, Server};
use serde_json::{Value, json};

const MULTIPART: &str = "multipart/form-data; boundary=XXboundary";

fn file(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/logs/formats/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn body(request: Option<&Value>, name: &str, content: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    if let Some(request) = request {
        let part = format!("--XXboundary\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{request}\r\n");
        body.extend(part.into_bytes());
    }
    body.extend(
        format!("--XXboundary\r\nContent-Disposition: form-data; name=\"log\"; filename=\"{name}\"\r\n\r\n").into_bytes(),
    );
    body.extend_from_slice(content);
    body.extend_from_slice(b"\r\n--XXboundary--\r\n");
    body
}

/// The planar arm, with joints as the recordings call them.
fn robot() -> Value {
    let text = std::fs::read_to_string(format!("{}/examples/robots/planar_two_link.json", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let mut robot: Value = serde_json::from_str(&text).unwrap();
    for (j, name) in ["shoulder", "elbow"].into_iter().enumerate() {
        robot["joints"][j]["name"] = json!(name);
    }
    robot
}

#[test]
fn a_log_of_any_format_is_understood_whatever_it_is_called() {
    let server = Server::start();
    let request = json!({"robot": robot()});
    let mut first: Option<Value> = None;
    for name in [
        "expected.csv",
        "savez.npz",
        "pandas.parquet",
        "version5.mat",
        "joint_states.mcap",
        "joint_states.db3",
        "packed.db3.zstd",
        "packed.csv.zst",
        "split.zip",
        "ur_rtde_lists.csv",
    ] {
        let answer: Answer = server.post_raw(
            "/identify/preview",
            MULTIPART,
            &body(Some(&request), "run.csv", &file(name)),
            None,
        );
        assert_eq!(answer.status, 200, "{name}: {}", answer.text);
        let seen = answer.json();
        let log = &seen["logs"][0];
        assert_eq!(log["sample_rate_hz"], json!(200.0), "{name}");
        assert_eq!(log["rows"], json!(200), "{name}");
        let joints = &log["joints"];
        assert_eq!(
            first.get_or_insert_with(|| joints.clone())[1]["torque"],
            joints[1]["torque"],
            "{name}"
        );
    }
    let answer = server.post_raw(
        "/identify/preview",
        MULTIPART,
        &body(Some(&request), "run.csv", &file("single.npy")),
        None,
    );
    assert_eq!(answer.status, 422, "{}", answer.text);
    let detail = answer.problem()["detail"].as_str().unwrap().to_string();
    assert!(detail.starts_with("run.csv is a NumPy array without names"), "{detail}");
}

#[test]
fn the_columns_of_a_log_are_told_before_anything_else() {
    let server = Server::start();
    let of = |name: &str, content: &[u8]| server.post_raw("/logs/columns", MULTIPART, &body(None, name, content), None);
    let answer = of("a", &file("joint_states.mcap"));
    assert_eq!(answer.status, 200, "{}", answer.text);
    let seen = answer.json();
    let names: Vec<&str> = seen["columns"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["name"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"/joint_states/shoulder/position") && names.contains(&"/joint_states/stamp"),
        "{names:?}"
    );
    let answer = of("b.csv", b"Recorded by hand\nt [ms];q1 [deg];mode\n0;1,5;run\n5;1,6;run\n");
    let seen = answer.json();
    assert_eq!((&seen["rows"], &seen["whole"]), (&json!(2), &json!(true)), "{seen}");
    assert_eq!(seen["columns"][1]["unit"], json!("deg"));
    assert_eq!(seen["columns"][1]["first"], json!([1.5, 1.6]));
    assert_eq!(
        (&seen["columns"][2]["numeric"], &seen["columns"][1]["largest"]),
        (&json!(false), &json!(1.6))
    );
    let answer = of("c.csv", b"\x89PNG\r\n\x1a\n\0\0\0");
    assert_eq!(answer.status, 422, "{}", answer.text);
    assert!(answer.problem()["detail"].as_str().unwrap().starts_with("c.csv is a picture"));
    let answer = server.post_raw("/logs/columns", MULTIPART, &body(Some(&json!({})), "a", b"t,q\n0,1\n"), None);
    assert_eq!(answer.status, 400, "{}", answer.text);
    assert!(
        answer.problem()["hint"].as_str().unwrap().contains("`log`"),
        "{}",
        answer.text
    );
}

#[test]
fn a_trajectory_is_handed_out_in_the_formats_of_controllers() {
    let server = Server::start();
    let design = server.excite(&crate::server::quick_request()).json();
    let id = design["id"].as_str().unwrap();
    let get = |query: &str| server.get(&format!("/excitation/{id}/trajectory?rate_hz=100&{query}"));
    let table = get("format=json&periods=2").json();
    let rows = table["rows"].as_array().unwrap().len();
    let answer = get("format=joint_trajectory&periods=2");
    let goal = answer.json();
    assert_eq!(goal["joint_names"], design["joints"]);
    let points = goal["points"].as_array().unwrap();
    assert_eq!(points.len(), rows);
    let (last, first) = (points.last().unwrap(), &points[0]);
    assert_eq!(last["positions"], first["positions"], "it ends where it began");
    assert_eq!(points[25]["time_from_start"], json!({"sec": 0, "nanosec": 250_000_000}));
    assert_eq!(answer.header("content-type"), Some("application/json"));
    for (format, begins, ending) in [("yaml", "# Goal of control_msgs", ".yaml\""), ("csv", "time,q1,", ".csv\"")] {
        let answer = get(&format!("format={format}"));
        assert!(answer.status == 200 && answer.text.starts_with(begins), "{}", answer.text);
        assert!(answer.header("content-disposition").unwrap().ends_with(ending));
    }
    let csv = get("format=csv").text;
    assert!(
        csv.lines().skip(1).flat_map(|l| l.split(',')).all(|v| v.len() <= 15),
        "no needless digits"
    );
    // This arm has two joints.
    let answer = get("format=urscript");
    assert_eq!(answer.status, 400, "{}", answer.text);
    assert!(
        answer.problem()["detail"].as_str().unwrap().contains("is for 6 joints"),
        "{}",
        answer.text
    );
    assert_eq!(get("format=xml").status, 400);
}
