//! Jobs that abort, hoard memory or never end: each costs itself and nothing else. The faults are asked for by the names of logs,
//! which the children of a server with `DYNIDENT_TEST_FAULTS` in its environment listen to.

use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process, wait_until};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

/// A server whose children fail on demand.
fn server(place: &Place, arguments: &[&str]) -> Process {
    let mut command = place.command("serve");
    command.args(["--listen", "127.0.0.1:0", "--log", "error"]).args(arguments);
    let server = Process::start(with_faults(command));
    wait_until("the server is ready", || server.get("/health/ready").0 == 200);
    server
}

fn with_faults(mut command: Command) -> Command {
    // With a backtrace, as some operators set it, the reason is not the last that a child says.
    command.env("DYNIDENT_TEST_FAULTS", "1").env("RUST_BACKTRACE", "1");
    command
}

/// A log of the planar arm, three periods of 5 s at 100 Hz.
pub fn log(folder: &Folder) -> String {
    let simulation = json!({
        "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}},
        "periods": 3, "sample_rate_hz": 100, "noise": {"torque": [0.05, 0.03]}, "seed": 1
    });
    let request = folder.path().join("simulation.json");
    std::fs::write(&request, simulation.to_string()).unwrap();
    let simulated = Command::new(env!("CARGO_BIN_EXE_dynident"))
        .args(["simulate", "--robot", "planar_two_link", "--request"])
        .arg(&request)
        .output()
        .unwrap();
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    String::from_utf8(simulated.stdout).unwrap()
}

/// Status and answer of an identification from a log of this name; with `wait` the result.
fn identify(server: &Process, name: &str, log: &str, wait: bool) -> (u16, Value) {
    let request = json!({"robot": "planar_two_link", "prediction_points": 100});
    send(server, &request, name, log, wait)
}

/// The same with a request of its own.
pub fn send(server: &Process, request: &Value, name: &str, log: &str, wait: bool) -> (u16, Value) {
    let body = format!(
        "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{request}\r\n\
         --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"{name}.csv\"\r\n\r\n{log}\r\n--b--\r\n"
    );
    let mut headers = vec![
        ("content-type", "multipart/form-data; boundary=b"),
        ("cache-control", "no-cache"),
    ];
    if wait {
        headers.push(("prefer", "wait=50"));
    }
    server.send("POST", "/identify", &headers, &body)
}

fn begun(server: &Process, name: &str, log: &str) -> String {
    let (status, job) = identify(server, name, log, false);
    assert_eq!(status, 202, "{job}");
    job["id"].as_str().unwrap().to_string()
}

/// The error of a job that has failed.
fn failure(server: &Process, id: &str) -> Value {
    wait_until("the job has ended", || {
        !["queued", "running"].contains(&server.state(id).as_str())
    });
    assert_eq!(server.state(id), "failed");
    server.get(&format!("/identify/{id}")).1
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}

/// Times of twenty identifications, one after the other, each with a result.
fn twenty(server: &Process, log: &str) -> Vec<Duration> {
    let one = |_| {
        let started = Instant::now();
        let (status, result) = identify(server, "run", log, true);
        assert_eq!((status, &result["quality"]["verdict"]), (200, &json!("good")), "{result}");
        started.elapsed()
    };
    (0..20).map(one).collect()
}

