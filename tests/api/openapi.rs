//! The OpenAPI document is the one checked in, and says what the readers read.

use crate::server::{Server, quick_request};
use dynident::service::Config;
use serde_json::{Value, json};

fn checked_in() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/openapi/openapi.json")).unwrap()
}

#[test]
fn the_document_checked_in_is_the_one_made_from_the_code() {
    assert!(
        checked_in() == dynident::service::openapi_json(),
        "openapi/openapi.json is out of date; run: dynident openapi > openapi/openapi.json"
    );
}

#[test]
fn the_server_hands_out_the_same_document() {
    let server = Server::start();
    let checked_in: Value = serde_json::from_str(&checked_in()).unwrap();
    assert!(
        server.get("/openapi.json").json() == checked_in,
        "the server's document differs from openapi/openapi.json"
    );
}

/// The example of the document is one that the server accepts.
#[test]
fn the_example_works() {
    let server = Server::start();
    let document = server.get("/openapi.json").json();
    let mut example = document["components"]["schemas"]["ExcitationRequest"]["example"].clone();
    example["search"]["time_limit_s"] = json!(0.2);
    assert_eq!(server.excite(&example).status, 200);
}

/// Answers that take a history of their own, held against the document: the fuzzer seldom comes by them.
#[test]
fn answers_that_come_seldom_are_documented() {
    // Nobody does the work: a job that is cancelled has no result.
    let server = Server::with(Config {
        concurrent_jobs: 0,
        short_jobs: 0,
        largest_document: 20_000,
        ..Config::default()
    });
    let headers = [("content-type", "application/json"), ("idempotency-key", "again")];
    let begin = || server.send("POST", "/excitation", &headers, &quick_request().to_string());
    let job = begin();
    assert_eq!(job.status, 202, "{}", job.text);
    let cancelled = server.delete(&format!("/jobs/{}", job.json()["id"].as_str().unwrap()));
    assert_eq!(cancelled.status, 200, "{}", cancelled.text);
    let large = " ".repeat(30_000);
    let put = |path: &str, method: &str| server.send(method, path, &[("content-type", "application/json")], &large);
    let answers = [
        ("post", "/excitation", 409, begin()),
        ("post", "/robots", 413, put("/robots", "POST")),
        ("put", "/robots/{id}", 413, put("/robots/x", "PUT")),
    ];
    let document: Value = serde_json::from_str(&dynident::service::openapi_json()).unwrap();
    for (method, path, status, answer) in answers {
        assert_eq!(answer.status, status, "{method} {path}: {}", answer.text);
        let documented = &document["paths"][path][method]["responses"][status.to_string()];
        assert!(
            documented.is_object(),
            "{method} {path} answers {status}, and the document does not say so"
        );
    }
}
