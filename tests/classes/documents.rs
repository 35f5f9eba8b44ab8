//! Requests: every number of them at the ends of the range of doubles, sizes beyond the limits, nesting.

use super::server::Server;
use super::ways::{MULTIPART, multipart};
use super::written::{good_rows, log, unreadable};
use super::{Case, Expect, RobotFile, Work, refused, try_all};
use serde_json::{Value, json};

fn excite(name: impl Into<String>, change: Value, expect: Expect) -> Case {
    let mut request = json!({
        "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50,
        "search": {"seed": 1, "starts": 1, "max_evaluations": 60, "time_limit_s": 5}
    });
    request.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
    Case {
        name: name.into(),
        work: Work::Excite,
        robot: RobotFile::Named("planar_two_link"),
        request,
        logs: Vec::new(),
        expect,
    }
}

#[test]
fn designs_beyond_the_limits_are_refused_at_once() {
    let mut cases = Vec::new();
    for noise in [5e-324, 1e-300, 1e-30, 1e30, 1e300, 0.0, -1.0] {
        cases.push(excite(
            format!("noise {noise:e}"),
            json!({"torque_noise": [noise, noise]}),
            refused(["torque_noise"]),
        ));
    }
    for order in [51u64, 20_000, 1_000_000_000, u64::MAX] {
        cases.push(excite(
            format!("order {order}"),
            json!({"fourier": {"order": order, "fundamental_hz": 0.2}}),
            refused(["order"]),
        ));
    }
    for hertz in [1e-300, 1e-9, 1e9, 1e300, -0.2, 0.0] {
        cases.push(excite(
            format!("{hertz:e} Hz"),
            json!({"fourier": {"order": 3, "fundamental_hz": hertz}}),
            refused(["fundamental_hz"]),
        ));
        cases.push(excite(
            format!("rate {hertz:e} Hz"),
            json!({"sample_rate_hz": hertz}),
            refused(["sample_rate_hz"]),
        ));
    }
    for seconds in [0.0, -1.0, 1e300] {
        cases.push(excite(
            format!("{seconds:e} s"),
            json!({"search": {"time_limit_s": seconds}}),
            refused(["time_limit_s"]),
        ));
    }
    // A day at five harmonics and a kilohertz is more samples than an evaluation holds.
    cases.push(excite(
        "a day",
        json!({"fourier": {"order": 5, "fundamental_hz": 1.2e-5}, "sample_rate_hz": 1000}),
        refused([]),
    ));
    let walls: Vec<Value> = (0..5_000)
        .map(|_| json!({"half_space": {"point": [0, 0, -1], "normal": [0, 0, 1]}}))
        .collect();
    cases.push(excite(
        "many walls",
        json!({"constraints": {"obstacles": walls}}),
        refused([]),
    ));
    try_all(&cases);
}

/// Every number in a document, as a list of pointers.
fn numbers(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(at.to_string()),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(i, v)| numbers(v, &format!("{at}/{i}"), found)),
        Value::Object(fields) => fields.iter().for_each(|(name, v)| numbers(v, &format!("{at}/{name}"), found)),
        _ => {}
    }
}

const EXTREMES: [&str; 8] = [
    "1.7e308", "-1.7e308", "1e155", "-1e100", "1e-155", "5e-324", "-1e-300", "1e20",
];

/// One of every number after the other at an extreme: a result or a refusal, and no number in either that is none.
fn try_extremes(document: &Value, send: impl Fn(&Value) -> super::server::Answer) {
    let mut pointers = Vec::new();
    numbers(document, "", &mut pointers);
    assert!(pointers.len() > 3, "{document}");
    let mut failed = Vec::new();
    for (i, pointer) in pointers.iter().enumerate() {
        // Two of the extremes each, others from one number to the next.
        for k in 0..2 {
            let extreme = EXTREMES[(i + 3 * k) % EXTREMES.len()];
            let mut changed = document.clone();
            *changed.pointer_mut(pointer).unwrap() = serde_json::from_str(extreme).unwrap();
            let answer = send(&changed);
            let odd = unreadable(&answer.text);
            if !matches!(answer.status, 200 | 201 | 422) || odd.is_some() {
                let text: String = answer.text.chars().take(400).collect();
                failed.push(format!("{pointer} = {extreme}: {} {odd:?} {text}", answer.status));
            }
        }
    }
    assert!(failed.is_empty(), "{} failed:\n{}", failed.len(), failed.join("\n"));
}

fn robot() -> Value {
    let path = format!("{}/examples/robots/planar_two_link.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn extreme_numbers_in_robots_leave_no_number_that_is_none() {
    let server = Server::start();
    try_extremes(&robot(), |document| {
        let answer = server.post_json("/robots", &document.to_string());
        if answer.status != 201 {
            return answer;
        }
        let id = answer.json()["id"].as_str().unwrap().to_string();
        let found = server.get(&format!("/robots/{id}/base-parameters"));
        server.delete(&format!("/robots/{id}"));
        found
    });
}

#[test]
fn extreme_numbers_in_motions_leave_no_number_that_is_none() {
    let server = Server::start();
    let motion = json!({
        "robot": robot(), "q": [0.1, 0.2],
        "trajectory": {"fundamental_hz": 0.2, "offset": [0.1, 0.2], "coefficients": {"a": [[0.1], [0.2]], "b": [[0.3], [0.1]]}}
    });
    try_extremes(&motion, |document| server.post_json("/motion", &document.to_string()));
}

#[test]
fn extreme_numbers_in_designs_leave_no_number_that_is_none() {
    let server = Server::start();
    let design = json!({
        "robot": "planar_two_link", "fourier": {"order": 2, "fundamental_hz": 0.2}, "sample_rate_hz": 50, "torque_noise": [0.1, 0.2],
        "search": {"seed": 1, "starts": 1, "max_evaluations": 40, "time_limit_s": 2}
    });
    try_extremes(&design, |document| server.excite(document));
}

#[test]
fn extreme_numbers_in_identifications_and_previews_leave_no_number_that_is_none() {
    let server = Server::start();
    let request = json!({
        "robot": "planar_two_link", "period_s": 5, "prediction_points": 50, "trace": false, "feasible": {"method": "none"},
        "columns": {
            "sample_rate_hz": 100, "position": {"scale": [1, 1], "offset": [0, 0]}, "torque": {"scale": [1, 1], "offset": [0, 0], "matrix": [[1, 0], [0, 1]]}
        },
        "preprocess": {
            "method": "parallel_filter", "position_filter": {"order": 4, "cutoff_hz": 5}, "torque_filter": {"order": 4, "cutoff_hz": 5},
            "discard_edges_s": 0.1, "decimation": 2, "dead_zone": 0.001
        }
    });
    let text = log(good_rows()).into_bytes();
    let logs = [("log.csv".to_string(), text)];
    for path in ["/identify/preview", "/identify"] {
        // The request itself is a good one.
        let whole = server.post_raw(path, MULTIPART, &multipart(&request, &logs), None);
        assert_eq!(whole.status, 200, "{}", whole.text);
        try_extremes(&request, |document| {
            server.post_raw(path, MULTIPART, &multipart(document, &logs), None)
        });
    }
}
