//! kill -9 of the server in a loop: every acknowledged job has exactly one result, and that is the right one.

use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process};
use dynident::app::{CancelFlag, excite};
use dynident::io::shipped::Shipped;
use dynident::io::{parse, read_excitation_request};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::time::Duration;

/// A search whose result depends on its seed alone.
fn request(seed: usize) -> Value {
    json!({
        "robot": "planar_two_link", "fourier": {"order": 2, "fundamental_hz": 0.2}, "sample_rate_hz": 20,
        "search": {"seed": seed, "starts": 2, "max_evaluations": 100}
    })
}

/// The same search, done here.
fn expected(seed: usize) -> Value {
    let parsed = parse(request(seed).to_string().as_bytes()).unwrap();
    let request = read_excitation_request(&parsed, &Shipped).unwrap();
    json!(excite(&request, &CancelFlag::default(), &|_| {}).document.coefficients)
}

/// Asks for jobs until each has been acknowledged, kills the server at every age between 30 and 330 ms, and counts what is left.
fn survives(place: &Place, jobs: usize) {
    let mut acknowledged: BTreeMap<usize, String> = BTreeMap::new();
    let mut kills = 0;
    loop {
        let server = Process::serve(place, &[]);
        let left = server.get("/jobs?limit=1000").1["jobs"]
            .as_array()
            .map(|all| all.iter().filter(|j| j["state"] != "finished").count());
        if acknowledged.len() == jobs && left == Some(0) {
            check(&server, &acknowledged);
            break;
        }
        // The ages of the server at its death are spread over all that it does, not random: a failure can be repeated.
        let age = Duration::from_millis(30 + (kills * 97) % 300);
        std::thread::scope(|scope| {
            let server = &server;
            let (told, asked) = std::sync::mpsc::channel();
            let todo: Vec<usize> = (0..jobs).filter(|k| !acknowledged.contains_key(k)).take(6).collect();
            scope.spawn(move || {
                for k in todo {
                    let key = format!("key-{k}");
                    let headers = [("content-type", "application/json"), ("idempotency-key", key.as_str())];
                    let (status, job) = server.send("POST", "/excitation", &headers, &request(k).to_string());
                    if status == 202 || status == 200 {
                        told.send((k, job["id"].as_str().unwrap().to_string())).unwrap();
                    }
                }
            });
            std::thread::sleep(age);
            server.signal("KILL");
            acknowledged.extend(asked.iter());
        });
        kills += 1;
        assert!(
            kills < 100 * jobs as u64,
            "it never ends: {} of {jobs} acknowledged, {left:?} unfinished",
            acknowledged.len()
        );
    }
    println!("{jobs} jobs, the server was killed {kills} times");
    assert!(kills >= jobs as u64 / 6, "the server was killed {kills} times only");
}

fn check(server: &Process, acknowledged: &BTreeMap<usize, String>) {
    let all = server.get("/jobs?limit=1000").1["jobs"].as_array().unwrap().len();
    // A job that was kept, but whose acknowledgement was lost, was found again by its key.
    assert_eq!(all, acknowledged.len());
    for (seed, id) in acknowledged {
        let (status, result) = server.get(&format!("/excitation/{id}"));
        assert_eq!(status, 200, "{result}");
        assert_eq!(result["coefficients"], expected(*seed), "job {seed}");
    }
}

fn jobs() -> usize {
    std::env::var("DYNIDENT_KILL_JOBS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(24)
}

#[test]
fn killed_again_and_again_on_sqlite_every_job_has_one_right_result() {
    let folder = Folder::new("kill-sqlite");
    survives(&folder.place(), jobs());
}

#[test]
fn killed_again_and_again_on_postgresql_every_job_has_one_right_result() {
    let folder = Folder::new("kill-postgres");
    let place = Place {
        database: Some(Postgres::shared().database()),
        ..folder.place()
    };
    survives(&place, jobs());
}
