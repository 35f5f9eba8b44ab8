//! Uploads that are not what they should be: parts missing, cut off, of another type. None is a job, and the server goes on.

use super::server::Server;
use super::ways::{MULTIPART, multipart};
use super::written::{good_rows, log, unreadable};
use serde_json::json;

#[test]
fn no_upload_stops_the_server() {
    let server = Server::start();
    let request = json!({"robot": "planar_two_link"});
    let text = log(good_rows()).into_bytes();
    let whole = multipart(&request, &[("log.csv".into(), text.clone())]);
    let without = multipart(&request, &[]);
    let only_log = String::from_utf8(multipart(&request, &[("log.csv".into(), text.clone())])).unwrap();
    let only_log = only_log
        .split_once("--XXboundary\r\n")
        .unwrap()
        .1
        .split_once("--XXboundary\r\n")
        .unwrap()
        .1;
    let only_log = format!("--XXboundary\r\n{only_log}");
    let bodies: Vec<(&str, &str, Vec<u8>)> = vec![
        ("no log", MULTIPART, without),
        ("no request", MULTIPART, only_log.into_bytes()),
        ("nothing", MULTIPART, Vec::new()),
        ("no parts", MULTIPART, b"--XXboundary--\r\n".to_vec()),
        ("cut off in the log", MULTIPART, whole[..whole.len() / 2].to_vec()),
        ("cut off in the request", MULTIPART, whole[..90].to_vec()),
        ("another boundary", "multipart/form-data; boundary=other", whole.clone()),
        ("no boundary", "multipart/form-data", whole.clone()),
        ("JSON", "application/json", request.to_string().into_bytes()),
        ("CSV", "text/csv", text.clone()),
        ("no type", "", whole.clone()),
        (
            "a form",
            "application/x-www-form-urlencoded",
            b"robot=planar_two_link".to_vec(),
        ),
        (
            "an empty log",
            MULTIPART,
            multipart(&request, &[("log.csv".into(), Vec::new())]),
        ),
        (
            "a null request",
            MULTIPART,
            multipart(&json!(null), &[("log.csv".into(), text.clone())]),
        ),
        (
            "a list for a request",
            MULTIPART,
            multipart(&json!([1, 2]), &[("log.csv".into(), text.clone())]),
        ),
        (
            "an unknown field",
            MULTIPART,
            multipart(
                &json!({"robot": "planar_two_link", "x": 1}),
                &[("log.csv".into(), text.clone())],
            ),
        ),
        (
            "an unknown robot",
            MULTIPART,
            multipart(&json!({"robot": "nobody"}), &[("log.csv".into(), text.clone())]),
        ),
    ];
    for (name, kind, body) in &bodies {
        for path in ["/identify", "/identify/preview", "/validate"] {
            let answer = server.post_raw(path, kind, body, None);
            assert!(
                (400..500).contains(&answer.status),
                "{name} to {path}: {} {}",
                answer.status,
                answer.text
            );
            assert_eq!(unreadable(&answer.text), None, "{name} to {path}: {}", answer.text);
            assert!(answer.problem()["code"].is_string(), "{name} to {path}");
        }
    }
    for (path, kind) in [
        ("/excitation", "text/plain"),
        ("/motion", MULTIPART),
        ("/robots", "application/xml"),
        ("/logs/columns", "application/json"),
    ] {
        let answer = server.post_raw(path, kind, b"<robot/>", None);
        assert!(
            (400..500).contains(&answer.status),
            "{path}: {} {}",
            answer.status,
            answer.text
        );
    }
    // Clients that say more than they send, and hang up.
    for path in ["/identify", "/identify/preview", "/motion", "/excitation"] {
        server.post_raw(path, MULTIPART, &whole[..200], Some(whole.len()));
    }
    assert_eq!(server.get("/jobs").json()["jobs"].as_array().map_or(0, Vec::len), 0);
    let names = [
        "../../etc/passwd",
        "a\u{202e}b.csv",
        "x".repeat(300).as_str(),
        "log.csv.gz",
        "lög ü.csv",
        "-",
        "fault.csv;x",
        "a'b.csv",
        "%00.csv",
    ]
    .map(String::from);
    for name in names {
        let answer = server.post_raw(
            "/identify/preview",
            MULTIPART,
            &multipart(&request, &[(name.clone(), text.clone())]),
            None,
        );
        assert!(
            matches!(answer.status, 200 | 400 | 422),
            "{name}: {} {}",
            answer.status,
            answer.text
        );
    }
    assert_eq!(server.get("/health/live").status, 200);
}