#[test]
fn jobs_that_abort_hoard_or_never_end_fail_and_twenty_others_do_not_notice() {
    let folder = Folder::new("children");
    let log = log(&folder);
    // A place for each of the three, and one for those who come by.
    let limits = ["--job-memory", "400000000", "--job-time-s", "6", "--short-jobs", "4"];
    let server = server(&folder.place(), &limits);
    let alone = median(twenty(&server, &log));
    let faults = [
        ("fault-abort", "job_crashed", 500),
        ("fault-overflow", "job_crashed", 500),
        ("fault-memory", "memory_limit", 422),
        ("fault-endless", "time_limit", 422),
    ];
    let ids: Vec<String> = faults.iter().map(|(name, ..)| begun(&server, name, &log)).collect();
    let beside = median(twenty(&server, &log));
    println!(
        "identification alone {alone:?}, beside jobs that die {beside:?}: {:.2} times",
        beside.as_secs_f64() / alone.as_secs_f64()
    );
    // Other tests use the same cores: what a job that never ends would do is another order of magnitude.
    assert!(beside < 3 * alone + Duration::from_millis(100), "{alone:?} then {beside:?}");
    for ((name, code, status), id) in faults.iter().zip(&ids) {
        let problem = failure(&server, id);
        assert_eq!(
            (&problem["code"], &problem["status"]),
            (&json!(code), &json!(status)),
            "{name}: {problem}"
        );
        assert!(problem["hint"].is_string(), "{name}: {problem}");
    }
    let metrics = server.text("/metrics");
    for (reason, deaths) in [("crash", 4), ("memory", 2), ("time", 2)] {
        let line = format!("dynident_child_deaths_total{{reason=\"{reason}\"}} {deaths}");
        assert!(metrics.contains(&line), "two deaths of each: `{line}` in\n{metrics}");
    }
}

#[test]
fn a_job_that_does_not_react_is_cancelled_all_the_same() {
    let folder = Folder::new("deaf");
    let server = server(&folder.place(), &[]);
    let id = begun(&server, "fault-spin", &log(&folder));
    wait_until("the job runs", || server.state(&id) == "running");
    let asked = Instant::now();
    server.send("DELETE", &format!("/jobs/{id}"), &[], "");
    wait_until("the job has ended", || server.state(&id) == "cancelled");
    assert!(asked.elapsed() < Duration::from_secs(15), "{:?}", asked.elapsed());
}

/// The result is there, complete but for what was to be drawn.
#[test]
fn a_fault_in_drawing_costs_the_drawing_alone() {
    let folder = Folder::new("drawing");
    let log = log(&folder);
    let server = server(&folder.place(), &["--job-time-s", "3"]);
    for name in ["fault-drawing-abort", "fault-drawing-endless"] {
        let (status, result) = identify(&server, name, &log, true);
        assert_eq!((status, &result["quality"]["verdict"]), (200, &json!("good")), "{result}");
        assert_eq!(result["predictions"], json!([]));
        assert!(
            result["predictions_error"].as_str().unwrap().contains("the predictions"),
            "{result}"
        );
        let id = result["id"].as_str().unwrap();
        assert_eq!(server.state(id), "finished");
        assert_eq!(server.get(&format!("/identify/{id}/model")).0, 200);
    }
}

/// What is stored before it is drawn outlives the server, and is the result where no other comes.
#[test]
fn a_result_is_stored_while_its_predictions_are_made_on_sqlite() {
    is_stored_before_it_is_drawn(&Folder::new("stored-sqlite"), |place| place);
}

#[test]
fn a_result_is_stored_while_its_predictions_are_made_on_postgresql() {
    is_stored_before_it_is_drawn(&Folder::new("stored-postgres"), |place| Place {
        database: Some(Postgres::shared().database()),
        ..place
    });
}

fn is_stored_before_it_is_drawn(folder: &Folder, at: impl Fn(Place) -> Place) {
    let place = at(folder.place());
    let log = log(folder);
    let first = server(&place, &[]);
    let id = begun(&first, "fault-drawing-endless", &log);
    let files = place.folder.join("files");
    let count = || walk(&files);
    // The request and the log; then the result and the model.
    wait_until("the result is on the disk", || count() >= 4);
    std::thread::sleep(Duration::from_millis(300));
    let job = first.get(&format!("/jobs/{id}")).1;
    assert_eq!((&job["state"], &job["outcome"]), (&json!("running"), &Value::Null));
    first.kill();
    // In its next life the log is refused: what was stored is its result.
    let second = server(&place, &["--most-rows", "10"]);
    wait_until("the job has ended", || second.state(&id) == "finished");
    let (status, result) = second.get(&format!("/identify/{id}"));
    assert_eq!((status, &result["quality"]["verdict"]), (200, &json!("good")), "{result}");
}

fn walk(folder: &std::path::Path) -> usize {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|e| if e.path().is_dir() { walk(&e.path()) } else { 1 }).sum()
}

