//! Several processes on one PostgreSQL database: workers that die, hang and come back.

use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process, wait_until};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// A lease short enough to be waited for.
pub const LEASE: &[&str] = &["--lease-s", "1.5"];

pub struct Lab {
    folder: Folder,
    database: String,
}

impl Lab {
    pub fn new(name: &str) -> Self {
        Self {
            folder: Folder::new(name),
            database: Postgres::shared().database(),
        }
    }

    /// A machine of the lab: each has a folder of its own.
    pub fn machine(&self, name: &str) -> Place {
        Place {
            folder: self.folder.path().join(name),
            database: Some(self.database.clone()),
            network: None,
        }
    }

    /// A server that leaves all work to workers.
    pub fn server(&self) -> Process {
        let none = ["--concurrent-jobs", "0", "--short-jobs", "0"];
        Process::serve(&self.machine("server"), &[LEASE, &none].concat())
    }
}

pub fn search(seconds: f64) -> Value {
    json!({
        "robot": "iiwa14", "fourier": {"order": 5, "fundamental_hz": 0.1}, "sample_rate_hz": 50,
        "search": {"seed": 1, "time_limit_s": seconds}
    })
}

pub fn begun(server: &Process, seconds: f64) -> String {
    let (status, job) = server.post("/excitation", &search(seconds));
    assert_eq!(status, 202, "{job}");
    let id = job["id"].as_str().unwrap().to_string();
    wait_until("the job runs", || server.state(&id) == "running");
    id
}

pub fn result(server: &Process, id: &str) -> Value {
    let (status, result) = server.send("GET", &format!("/excitation/{id}"), &[("prefer", "wait=60")], "");
    assert_eq!(status, 200, "{result}");
    result
}

#[test]
fn a_killed_workers_job_is_done_by_another() {
    let lab = Lab::new("killed-worker");
    let server = lab.server();
    let first = Process::worker(&lab.machine("first"), LEASE);
    let id = begun(&server, 3.0);
    let second = Process::worker(&lab.machine("second"), LEASE);
    first.kill();
    assert!(result(&server, &id)["condition_number"].as_f64().unwrap() > 1.0);
    drop(second);
}

#[test]
fn a_worker_that_hangs_and_comes_back_changes_nothing() {
    let lab = Lab::new("hanging-worker");
    let server = lab.server();
    let first = Process::worker(&lab.machine("first"), LEASE);
    let id = begun(&server, 3.0);
    first.signal("STOP");
    let second = Process::worker(&lab.machine("second"), LEASE);
    let found = result(&server, &id);
    let job = server.get(&format!("/jobs/{id}")).1;
    first.signal("CONT");
    // Time enough for the first to finish its search and try to hand it in.
    std::thread::sleep(Duration::from_secs(5));
    assert_eq!(server.get(&format!("/jobs/{id}")).1, job);
    assert_eq!(server.get(&format!("/excitation/{id}")).1, found);
    drop(second);
}

#[test]
fn a_server_that_is_killed_and_started_again_takes_its_jobs_back_at_once() {
    let lab = Lab::new("restarted");
    // The lease is long: only the name in the data folder tells that the last process is gone.
    let lease = ["--lease-s", "600"];
    let server = Process::serve(&lab.machine("server"), &lease);
    let id = begun(&server, 2.0);
    server.kill();
    let started = Instant::now();
    let server = Process::serve(&lab.machine("server"), &lease);
    result(&server, &id);
    assert!(started.elapsed() < Duration::from_secs(60), "{:?}", started.elapsed());
}

