//! Excitation jobs from request to trajectory.

use crate::server::{Server, long_request, quick_request};
use dynident::service::Config;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

#[test]
fn a_design_is_waited_for_and_comes_with_all_its_fields() {
    let server = Server::start();
    let answer = server.excite(&quick_request());
    assert_eq!(answer.status, 200, "{}", answer.text);
    assert_eq!(answer.header("preference-applied"), Some("wait=60"));
    assert!(answer.header("x-request-id").is_some());
    let result = answer.json();
    let condition = result["condition_number"].as_f64().unwrap();
    assert!(condition.is_finite() && condition >= 1.0);
    assert_eq!(result["criteria"]["condition_number"].as_f64().unwrap(), condition);
    for side in ["a", "b"] {
        // Outer joints, inner orders.
        let rows = result["coefficients"][side].as_array().unwrap();
        assert_eq!(rows.len(), 2);
        assert!(rows.iter().all(|r| r.as_array().unwrap().len() == 3));
    }
    assert_eq!(result["offset"].as_array().unwrap().len(), 2);
    assert_eq!(result["fundamental_hz"], 0.2);
    assert!(["Converged", "BudgetExhausted"].contains(&result["status"].as_str().unwrap()));
    // Both sides of position, velocity and acceleration of two joints; every limit is met.
    let margins = result["margins"].as_array().unwrap();
    assert_eq!(margins.len(), 12);
    for m in margins {
        let (peak, limit) = (m["certified_peak"].as_f64().unwrap(), m["limit"].as_f64().unwrap());
        assert!(if m["side"] == "upper" { peak <= limit } else { peak >= limit }, "{m}");
    }
    assert_eq!(result["request"], quick_request());
    let id = result["id"].as_str().unwrap();
    assert_eq!(answer.header("content-location"), Some(format!("/excitation/{id}").as_str()));
    assert_eq!(server.get(&format!("/excitation/{id}")).json(), result);
}

#[test]
fn a_trajectory_is_that_of_the_coefficients() {
    let server = Server::start();
    let result = server.excite(&quick_request()).json();
    let path = format!("/excitation/{}/trajectory", result["id"].as_str().unwrap());
    let csv = server.get(&format!("{path}?format=csv&rate_hz=200&periods=2"));
    assert_eq!(csv.status, 200);
    assert!(csv.header("content-type").unwrap().starts_with("text/csv"));
    let mut lines = csv.text.lines();
    assert_eq!(lines.next(), Some("time,q1,q2,qd1,qd2,qdd1,qdd2"));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 2001);
    let w = std::f64::consts::TAU * 0.2;
    let number = |v: &Value| v.as_f64().unwrap();
    for row in rows.iter().step_by(37) {
        for joint in 0..2 {
            let (a, b) = (&result["coefficients"]["a"][joint], &result["coefficients"]["b"][joint]);
            let mut expected = [number(&result["offset"][joint]), 0.0, 0.0];
            for l in 1..=3 {
                let (a, b, f) = (number(&a[l - 1]), number(&b[l - 1]), w * l as f64);
                let (s, c) = (f * row[0]).sin_cos();
                expected[0] += a / f * s - b / f * c;
                expected[1] += a * c + b * s;
                expected[2] += f * (b * c - a * s);
            }
            for (k, value) in expected.iter().enumerate() {
                // CSV has ten decimals; the second period is computed at the phases of the first: the sine's argument rounds
                // differently, by 1e-15 relative.
                assert!((row[1 + 2 * k + joint] - value).abs() < 0.5e-10 + 1e-12, "{row:?}");
            }
        }
    }
    let table = server.get(&format!("{path}?format=json")).json();
    assert_eq!(table["rate_hz"], 50.0);
    assert_eq!(table["rows"].as_array().unwrap().len(), 251);
    // At rest at the start, exactly.
    assert_eq!(table["rows"][0][3], 0.0);
    let wrong = server.get(&format!("{path}?format=xls&rate_hz=-1&perods=2"));
    assert_eq!(wrong.status, 400);
    assert_eq!(wrong.errors().len(), 3, "{:?}", wrong.errors());
}

#[test]
fn without_waiting_the_answer_is_the_job() {
    let server = Server::start();
    let answer = server.post_json("/excitation", &quick_request().to_string());
    assert_eq!(answer.status, 202);
    let place = answer.header("location").unwrap().to_string();
    let job = answer.json();
    assert_eq!(place, format!("/jobs/{}", job["id"].as_str().unwrap()));
    assert_eq!(job["links"]["self"], place);
    let result = server.send("GET", job["links"]["result"].as_str().unwrap(), &[("prefer", "wait=60")], "");
    assert_eq!(result.status, 200);
    let job = server.get(&place).json();
    assert_eq!(job["state"], "finished");
    assert_eq!(job["outcome"], result.json()["status"]);
    assert_eq!(server.get("/jobs").json()["jobs"][0]["id"], job["id"]);
}

