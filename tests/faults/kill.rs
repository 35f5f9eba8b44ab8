//! kill -9 of the server in a loop: every acknowledged job has exactly one result, and that is the right one.

use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process, wait_until};
use dynident::app::{CancelFlag, excite};
use dynident::documents::read_excitation_request;
use dynident::documents::shipped::Shipped;
use dynident::formats::parse;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

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

/// A search that no life of the server is long enough for.
fn slow() -> Value {
    let mut slow = request(0);
    slow["search"] = json!({"seed": 1, "starts": 2, "max_evaluations": 4000});
    slow
}

/// Asks for jobs until each has been acknowledged, one or two in every life of the server, kills it at every age between 30 and
/// 330 ms, and counts what is left. A search that is begun in every one of those lives has not failed either.
fn survives(place: &Place, jobs: usize) {
    let mut acknowledged: BTreeMap<usize, String> = BTreeMap::new();
    let mut kills = 0;
    let arguments = ["--concurrent-jobs", "2"];
    let first = Process::serve(place, &arguments);
    let slow = first.post("/excitation", &slow()).1["id"].as_str().unwrap().to_string();
    first.kill();
    loop {
        let server = Process::serve(place, &arguments);
        let left = server.get("/jobs?limit=1000").1["jobs"]
            .as_array()
            .map(|all| all.iter().filter(|j| j["state"] != "finished").count());
        if acknowledged.len() == jobs && kills >= jobs {
            wait_until("the rest is done", || {
                let all = server.get("/jobs?limit=1000").1;
                all["jobs"].as_array().unwrap().iter().all(|j| j["state"] == "finished")
            });
            check(&server, &acknowledged, &slow);
            break;
        }
        // The ages of the server at its death are spread over all that it does, not random: a failure can be repeated.
        let age = Duration::from_millis(30 + (kills as u64 * 97) % 300);
        std::thread::scope(|scope| {
            let server = &server;
            let (reported, asked) = std::sync::mpsc::channel();
            let todo: Vec<usize> = (0..jobs).filter(|k| !acknowledged.contains_key(k)).take(2).collect();
            scope.spawn(move || {
                for k in todo {
                    let key = format!("key-{k}");
                    let headers = [("content-type", "application/json"), ("idempotency-key", key.as_str())];
                    let (status, job) = server.send("POST", "/excitation", &headers, &request(k).to_string());
                    if status == 202 || status == 200 {
                        reported.send((k, job["id"].as_str().unwrap().to_string())).unwrap();
                    }
                }
            });
            std::thread::sleep(age);
            server.signal("KILL");
            acknowledged.extend(asked.iter());
        });
        kills += 1;
        assert!(
            kills < 100 * jobs,
            "it never ends: {} of {jobs} acknowledged, {left:?} unfinished",
            acknowledged.len()
        );
    }
    println!("{jobs} jobs, the server was killed {kills} times");
}

fn check(server: &Process, acknowledged: &BTreeMap<usize, String>, slow: &str) {
    let all = server.get("/jobs?limit=1000").1["jobs"].as_array().unwrap().len();
    // A job that was kept, but whose acknowledgement was lost, was found again by its key.
    assert_eq!(all, acknowledged.len() + 1);
    assert_eq!(server.get(&format!("/excitation/{slow}")).0, 200);
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
        .unwrap_or(60)
}

#[test]
fn killed_again_and_again_on_sqlite_every_job_has_one_right_result() {
    let folder = Folder::new("kill-sqlite");
    survives(&folder.place(), jobs());
}

#[test]
fn killed_again_and_again_on_postgresql_every_job_has_one_right_result() {
    let folder = Folder::new("kill-postgres");
    survives(&on_postgres(&folder), jobs());
}

fn on_postgres(folder: &Folder) -> Place {
    Place {
        database: Some(Postgres::shared().database()),
        ..folder.place()
    }
}

