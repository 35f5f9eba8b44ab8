//! Uploads that hold nothing, over HTTP: refused at once with what is missing, or answered with a verdict.

use crate::identify::{log, post};
use crate::server::{Answer, Server};
use serde_json::{Value, json};

const MULTIPART: &str = "multipart/form-data; boundary=XXboundary";

/// One upload with a log as it is on the disk.
fn upload(server: &Server, name: &str) -> Answer {
    let path = format!("{}/tests/data/degenerate/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut body = format!(
        "--XXboundary\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n--XXboundary\r\n\
         Content-Disposition: form-data; name=\"log\"; filename=\"{name}\"\r\n\r\n",
        json!({"robot": "planar_two_link"})
    )
    .into_bytes();
    body.extend(std::fs::read(path).unwrap());
    body.extend_from_slice(b"\r\n--XXboundary--\r\n");
    server.post_raw("/identify", MULTIPART, &body, None)
}

#[test]
fn every_degenerate_log_has_a_verdict_or_a_problem_document() {
    let server = Server::start();
    for (name, word) in [
        ("n_const_tau.csv.gz", "no torque column can be used"),
        ("one_bad_row.csv.gz", "not rows of numbers"),
        ("n_still.csv.gz", "no joint moves"),
    ] {
        let answer = upload(&server, name);
        assert_eq!(answer.status, 422, "{name}: {}", answer.text);
        assert!(
            answer.problem()["detail"].as_str().unwrap().contains(word),
            "{name}: {}",
            answer.text
        );
    }
    for (name, verdict) in [
        ("one_const_tau.csv.gz", "unidentifiable"),
        ("one_zero_tau.csv.gz", "unidentifiable"),
        ("sy.csv.gz", "unidentifiable"),
        ("noise_seed0.csv.gz", "explains_nothing"),
        ("noise_seed1.csv.gz", "explains_nothing"),
        ("noise_seed2.csv.gz", "explains_nothing"),
    ] {
        let answer = upload(&server, name);
        assert_eq!(answer.status, 200, "{name}: {}", answer.text);
        assert_eq!(answer.json()["quality"]["verdict"], verdict, "{name}");
    }
    assert_eq!(upload(&server, "noisefree_5digits.csv.gz").status, 200);
}

fn jobs(server: &Server) -> usize {
    server.get("/jobs").json()["jobs"].as_array().map_or(0, Vec::len)
}

#[test]
fn what_cannot_be_identified_from_is_refused_before_it_is_a_job() {
    let server = Server::start();
    let request = json!({"robot": "planar_two_link"}).to_string();
    let refused = |parts: &[(&str, &str, &str)], code: &str, word: &str| {
        for path in ["/identify", "/validate"] {
            let answer = post(&server, path, false, parts);
            assert_eq!(answer.status, 422, "{path}: {}", answer.text);
            let problem: Value = answer.problem();
            assert!(problem["code"] == code && answer.text.contains(word), "{path}: {problem}");
        }
    };
    refused(&[("request", "", &request)], "invalid_log", "no log in the upload");
    refused(
        &[("request", "", &request), ("log", "run.csv", "")],
        "invalid_log",
        "run.csv is empty",
    );
    let amperes = |torque: Value| json!({"robot": "planar_two_link", "columns": {"torque": torque}}).to_string();
    let recorded = log(0.3);
    for torque in [json!({"unit": "A"}), json!({"unit": ["N m", "A"]})] {
        let answer = post(
            &server,
            "/identify",
            false,
            &[("request", "", &amperes(torque)), ("log", "run.csv", &recorded)],
        );
        assert_eq!(answer.status, 422, "{}", answer.text);
        let problem = answer.problem();
        assert_eq!(problem["errors"][0]["pointer"], "/columns/torque/unit", "{problem}");
    }
    assert_eq!(jobs(&server), 0);
    let scaled = amperes(json!({"unit": "A", "scale": [1.0, 0.5]}));
    let answer = post(
        &server,
        "/identify",
        true,
        &[("request", "", &scaled), ("log", "run.csv", &recorded)],
    );
    assert_eq!(answer.status, 200, "{}", answer.text);
}

/// The period of the request is that of the identification log; the validation log, which runs through its motion in four
/// seconds, has its own.
#[test]
fn the_period_is_found_log_by_log() {
    let server = Server::start();
    let request = json!({"robot": "planar_two_link", "period_s": 5, "trace": false}).to_string();
    let faster: Vec<String> = log(2.0)
        .lines()
        .enumerate()
        .map(|(at, line)| match (at, line.split_once(',')) {
            (0, _) | (_, None) => line.to_string(),
            (at, Some((_, rest))) => format!("{:.3},{rest}", (at - 1) as f64 * 0.008),
        })
        .collect();
    let parts = [
        ("request", "", request.as_str()),
        ("log", "run.csv", &log(0.3)),
        ("validation", "other.csv", &faster.join("\n")),
    ];
    let answer = post(&server, "/identify", true, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let found = answer.json();
    let period = |log: usize| {
        let choices = found["log_report"][log]["choices"].as_array().unwrap();
        choices.iter().find(|c| c["what"] == "period").unwrap()["value"].clone()
    };
    assert_eq!((period(0), period(1)), (json!("5.000000 s"), json!("4.000000 s")));
}