#[test]
fn a_running_search_is_cancelled_within_a_second_and_keeps_the_best() {
    let server = Server::start();
    let answer = server.post_json("/excitation", &long_request().to_string());
    let id = answer.json()["id"].as_str().unwrap().to_string();
    let job = format!("/jobs/{id}");
    wait_until(|| server.get(&job).json()["progress"]["starts_finished"].as_u64() > Some(0));
    assert_eq!(server.get(&format!("/excitation/{id}")).status, 202);
    assert_eq!(
        server.get(&format!("/excitation/{id}/trajectory")).problem()["code"],
        "no_trajectory"
    );
    let asked = Instant::now();
    let cancelled = server.delete(&job);
    assert_eq!(cancelled.status, 202);
    assert_eq!(cancelled.json()["cancel_requested"], true);
    let result = server.send("GET", &format!("/excitation/{id}"), &[("prefer", "wait=30")], "");
    assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
    assert_eq!(result.status, 200);
    assert_eq!(result.json()["status"], "Cancelled");
    assert!(result.json()["condition_number"].as_f64().unwrap() > 1.0);
    assert_eq!(server.get(&job).json()["state"], "cancelled");
    // Again: nothing changes.
    assert_eq!(server.delete(&job).status, 200);
    assert_eq!(server.get(&format!("/excitation/{id}/trajectory")).status, 200);
}

#[test]
fn a_time_limit_is_honoured_within_a_second() {
    let server = Server::start();
    let mut request = long_request();
    request["search"]["time_limit_s"] = json!(1.5);
    let asked = Instant::now();
    let answer = server.excite(&request);
    let elapsed = asked.elapsed().as_secs_f64();
    assert!((1.4..2.5).contains(&elapsed), "{elapsed}");
    let status = answer.json()["status"].clone();
    assert!(
        ["BudgetExhausted", "Converged"].contains(&status.as_str().unwrap()),
        "{status}"
    );
}

#[test]
fn a_time_limit_is_honoured_beside_another_search() {
    let server = Server::with(Config {
        concurrent_jobs: 2,
        ..Config::default()
    });
    server.post_json("/excitation", &long_request().to_string());
    let mut request = long_request();
    request["search"]["time_limit_s"] = json!(1.5);
    let asked = Instant::now();
    assert_eq!(server.excite(&request).status, 200);
    let elapsed = asked.elapsed().as_secs_f64();
    assert!((1.4..2.5).contains(&elapsed), "{elapsed}");
}

#[test]
fn jobs_wait_their_turn_and_can_be_cancelled_while_they_wait() {
    let server = Server::with(Config {
        waiting_jobs: 2,
        ..Config::default()
    });
    let post = || server.post_json("/excitation", &long_request().to_string());
    let running = post().json()["id"].as_str().unwrap().to_string();
    wait_until(|| server.get(&format!("/jobs/{running}")).json()["state"] == "running");
    let waiting = post().json()["id"].as_str().unwrap().to_string();
    assert_eq!(server.get(&format!("/jobs/{waiting}")).json()["state"], "queued");
    // One is taken from the queue ahead of its turn, two may wait, the next is refused.
    let refused = (0..3)
        .map(|_| post())
        .find(|a| a.status != 202)
        .expect("the queue is bounded");
    assert_eq!(refused.status, 503);
    assert_eq!(refused.problem()["code"], "too_many_jobs");
    assert!(refused.header("retry-after").is_some());
    assert_eq!(server.delete(&format!("/jobs/{waiting}")).status, 200);
    assert_eq!(server.get(&format!("/excitation/{waiting}")).problem()["code"], "no_result");
}

#[test]
fn a_key_makes_a_retry_the_same_job() {
    let server = Server::start();
    let post = |request: &Value| {
        let headers = [("content-type", "application/json"), ("idempotency-key", "abc")];
        server.send("POST", "/excitation", &headers, &request.to_string())
    };
    let first = post(&quick_request());
    assert_eq!(post(&quick_request()).json()["id"], first.json()["id"]);
    let other = post(&long_request());
    assert_eq!(
        (other.status, other.problem()["code"].as_str()),
        (422, Some("idempotency_key_reused"))
    );
}

