//! Bad input gets the right status, the right code, and every bad field at once.

use crate::server::{Server, quick_request};
use dynident::service::Config;
use serde_json::json;
use std::io::{Read, Write};

#[test]
fn all_bad_fields_are_named_at_once() {
    let server = Server::start();
    let body = r#"{
        "robot": {"name": "x", "joints": [
            {"name": "A1", "kind": "revolute", "mdh": {"alpha": 90, "d": 0, "theta": 0, "r": 420},
             "limits": {"position": [-170, 170], "velocity": 85, "effort": NaN}},
            {"name": "A1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0}, "limits": {"position": [1, -1], "jerk": -3}}]},
        "fourier": {"order": 0, "fundamental_hz": 0.1}, "sample_rate_hz": 1e999, "speed": 1,
        "search": {"seed": -1, "starts": 2.5}}"#;
    let answer = server.post_json("/excitation", body);
    assert_eq!(answer.status, 422, "{}", answer.text);
    assert_eq!(answer.problem()["code"], "invalid_document");
    let errors = answer.errors();
    let expected = [
        "/robot/joints/0/limits/effort: is NaN",
        "/sample_rate_hz: is too large",
        "/speed: is not a field",
        "/robot/joints/0/mdh/alpha: is 90 rad, more than a full turn (angles are in radians; this looks like degrees",
        "/robot/joints/0/mdh/r: is 420 m (lengths are in metres; this looks like millimetres",
        "/robot/joints/0/limits/position: is [-170, 170] rad (limits of revolute joints are in radians; this looks like degrees",
        "/robot/joints/0/limits/velocity: is 85 rad/s (limits of revolute joints are in radians; this looks like degrees",
        "/robot/joints/1/name: `A1` is already the name of joint 1",
        "/robot/joints/1/mdh/r: is missing",
        "/robot/joints/1/limits/position: is [1, -1]: the lower limit must be below the upper one (did you mean [-1, 1]?",
        "/robot/joints/1/limits/jerk: is -3",
        "/fourier/order: is 0",
        "/search/seed: is -1",
        "/search/starts: is 2.5",
    ];
    for text in expected {
        assert!(errors.iter().any(|e| e.starts_with(text)), "{text} not in {errors:#?}");
    }
    assert_eq!(errors.len(), expected.len(), "{errors:#?}");
}

#[test]
fn more_harmonics_than_the_samples_carry_are_refused() {
    let server = Server::start();
    let mut request = quick_request();
    request["sample_rate_hz"] = json!(1);
    let answer = server.post_json("/excitation", &request.to_string());
    assert_eq!(answer.status, 422);
    assert!(
        answer.errors()[0].starts_with("/fourier/order: 3 harmonics need more than 6 samples"),
        "{:?}",
        answer.errors()
    );
}

#[test]
fn unreadable_documents_are_refused() {
    let server = Server::start();
    let deep = format!("{{\"robot\": {}", "[".repeat(100_000));
    let bodies = [" ", "{\"robot\": ", "{'robot': 1}", "nonsense", &deep];
    for body in bodies {
        let answer = server.post_json("/excitation", body);
        assert_eq!(
            (answer.status, answer.problem()["code"].as_str()),
            (400, Some("malformed_document")),
            "{body:.20}"
        );
    }
    for body in ["[]", "null", "3"] {
        assert_eq!(server.post_json("/excitation", body).status, 422, "{body}");
    }
}

#[test]
fn huge_documents_are_refused() {
    let server = Server::with(Config {
        largest_document: 10_000,
        ..Config::default()
    });
    let answer = server.post_json("/excitation", &format!("{{\"robot\": \"{}\"}}", "x".repeat(20_000)));
    assert_eq!(
        (answer.status, answer.problem()["code"].as_str()),
        (413, Some("payload_too_large"))
    );
    // With no length announced, it is cut off while it comes.
    let mut stream = std::net::TcpStream::connect(server.address).unwrap();
    let head =
        "POST /excitation HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    stream
        .write_all(format!("4e20\r\n{}\r\n0\r\n\r\n", " ".repeat(20_000)).as_bytes())
        .unwrap();
    let mut start = [0; 12];
    stream.read_exact(&mut start).unwrap();
    assert_eq!(&start, b"HTTP/1.1 413");
}

#[test]
fn a_document_within_the_limit_may_have_many_errors_but_the_answer_stays_small() {
    let server = Server::start();
    let mut request = quick_request();
    request["torque_noise"] = json!(vec![None::<f64>; 200_000]);
    let answer = server.post_json("/excitation", &request.to_string());
    assert_eq!(answer.status, 422);
    assert!(answer.text.len() < 50_000, "{}", answer.text.len());
}

#[test]
fn the_type_of_the_document_is_checked() {
    let server = Server::start();
    let body = quick_request().to_string();
    for kind in ["text/plain", "application/x-www-form-urlencoded", "application/xml"] {
        let answer = server.send("POST", "/excitation", &[("content-type", kind)], &body);
        assert_eq!(
            (answer.status, answer.problem()["code"].as_str()),
            (415, Some("unsupported_media_type")),
            "{kind}"
        );
    }
    let answer = server.send(
        "POST",
        "/excitation",
        &[("content-type", "application/json; charset=utf-8"), ("prefer", "wait=30")],
        &body,
    );
    assert_eq!(answer.status, 200);
}

#[test]
fn unknown_addresses_methods_and_ids_are_problems_too() {
    let server = Server::start();
    let unknown = [
        ("/nothing", "not_found"),
        ("/jobs/1", "unknown_job"),
        ("/jobs/1/events", "unknown_job"),
    ];
    let unknown = unknown.iter().chain(&[
        ("/excitation/1", "unknown_excitation"),
        ("/excitation/1/trajectory", "unknown_excitation"),
        ("/robots/x", "unknown_robot"),
        ("/robots/x/base-parameters", "unknown_robot"),
    ]);
    for (path, code) in unknown {
        let answer = server.get(path);
        assert_eq!(
            (answer.status, answer.problem()["code"].as_str()),
            (404, Some(*code)),
            "{path}"
        );
    }
    assert_eq!(server.delete("/jobs/1").problem()["code"], "unknown_job");
    for (method, path) in [
        ("GET", "/excitation"),
        ("PATCH", "/jobs"),
        ("POST", "/jobs/1"),
        ("DELETE", "/health/live"),
    ] {
        let answer = server.send(method, path, &[], "");
        assert_eq!(
            (answer.status, answer.problem()["code"].as_str()),
            (405, Some("method_not_allowed")),
            "{method} {path}"
        );
        assert!(answer.header("allow").is_some(), "{method} {path}: {answer:?}");
    }
}

/// Bytes that are no text, in the place of every name that an address may hold: refused as anything else is.
#[test]
fn regress_addresses_that_are_no_text_are_problems_too() {
    let server = Server::start();
    let document: serde_json::Value = serde_json::from_str(&dynident::service::openapi_json()).unwrap();
    let mut checked = 0;
    for (path, operations) in document["paths"].as_object().unwrap() {
        if !path.contains('{') {
            continue;
        }
        for method in operations.as_object().unwrap().keys() {
            let answer = server.send(
                &method.to_uppercase(),
                &path.replace("{id}", "%FF").replace("{name}", "%FF"),
                &[],
                "",
            );
            assert_eq!(
                (answer.status, answer.problem()["code"].as_str()),
                (400, Some("malformed_address")),
                "{method} {path}"
            );
            assert!(operations[method]["responses"]["400"].is_object(), "{method} {path}");
            checked += 1;
        }
    }
    assert!(checked >= 12, "{checked} addresses with a name");
    for path in ["/assets/%FF", "/nothing/%C3"] {
        assert_eq!(server.get(path).problem()["code"], "malformed_address", "{path}");
    }
    // Text of whatever language is an address of nothing.
    assert_eq!(server.get("/jobs/%C3%A4").problem()["code"], "unknown_job");
}

#[test]
fn a_joint_without_any_limit_is_refused_with_the_remedy() {
    let server = Server::start();
    let mut request = quick_request();
    request["robot"] =
        json!({"name": "free", "joints": [{"name": "J1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}}]});
    let errors = server.post_json("/excitation", &request.to_string()).errors();
    assert!(
        errors[0]
            .starts_with("/robot/joints/0/limits: joint `J1` has no limit on its velocity, acceleration or jerk (give at least"),
        "{errors:?}"
    );
}