#[test]
fn idle_workers_share_a_search_and_the_best_of_all_is_the_result() {
    let lab = Lab::new("shared-search");
    let server = lab.server();
    let first = Process::worker(&lab.machine("first"), LEASE);
    let id = begun(&server, 8.0);
    let others = ["second", "third"].map(|name| Process::worker(&lab.machine(name), LEASE));
    let job = format!("/jobs/{id}");
    wait_until("there is progress", || {
        server.get(&job).1["progress"]["evaluations"].as_u64() > Some(0)
    });
    // One that dies takes nothing with it but its own work.
    let [second, third] = others;
    std::thread::sleep(Duration::from_secs(4));
    second.kill();
    let started = Instant::now();
    let found = result(&server, &id);
    assert!(started.elapsed() < Duration::from_secs(12), "{:?}", started.elapsed());
    // The killed one's share never came in.
    assert_eq!(found["search"]["searches"], 2, "{}", found["search"]);
    assert_eq!(found["request"], search(8.0));
    drop((first, third));
}

/// A machine that joins late begins with what the first has found, and what it finds is the first's to go on from.
#[test]
fn searches_beside_each_other_hand_on_what_they_find() {
    let lab = Lab::new("exchange");
    let server = lab.server();
    let first = Process::worker(&lab.machine("first"), LEASE);
    let mut request = search(24.0);
    // What is found is reported after every round.
    request["search"]["jobs_per_round"] = json!(2);
    let id = server.post("/excitation", &request).1["id"].as_str().unwrap().to_string();
    let found = |number: i64| {
        let sql = format!("SELECT MIN(value) FROM found WHERE job = '{id}' AND number = {number}");
        Postgres::shared().ask(&lab.database, &sql).parse::<f64>().ok().map(f64::exp)
    };
    // Progress runs ahead of what is handed on, which is reported at the ends of rounds: what has been handed on counts.
    let some_time = Instant::now() + Duration::from_secs(6);
    wait_until("the first has found something", || {
        Instant::now() > some_time && found(0).is_some()
    });
    let best = found(0).unwrap();
    let second = Process::worker(&lab.machine("second"), LEASE);
    // What it writes first is not worse than what it was given: a search of its own would need seconds to come there.
    wait_until("the second has written", || found(1).is_some());
    let given = found(1).unwrap();
    assert!(given <= best * (1.0 + 1e-6), "{best} then {given}");
    assert!(result(&server, &id)["condition_number"].as_f64().unwrap() <= given * (1.0 + 1e-6));
    assert_eq!(
        Postgres::shared().ask(&lab.database, "SELECT COUNT(*) FROM found"),
        "0",
        "nothing is left"
    );
    drop((first, second));
}

/// Workers that may not take a waiting job, because its robot runs as many as it may, share the search that runs.
#[test]
fn a_job_that_has_to_wait_does_not_keep_workers_from_sharing() {
    let lab = Lab::new("bounded");
    let server = lab.server();
    let bounded = [LEASE, &["--running-per-robot", "1"]].concat();
    let first = Process::worker(&lab.machine("first"), &bounded);
    let id = begun(&server, 9.0);
    let mut other = search(1.0);
    other["search"] = json!({"seed": 2, "time_limit_s": 6});
    let waits = server.post("/excitation", &other).1["id"].as_str().unwrap().to_string();
    let second = Process::worker(&lab.machine("second"), &bounded);
    assert_eq!(result(&server, &id)["search"]["searches"], 2);
    assert_eq!(result(&server, &waits)["search"]["seed"], 2);
    drop((first, second));
}

#[test]
fn logs_reach_workers_through_the_database() {
    let lab = Lab::new("logs");
    let server = lab.server();
    let worker = Process::worker(&lab.machine("worker"), LEASE);
    let body = "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{\"robot\": \"planar_two_link\"}\r\n\
        --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"short.csv\"\r\n\r\ntime,q1\n0,1\n\r\n--b--\r\n";
    let headers = [("content-type", "multipart/form-data; boundary=b"), ("prefer", "wait=60")];
    let (status, problem) = server.send("POST", "/identify", &headers, body);
    // The worker has read the file: it knows what is wrong with its header.
    assert_eq!((status, problem["code"].as_str()), (422, Some("invalid_log")), "{problem}");
    assert!(
        problem["detail"].as_str().unwrap().starts_with("short.csv, line 1:"),
        "{problem}"
    );
    drop(worker);
}
