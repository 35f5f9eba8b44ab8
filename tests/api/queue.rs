//! Whose turn it is: fairness between robots, urgency, limits; and what is answered from the store.

use crate::identify::identify;
use crate::server::{Server, in_database, long_request, quick_request};
use dynident::service::Config;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

fn arm(name: &str) -> Value {
    json!({"name": name, "joints": [{"name": "J1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0},
        "limits": {"position": [-2, 2], "velocity": 1, "acceleration": 5}}]})
}

/// A long job (it may take that long by its document) that takes a moment.
fn moment(robot: &str, seed: u64) -> Value {
    let mut request = quick_request();
    request["robot"] = arm(robot);
    request["search"] = json!({"seed": seed, "starts": 1, "max_evaluations": 10});
    request
}

fn begin(server: &Server, request: &Value, headers: &[(&str, &str)]) -> String {
    let headers = [headers, &[("content-type", "application/json")]].concat();
    let answer = server.send("POST", "/excitation", &headers, &request.to_string());
    assert_eq!(answer.status, 202, "{}", answer.text);
    answer.json()["id"].as_str().unwrap().to_string()
}

pub fn wait_until(condition: impl Fn() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < Duration::from_secs(60), "waited in vain");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Keeps the one long place busy until it is cancelled.
fn blocked(server: &Server) -> String {
    let id = begin(server, &long_request(), &[]);
    wait_until(|| server.get(&format!("/jobs/{id}")).json()["state"] == "running");
    id
}

/// Ids of the jobs in the order in which they began.
fn order(server: &Server, ids: &[String]) -> Vec<usize> {
    let job = |id: &String| server.get(&format!("/jobs/{id}")).json();
    wait_until(|| ids.iter().all(|id| job(id)["state"] == "finished"));
    let mut begun: Vec<(String, usize)> = ids
        .iter()
        .enumerate()
        .map(|(k, id)| (job(id)["started_at"].as_str().unwrap().to_string(), k))
        .collect();
    begun.sort();
    begun.into_iter().map(|(_, k)| k).collect()
}

#[test]
fn robots_take_turns() {
    let server = Server::start();
    let block = blocked(&server);
    // Five of one robot, then one each of two others.
    let mut ids: Vec<String> = (0..5).map(|k| begin(&server, &moment("busy", k), &[])).collect();
    ids.push(begin(&server, &moment("second", 1), &[]));
    ids.push(begin(&server, &moment("third", 1), &[]));
    server.delete(&format!("/jobs/{block}"));
    let order = order(&server, &ids);
    assert_eq!(order[0], 0, "who came first begins: {order:?}");
    let place = |k: usize| order.iter().position(|&other| other == k).unwrap();
    assert!(place(5) <= 2 && place(6) <= 3, "{order:?}");
    let of_busy: Vec<usize> = order.iter().copied().filter(|k| *k < 5).collect();
    assert_eq!(of_busy, [0, 1, 2, 3, 4]);
}

#[test]
fn urgent_jobs_go_first() {
    let server = Server::start();
    let block = blocked(&server);
    let urgencies = ["u=7", "u=3", "u=0, i", "u=9"];
    let ids: Vec<String> = (0..4)
        .map(|k| begin(&server, &moment("arm", k as u64), &[("priority", urgencies[k])]))
        .collect();
    server.delete(&format!("/jobs/{block}"));
    // What is no urgency counts as the usual one.
    assert_eq!(order(&server, &ids), [2, 1, 3, 0]);
}

#[test]
fn short_jobs_are_not_stuck_behind_long_ones() {
    let server = Server::start();
    blocked(&server);
    begin(&server, &long_request(), &[]);
    let asked = Instant::now();
    assert_eq!(server.excite(&quick_request()).status, 200);
    assert!(asked.elapsed() < Duration::from_secs(5), "{:?}", asked.elapsed());
}

/// Searches of a few seconds take all of them: whoever identifies meanwhile does not wait for theirs.
#[test]
fn brief_searches_do_not_hold_up_an_identification() {
    let server = Server::start();
    let brief = |seed: u64| {
        let mut request = long_request();
        request["robot"] = arm(&format!("arm-{seed}"));
        request["search"] = json!({"seed": seed, "time_limit_s": 5.0});
        begin(&server, &request, &[])
    };
    let ids: Vec<String> = (0..4).map(brief).collect();
    let state = |id: &String| server.get(&format!("/jobs/{id}")).json()["state"].clone();
    wait_until(|| ids.iter().any(|id| state(id) == "running"));
    identify(&server);
    let ended = ids.iter().filter(|id| state(id) == "finished").count();
    assert!(ended <= 1, "{ended} searches of 5 s ended before one identification");
}