/// The same bytes at another address ask for other work: a key does not hand out the job of the first.
#[test]
fn regress_a_key_belongs_to_one_kind_of_work() {
    // Nobody does the work: the first job is still there as it was when its key comes again.
    let server = Server::with(Config {
        concurrent_jobs: 0,
        short_jobs: 0,
        ..Config::default()
    });
    let body = "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{\"robot\": \"planar_two_link\"}\r\n\
        --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\nx\r\n--b--\r\n";
    let post = |path: &str| {
        let kind = ("content-type", "multipart/form-data; boundary=b");
        server.send("POST", path, &[kind, ("idempotency-key", "abc")], body)
    };
    let first = post("/identify");
    assert_eq!(first.status, 202, "{}", first.text);
    assert_eq!(post("/identify").json()["id"], first.json()["id"]);
    // The key is looked at before the document, with which this address could do nothing.
    let other = post("/validate");
    assert_eq!(
        (other.status, other.problem()["code"].as_str()),
        (422, Some("idempotency_key_reused"))
    );
    assert!(
        other.text.contains("for another kind of work (identification)"),
        "{}",
        other.text
    );
}

/// `(event, id, data)` of every event until the server ends the stream.
fn events(server: &Server, path: &str, last: Option<&str>) -> Vec<(String, u64, Value)> {
    let mut stream = TcpStream::connect(server.address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let last = last.map(|id| format!("Last-Event-ID: {id}\r\n")).unwrap_or_default();
    write!(
        stream,
        "GET {path} HTTP/1.0\r\nHost: localhost\r\nAccept: text/event-stream\r\n{last}\r\n"
    )
    .unwrap();
    let mut found = Vec::new();
    let (mut name, mut id) = (String::new(), 0);
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        match line.split_once(": ").or(line.split_once(':')) {
            Some(("event", value)) => name = value.to_string(),
            Some(("id", value)) => id = value.parse().unwrap(),
            Some(("data", value)) => found.push((name.clone(), id, serde_json::from_str(value).unwrap())),
            _ => {}
        }
    }
    found
}

#[test]
fn events_tell_progress_and_the_end() {
    let server = Server::start();
    let mut request = long_request();
    request["search"] = json!({"seed": 1, "starts": 5000, "time_limit_s": 3});
    let id = server.post_json("/excitation", &request.to_string()).json()["id"]
        .as_str()
        .unwrap()
        .to_string();
    let path = format!("/jobs/{id}/events");
    let all = events(&server, &path, None);
    let (name, last, job) = all.last().unwrap();
    assert_eq!((name.as_str(), job["state"].as_str()), ("end", Some("finished")));
    assert!(all.windows(2).all(|w| w[0].1 < w[1].1));
    let progress: Vec<_> = all
        .iter()
        .filter(|e| e.0 == "progress" && !e.2["progress"].is_null())
        .collect();
    assert!(!progress.is_empty());
    let bests: Vec<f64> = progress.iter().filter_map(|e| e.2["progress"]["best"].as_f64()).collect();
    assert!(!bests.is_empty() && bests.windows(2).all(|w| w[1] <= w[0]), "{bests:?}");
    assert!(progress.last().unwrap().2["progress"]["evaluations"].as_u64().unwrap() > 0);
    // After a break: only what came later; after the end: nothing.
    let again = events(&server, &path, Some(&(last - 1).to_string()));
    assert_eq!(again.len(), 1);
    assert_eq!(
        server.send("GET", &path, &[("last-event-id", &last.to_string())], "").status,
        204
    );
}

#[test]
fn a_server_that_ends_hands_over_what_was_found() {
    let mut server = Server::start();
    let address = server.address;
    let waiter = std::thread::spawn(move || {
        let body = long_request().to_string();
        let mut stream = TcpStream::connect(address).unwrap();
        let length = body.len();
        let head = "POST /excitation HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nPrefer: wait=60\r\nContent-Type: application/json";
        write!(stream, "{head}\r\nContent-Length: {length}\r\n\r\n{body}").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    });
    wait_until(|| {
        let jobs = server.get("/jobs").json();
        jobs["jobs"]
            .as_array()
            .unwrap()
            .iter()
            .any(|j| j["progress"]["starts_finished"].as_u64() > Some(0))
    });
    let asked = Instant::now();
    server.stop();
    assert!(asked.elapsed() < Duration::from_secs(3), "{:?}", asked.elapsed());
    let answer = waiter.join().unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    assert!(answer.contains("\"Cancelled\""));
}

fn wait_until(condition: impl Fn() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(60), "waited in vain");
        std::thread::sleep(Duration::from_millis(20));
    }
}