/// Kills the server late in a search that is limited by time: the next one has the rest of the time, and what was found.
fn goes_on(place: &Place) {
    const LIMIT_S: f64 = 16.0;
    let server = Process::serve(place, &[]);
    let mut long = request(1);
    long["robot"] = json!("iiwa14");
    long["search"] = json!({"seed": 1, "time_limit_s": LIMIT_S});
    let (_, job) = server.post("/excitation", &long);
    let path = format!("/jobs/{}", job["id"].as_str().unwrap());
    let progress = |server: &Process| server.get(&path).1["progress"].clone();
    wait_until("most of the time is over", || {
        progress(&server)["elapsed_s"].as_f64() > Some(7.0)
    });
    let reported = progress(&server);
    // What was found is written down every other second, and the time spent at least every ten: all that was reported is safe
    // after those.
    wait_until("it is written down", || progress(&server)["elapsed_s"].as_f64() > Some(13.0));
    server.kill();
    let again = Instant::now();
    let server = Process::serve(place, &[]);
    let (status, result) = server.send("GET", job["links"]["result"].as_str().unwrap(), &[("prefer", "wait=60")], "");
    assert_eq!(status, 200, "{result}");
    // At most the ten seconds that it may not know of, beside what was left.
    assert!(
        again.elapsed() < Duration::from_secs_f64(LIMIT_S - 3.0 + 1.0),
        "{:?}",
        again.elapsed()
    );
    // What is handed out keeps clear of the limits by 1e-8 of them, and its value differs by a few times as much.
    let best = reported["best"].as_f64().unwrap();
    assert!(
        result["condition_number"].as_f64().unwrap() <= best * (1.0 + 1e-6),
        "{reported} then {result}"
    );
    let search = &result["search"];
    assert!(search["elapsed_s"].as_f64().unwrap() < LIMIT_S + 1.0, "{search}");
    assert!(
        search["evaluations"].as_u64() > reported["evaluations"].as_u64(),
        "{reported} then {search}"
    );
    assert_eq!(
        (&result["request"], server.get(&path).1["state"].as_str()),
        (&long, Some("finished"))
    );
}

#[test]
fn a_search_that_was_killed_goes_on_from_its_best_on_sqlite() {
    goes_on(&Folder::new("goes-on-sqlite").place());
}

#[test]
fn a_search_that_was_killed_goes_on_from_its_best_on_postgresql() {
    let folder = Folder::new("goes-on-postgres");
    goes_on(&on_postgres(&folder));
}

/// `(id, name)` of events as they come, until the connection ends or `enough` says so.
fn follow(server: &Process, path: &str, last: u64, enough: impl Fn(usize) -> bool) -> Vec<(u64, String)> {
    let mut stream = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    write!(
        stream,
        "GET {path} HTTP/1.0\r\nHost: localhost\r\nLast-Event-ID: {last}\r\n\r\n"
    )
    .unwrap();
    let (mut found, mut name) = (Vec::new(), String::new());
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        match line.split_once(':') {
            Some(("event", value)) => name = value.trim().to_string(),
            Some(("id", value)) => found.push((value.trim().parse().unwrap(), name.clone())),
            _ => {}
        }
        if enough(found.len()) {
            break;
        }
    }
    found
}

/// Follows a search through the death of its server: the next one goes on after the last event that was seen.
fn is_followed(place: &Place) {
    let server = Process::serve(place, &[]);
    let mut long = request(1);
    long["search"] = json!({"seed": 1, "time_limit_s": 8});
    let (_, job) = server.post("/excitation", &long);
    let path = job["links"]["events"].as_str().unwrap();
    let before = follow(&server, path, 0, |seen| seen == 5);
    let last = before.last().unwrap().0;
    // A reconnection to the same server.
    let meanwhile = follow(&server, path, last, |seen| seen == 5);
    server.kill();
    let server = Process::serve(place, &[]);
    let after = follow(&server, path, meanwhile.last().unwrap().0, |_| false);
    let all = [before, meanwhile, after].concat();
    assert!(all.windows(2).all(|w| w[0].0 < w[1].0), "nothing comes twice: {all:?}");
    assert_eq!(all.iter().filter(|e| e.1 == "end").count(), 1);
    assert_eq!(all.last().unwrap().1, "end");
}

#[test]
fn events_go_on_after_the_death_of_the_server_on_sqlite() {
    is_followed(&Folder::new("events-sqlite").place());
}

#[test]
fn events_go_on_after_the_death_of_the_server_on_postgresql() {
    let folder = Folder::new("events-postgres");
    is_followed(&on_postgres(&folder));
}