#[test]
fn one_robot_cannot_fill_the_queue() {
    let server = Server::with(Config {
        waiting_per_robot: 2,
        ..Config::default()
    });
    blocked(&server);
    let post = |robot: &str, seed| server.post_json("/excitation", &moment(robot, seed).to_string());
    assert_eq!((post("a", 1).status, post("a", 2).status), (202, 202));
    let refused = post("a", 3);
    assert_eq!(
        (refused.status, refused.problem()["code"].as_str()),
        (429, Some("limit_reached"))
    );
    assert!(refused.header("retry-after").is_some());
    assert_eq!(post("b", 1).status, 202);
    // Its short jobs are not meant.
    let mut short = quick_request();
    short["robot"] = arm("a");
    assert_eq!(server.excite(&short).status, 200);
}

#[test]
fn one_robot_runs_no_more_than_it_may() {
    let server = Server::with(Config {
        concurrent_jobs: 2,
        running_per_robot: Some(1),
        ..Config::default()
    });
    let of = |robot: &str, seed: u64| {
        let mut request = long_request();
        request["robot"] = arm(robot);
        request["search"]["seed"] = json!(seed);
        request
    };
    let ids = [of("a", 1), of("a", 2), of("b", 1)].map(|request| begin(&server, &request, &[]));
    let state = |id: &String| server.get(&format!("/jobs/{id}")).json()["state"].clone();
    wait_until(|| state(&ids[0]) == "running" && state(&ids[2]) == "running");
    assert_eq!(state(&ids[1]), "queued");
    server.delete(&format!("/jobs/{}", ids[0]));
    wait_until(|| state(&ids[1]) == "running");
}

#[test]
fn the_same_design_is_answered_from_the_store() {
    let server = Server::start();
    let first = server.excite(&quick_request()).json();
    let again = server.excite(&quick_request());
    assert_eq!((again.status, again.json()), (200, first.clone()));
    // Another request, or one that says so, is done.
    let mut other = quick_request();
    other["search"]["seed"] = json!(2);
    assert_ne!(server.excite(&other).json()["id"], first["id"]);
    let headers = [
        ("content-type", "application/json"),
        ("prefer", "wait=60"),
        ("cache-control", "no-cache"),
    ];
    let afresh = server
        .send("POST", "/excitation", &headers, &quick_request().to_string())
        .json();
    assert_ne!(afresh["id"], first["id"]);
}

#[test]
fn a_job_keeps_the_robot_it_was_asked_with() {
    let server = Server::start();
    let put = |document: &Value| {
        server.send(
            "PUT",
            "/robots/arm",
            &[("content-type", "application/json")],
            &document.to_string(),
        )
    };
    assert_eq!(put(&arm("as it was")).status, 201);
    let block = blocked(&server);
    let mut request = moment("x", 1);
    request["robot"] = json!("arm");
    let id = begin(&server, &request, &[]);
    assert_eq!(put(&arm("as it is")).status, 200);
    server.delete(&format!("/jobs/{block}"));
    let result = server
        .send("GET", &format!("/excitation/{id}"), &[("prefer", "wait=60")], "")
        .json();
    assert_eq!((&result["robot"], &result["request"]), (&json!("as it was"), &request));
}

#[test]
fn jobs_are_listed_page_by_page() {
    let server = Server::start();
    let ids: Vec<Value> = (0..3)
        .map(|seed| {
            let mut request = quick_request();
            request["search"]["seed"] = json!(seed);
            server.excite(&request).json()["id"].clone()
        })
        .collect();
    let page = server.get("/jobs?limit=2").json();
    assert_eq!(page["jobs"].as_array().unwrap().len(), 2);
    assert_eq!(page["jobs"][0]["id"], ids[2]);
    let next = server.get(page["next"].as_str().unwrap()).json();
    assert_eq!((&next["jobs"][0]["id"], &next["next"]), (&ids[0], &Value::Null));
    assert_eq!(server.get("/jobs?limit=0&befor=1").errors().len(), 2);
}