/// Processes whose parent this is, by what the system says.
fn children_of(parent: u32) -> Vec<u32> {
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let numbers = processes.filter_map(|p| p.file_name().to_str()?.parse::<u32>().ok());
    numbers
        .filter(|id| state_and_parent(*id).is_some_and(|(_, p)| p == parent))
        .collect()
}

fn state_and_parent(id: u32) -> Option<(char, u32)> {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace();
    Some((fields.next()?.chars().next()?, fields.next()?.parse().ok()?))
}

#[test]
fn children_end_with_their_server_however_it_ends() {
    let folder = Folder::new("orphans");
    let server = server(&folder.place(), &[]);
    let id = begun(&server, "fault-spin", &log(&folder));
    wait_until("the job runs", || server.state(&id) == "running");
    // The system knows the children by the thread that started them: all threads have one process.
    let children = children_of(server.child.id());
    assert!(!children.is_empty());
    server.kill();
    let gone = |id: &u32| state_and_parent(*id).is_none_or(|(state, _)| state == 'Z');
    let since = Instant::now();
    wait_until("all children are gone", || children.iter().all(gone));
    assert!(since.elapsed() < Duration::from_secs(5), "{:?}", since.elapsed());
}

/// Deaths are the job's own: the operator may kill its process once, by hand or by a machine without memory.
#[test]
fn a_job_whose_process_is_killed_twice_fails_and_says_so() {
    let folder = Folder::new("killed");
    let server = server(&folder.place(), &[]);
    let problem = failure(&server, &begun(&server, "fault-killed", &log(&folder)));
    assert_eq!(problem["code"], "job_crashed");
    assert!(problem["detail"].as_str().unwrap().contains("it was killed"), "{problem}");
}

/// Processor time of every child of the server (hundredths of a second).
fn work_of_children(server: &Process) -> BTreeMap<u32, u64> {
    let ticks = |id: u32| {
        let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        // User and system time are fields 14 and 15, and the state that comes after the name is field 3.
        Some((id, fields[11].parse::<u64>().ok()? + fields[12].parse::<u64>().ok()?))
    };
    children_of(server.child.id()).into_iter().filter_map(ticks).collect()
}

/// Half a million rows of two joints, which take a second and more to read and prepare.
fn long_log() -> String {
    let mut log = String::from("time,q1,q2,tau1,tau2\n");
    for s in 0..500_000 {
        let t = 0.0025 * f64::from(s);
        let (q1, q2) = ((1.9 * t).sin(), (2.7 * t).cos());
        log += &format!("{t:.4},{q1:.6},{q2:.6},{:.4},{:.4}\n", 12.0 * q1 - q2, 3.0 * q2);
    }
    log
}

#[test]
fn the_work_of_a_request_ends_when_its_client_leaves() {
    let folder = Folder::new("left");
    let server = server(&folder.place(), &[]);
    let log = long_log();
    let body = format!(
        "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{{\"robot\": \"planar_two_link\"}}\r\n\
         --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\n{log}\r\n--b--\r\n"
    );
    let address = server.url.trim_start_matches("http://");
    let head = format!(
        "POST /identify/preview HTTP/1.1\r\nHost: {address}\r\nContent-Type: multipart/form-data; boundary=b\r\nContent-Length: {}\r\n\r\n",
        body.len()
    );
    let send = || {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body.as_bytes()).unwrap();
        stream
    };
    let begun = Instant::now();
    let mut answer = [0; 12];
    send().read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 200");
    let whole = begun.elapsed();
    let before = work_of_children(&server);
    // What a child has done since: one that has grown large is replaced by another.
    let busy = |least: u64| {
        let now = work_of_children(&server);
        now.iter()
            .any(|(id, done)| *done >= before.get(id).copied().unwrap_or(0) + least)
    };
    let client = send();
    wait_until("the work has begun", || busy(5));
    drop(client);
    let left = Instant::now();
    wait_until("the work has ended", || !busy(5));
    println!("answered in {whole:?}; ended {:?} after its client had left", left.elapsed());
    assert!(left.elapsed() < whole / 2, "{:?} of {whole:?}", left.elapsed());
}
