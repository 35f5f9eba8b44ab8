//! Uploads as they go wrong on their way.

use crate::identify::log;
use crate::server::{Answer, Server};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::json;
use std::io::Write as _;

const MULTIPART: &str = "multipart/form-data; boundary=XXboundary";

fn body(name: &str, content: &[u8]) -> Vec<u8> {
    let request = json!({"robot": "planar_two_link", "trace": false});
    let mut body = format!("--XXboundary\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{request}\r\n").into_bytes();
    write!(
        body,
        "--XXboundary\r\nContent-Disposition: form-data; name=\"log\"; filename=\"{name}\"\r\n\r\n"
    )
    .unwrap();
    body.extend_from_slice(content);
    body.extend_from_slice(b"\r\n--XXboundary--\r\n");
    body
}

fn upload(server: &Server, name: &str, content: &[u8]) -> Answer {
    server.post_raw("/identify", MULTIPART, &body(name, content), None)
}

fn zipped(text: &str) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(text.as_bytes()).unwrap();
    gzip.finish().unwrap()
}

#[test]
fn a_compressed_log_is_read_and_half_of_one_is_refused_by_name() {
    let server = Server::start();
    let whole = zipped(&log(0.3));
    let answer = upload(&server, "run.csv.gz", &whole);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let answer = upload(&server, "run.csv.gz", &whole[..whole.len() / 2]);
    assert_eq!(answer.status, 422, "{}", answer.text);
    let problem = answer.problem();
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        problem["code"] == "invalid_log" && detail.starts_with("run.csv.gz") && detail.contains("cut off"),
        "{detail}"
    );
}

#[test]
fn files_that_are_no_logs_are_refused_and_the_server_goes_on() {
    let server = Server::start();
    let refused = |name: &str, content: &[u8], word: &str| {
        let answer = upload(&server, name, content);
        assert_eq!(answer.status, 422, "{name}: {}", answer.text);
        let problem = answer.problem();
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.starts_with(name) && detail.contains(word), "{detail}");
    };
    refused("nothing.csv", b"", "is empty");
    refused("header.csv", &vec![b'x'; 3 << 20], "header is longer");
    refused(
        "picture.png",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        "is a picture; export it as CSV",
    );
    refused(
        "bad.csv.gz",
        &[&[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3][..], &[0xff; 200]].concat(),
        "cannot be read",
    );
    assert_eq!(upload(&server, "run.csv", log(0.3).as_bytes()).status, 200);
}

#[test]
fn an_upload_that_is_interrupted_starts_no_job_and_the_server_goes_on() {
    let server = Server::start();
    let whole = body("run.csv", log(0.3).as_bytes());
    let half = &whole[..whole.len() / 2];
    let answer = server.post_raw("/identify", MULTIPART, half, Some(whole.len()));
    assert!(answer.status == 0 || answer.status == 400, "{answer:?}");
    // The same, but with a length that is the half's own: the parts end in the middle.
    let answer = server.post_raw("/identify", MULTIPART, half, None);
    assert_eq!(answer.status, 400, "{}", answer.text);
    assert_eq!(answer.problem()["code"], "malformed_document");
    let jobs = server.get("/jobs").json();
    assert_eq!(jobs["jobs"].as_array().map(Vec::len), Some(0), "{jobs}");
    assert_eq!(upload(&server, "run.csv", log(0.3).as_bytes()).status, 200);
}