/// Jobs of one microsecond, with the border of a page anywhere among them: every one is listed, and once.
#[test]
fn prop_pages_hold_every_job_once_also_of_the_same_microsecond() {
    let folder = std::env::temp_dir().join(format!("dynident-pages-{}", std::process::id()));
    let server = Server::with(Config {
        data: Some(folder.clone()),
        concurrent_jobs: 0,
        short_jobs: 0,
        ..Config::default()
    });
    let begin = |seed: u64| {
        let mut request = quick_request();
        request["search"]["seed"] = json!(seed);
        let job = server.post_json("/excitation", &request.to_string());
        job.json()["id"].as_str().unwrap().to_string()
    };
    let mut ids: Vec<String> = (0..7).map(begin).collect();
    ids.sort();
    // Two times: four jobs of one microsecond, three of another.
    let early = format!(
        "UPDATE jobs SET created_us = CASE WHEN id <= '{}' THEN 1000 ELSE 2000 END",
        ids[3]
    );
    in_database(&folder, &early);
    let late_first: Vec<String> = ids.iter().rev().cloned().collect();
    for limit in 1..=8 {
        let (mut listed, mut next) = (Vec::new(), Some(format!("/jobs?limit={limit}")));
        while let Some(address) = next {
            let page = server.get(&address).json();
            let jobs = page["jobs"].as_array().unwrap();
            listed.extend(jobs.iter().map(|j| j["id"].as_str().unwrap().to_string()));
            next = page["next"].as_str().map(str::to_string);
        }
        assert_eq!(listed, late_first, "pages of {limit}");
    }
    // A time alone is what it was: all that is older.
    let older = server.get("/jobs?before=2000").json();
    assert_eq!(older["jobs"].as_array().unwrap().len(), 4);
    for wrong in ["-1", "x", "1000.a%20b", "1000.a.b"] {
        let errors = server.get(&format!("/jobs?before={wrong}")).errors();
        assert!(errors[0].starts_with("/query/before: is `"), "{errors:?}");
    }
    drop(server);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn what_is_beyond_the_limits_of_the_server_is_named() {
    let server = Server::with(Config {
        most_joints: 6,
        highest_order: 4,
        longest_search_s: 60.0,
        ..Config::default()
    });
    let errors = server.post_json("/excitation", &long_request().to_string()).errors();
    for start in [
        "/robot/joints: is 7;",
        "/search/time_limit_s: is 600;",
        "/fourier/order: is 5;",
    ] {
        assert!(errors.iter().any(|e| e.starts_with(start)), "{start} not in {errors:?}");
    }
}

#[test]
fn metrics_count_requests_and_jobs() {
    let server = Server::start();
    server.excite(&quick_request());
    server.get("/robots/nothing");
    let text = server.get("/metrics").text;
    for line in [
        "dynident_http_requests_total{method=\"GET\",route=\"/robots/{id}\",status=\"404\"} 1",
        "dynident_jobs{state=\"finished\",class=\"brief\"} 1",
        "dynident_job_work_seconds_count{kind=\"excitation\"} 1",
        "# EOF",
    ] {
        assert!(text.lines().any(|l| l == line), "{line} not in\n{text}");
    }
}

/// A machine without handles or memory for another process has them again later: requests are answered so, and jobs wait.
#[test]
fn where_no_process_can_be_started_a_job_waits_and_does_not_fail() {
    use std::os::unix::fs::PermissionsExt;
    let folder = std::env::temp_dir().join(format!("dynident-no-process-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let program = folder.join("program");
    std::fs::write(
        &program,
        concat!("#!/bin/sh\nexec ", env!("CARGO_BIN_EXE_dynident"), " \"$@\"\n"),
    )
    .unwrap();
    let may_run = |mode| std::fs::set_permissions(&program, std::fs::Permissions::from_mode(mode)).unwrap();
    let config = |places| Config {
        data: Some(folder.join("data")),
        program: Some(program.clone()),
        concurrent_jobs: places,
        short_jobs: 0,
        ..Config::default()
    };
    may_run(0o755);
    let mut queue = Server::with(config(0));
    let id = begin(&queue, &moment("waits", 1), &[]);
    queue.stop();
    may_run(0o644);
    let server = Server::with(config(1));
    let refused = server.post_json("/motion", &json!({"robot": "planar_two_link"}).to_string());
    assert_eq!(
        (refused.status, &refused.problem()["code"]),
        (503, &json!("too_many_jobs")),
        "{}",
        refused.text
    );
    wait_until(|| server.get(&format!("/jobs/{id}")).json()["state"] == "running");
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(server.get(&format!("/jobs/{id}")).json()["state"], "running");
    may_run(0o755);
    wait_until(|| server.get(&format!("/jobs/{id}")).json()["state"] == "finished");
    drop(server);
    let _ = std::fs::remove_dir_all(&folder);
}
