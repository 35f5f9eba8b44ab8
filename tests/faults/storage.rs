//! A disk that is full, a database that goes away, clients that do: a clear error, nothing half-written, and the service goes on.

use crate::catalogue;
use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process, wait_until};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

fn quick(seed: u64) -> Value {
    json!({
        "robot": "planar_two_link", "fourier": {"order": 2, "fundamental_hz": 0.2}, "sample_rate_hz": 20,
        "search": {"seed": seed, "starts": 2, "max_evaluations": 100}
    })
}

fn finishes(server: &Process, seed: u64) {
    let headers = [("content-type", "application/json"), ("prefer", "wait=60")];
    let (status, result) = server.send("POST", "/excitation", &headers, &quick(seed).to_string());
    assert_eq!(status, 200, "{result}");
    assert!(result["condition_number"].as_f64().unwrap() > 1.0);
}

fn files_in(folder: &Path) -> usize {
    std::fs::read_dir(folder).map_or(0, |entries| entries.flatten().count())
}

#[test]
fn a_client_that_goes_away_in_the_middle_of_an_upload_leaves_nothing_on_sqlite() {
    leaves_nothing(&Folder::new("upload").place());
}

#[test]
fn a_client_that_goes_away_in_the_middle_of_an_upload_leaves_nothing_on_postgresql() {
    let folder = Folder::new("upload-postgres");
    leaves_nothing(&on_postgres(&folder));
}

fn on_postgres(folder: &Folder) -> Place {
    Place {
        database: Some(Postgres::shared().database()),
        ..folder.place()
    }
}

fn leaves_nothing(place: &Place) {
    let server = Process::serve(place, &[]);
    let incoming = place.folder.join("files/incoming");
    let mut stream = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
    let head = "POST /identify HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=b\r\nContent-Length: 10000000\r\n\r\n\
        --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(&vec![b'1'; 200_000]).unwrap();
    wait_until("the log comes in", || files_in(&incoming) == 1);
    drop(stream);
    wait_until("what came in is gone", || files_in(&incoming) == 0);
    assert_eq!(server.get("/jobs").1["jobs"], json!([]));
    finishes(&server, 1);
}

#[test]
fn a_database_that_goes_away_and_comes_back_costs_nothing_but_time() {
    let postgres = Postgres::start();
    let folder = Folder::new("database-gone");
    let place = Place {
        database: Some(postgres.database()),
        ..folder.place()
    };
    let server = Process::serve(&place, &["--lease-s", "5"]);
    let mut long = quick(1);
    long["search"] = json!({"seed": 1, "time_limit_s": 6});
    let id = server.post("/excitation", &long).1["id"].as_str().unwrap().to_string();
    wait_until("the search runs", || server.state(&id) == "running");
    postgres.go_away();
    let (status, problem) = server.post("/excitation", &quick(2));
    assert_eq!(
        (status, problem["code"].as_str()),
        (503, Some("storage_unavailable")),
        "{problem}"
    );
    assert_eq!(server.get("/health/ready").0, 503);
    assert_eq!(server.get("/health/live").0, 200);
    std::thread::sleep(Duration::from_secs(1));
    postgres.come_back();
    wait_until("the server is ready again", || server.get("/health/ready").0 == 200);
    finishes(&server, 3);
    wait_until("the search that ran meanwhile ends", || server.state(&id) == "finished");
    // The one that was refused is not there.
    assert_eq!(server.get("/jobs").1["jobs"].as_array().unwrap().len(), 2);
}

/// A small disk; `None` where one cannot be mounted.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    fn mount(at: &'a Path, megabytes: usize) -> Option<Self> {
        std::fs::create_dir_all(at).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={megabytes}m,mode=1777"), "tmpfs"])
            .arg(at)
            .output();
        mounted.is_ok_and(|o| o.status.success()).then_some(Self(at))
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(self.0).status();
    }
}

/// Takes all the room of a disk until it is dropped.
struct Ballast(PathBuf);

impl Ballast {
    fn on(disk: &Path) -> Self {
        let path = disk.join("ballast");
        let mut file = std::fs::File::create(&path).unwrap();
        while file.write_all(&[0; 4096]).is_ok() {}
        Self(path)
    }
}

impl Drop for Ballast {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Status and problem of an identification with a log of two megabytes.
fn send_log(server: &Process) -> (u16, Value) {
    let log = format!("time,q1,q2,tau1,tau2\n{}", "0,0,0,0,0\n".repeat(200_000));
    let body = format!(
        "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{{\"robot\": \"planar_two_link\"}}\r\n\
         --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\n{log}\r\n--b--\r\n"
    );
    server.send(
        "POST",
        "/identify",
        &[("content-type", "multipart/form-data; boundary=b")],
        &body,
    )
}

/// Fills the disk of the data folder.
fn tells_of_a_full_disk(name: &str, place: &Place) {
    let Some(_disk) = SmallDisk::mount(&place.folder, 4) else {
        println!("SKIPPED {name}: a small disk cannot be mounted here");
        return;
    };
    let server = Process::serve(place, &[]);
    finishes(&server, 1);
    let ballast = Ballast::on(&place.folder);
    let (status, problem) = send_log(&server);
    assert_eq!(
        (status, problem["code"].as_str()),
        (503, Some("storage_unavailable")),
        "{problem}"
    );
    assert_eq!(problem["detail"], "the disk is full");
    assert_eq!(server.get("/health/ready").0, 503);
    assert_eq!(files_in(&place.folder.join("files/incoming")), 0);
    drop(ballast);
    assert_eq!(server.get("/health/ready").0, 200);
    finishes(&server, 2);
    // It was taken nowhere.
    assert_eq!(server.get("/jobs").1["jobs"].as_array().unwrap().len(), 2);
}

#[test]
fn a_full_disk_is_told_of_and_the_service_goes_on_on_sqlite() {
    let folder = Folder::new("full-disk");
    tells_of_a_full_disk("a_full_disk_is_told_of_and_the_service_goes_on_on_sqlite", &folder.place());
}

#[test]
fn a_full_disk_is_told_of_and_the_service_goes_on_on_postgresql() {
    let folder = Folder::new("full-disk-postgres");
    tells_of_a_full_disk(
        "a_full_disk_is_told_of_and_the_service_goes_on_on_postgresql",
        &on_postgres(&folder),
    );
}

/// Not the disk of the data folder but that of the database is full: PostgreSQL has no room for the log.
#[test]
fn a_full_disk_of_the_database_is_told_of_and_the_service_goes_on() {
    let folder = Folder::new("full-database");
    let disk = folder.path().join("disk");
    // A new cluster takes 40 megabytes, 16 more for every file of its log.
    let Some(_disk) = SmallDisk::mount(&disk, 120) else {
        println!("SKIPPED a_full_disk_of_the_database_is_told_of_and_the_service_goes_on: a small disk cannot be mounted here");
        return;
    };
    let postgres = Postgres::start_in(&disk);
    let place = Place {
        database: Some(postgres.database()),
        ..folder.place()
    };
    let server = Process::serve(&place, &[]);
    finishes(&server, 1);
    let ballast = Ballast::on(&disk);
    let (status, problem) = send_log(&server);
    assert_eq!(
        (status, problem["code"].as_str()),
        (503, Some("storage_unavailable")),
        "{problem}"
    );
    assert_eq!(server.get("/health/live").0, 200);
    drop(ballast);
    wait_until("the server is ready again", || server.get("/health/ready").0 == 200);
    finishes(&server, 2);
    assert_eq!(server.get("/jobs").1["jobs"].as_array().unwrap().len(), 2);
    drop(server);
}

#[test]
fn a_data_folder_belongs_to_one_process() {
    let folder = Folder::new("two-servers");
    let server = Process::serve(&folder.place(), &[]);
    let mut second = folder.place().command("serve");
    let output = second.args(["--listen", "127.0.0.1:0"]).output().unwrap();
    assert!(!output.status.success());
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        text.contains("storage_unavailable") && text.contains("another process uses the data folder"),
        "{text}"
    );
    finishes(&server, 1);
}

/// What `dynident token` says about the tokens of a place. The subcommand stands before the flags of the place.
fn token(place: &Place, arguments: &[&str]) -> Value {
    let given = place.command("token");
    let mut command = Command::new(given.get_program());
    command
        .arg("token")
        .args(arguments)
        .args(given.get_args().skip(1))
        .arg("--json");
    command
        .env_remove("DATABASE_URL")
        .envs(place.database.iter().map(|url| ("DATABASE_URL", url)));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The secret of a new token.
fn token_create(place: &Place, lasts: &str) -> String {
    let made = token(place, &["create", "--robot", "*", "--expires-in", lasts]);
    made["token"].as_str().unwrap().to_string()
}

fn tokens_of(place: &Place) -> Value {
    token(place, &["list"])
}

#[test]
fn a_backup_made_while_the_server_runs_restores_on_either_database() {
    let folder = Folder::new("backup");
    let server = Process::serve(&folder.place(), &[]);
    let robot = json!({"name": "arm", "joints": [{"name": "J1", "kind": "revolute",
        "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}, "limits": {"velocity": 1}}]});
    assert_eq!(server.post("/robots", &robot).0, 201);
    let hose = catalogue::hose("k*q");
    assert_eq!(catalogue::put(&server, &hose).0, 201);
    finishes(&server, 1);
    token_create(&folder.place(), "1ms");
    token_create(&folder.place(), "30days");
    let tokens = tokens_of(&folder.place());
    assert_eq!(
        (&tokens[0]["state"], &tokens[1]["state"]),
        (&json!("expired"), &json!("valid"))
    );
    let archive = folder.path().join("backup.tar");
    let made = folder.place().command("backup").arg(&archive).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let jobs = server.get("/jobs").1;
    let id = jobs["jobs"][0]["id"].as_str().unwrap().to_string();
    let result = server.get(&format!("/excitation/{id}")).1;
    drop(server);
    for (name, database) in [("sqlite", None), ("postgres", Some(Postgres::shared().database()))] {
        let place = Place {
            folder: folder.path().join(name),
            database,
            network: None,
        };
        let restore = || place.command("restore").arg(&archive).output().unwrap();
        let restored = restore();
        assert!(
            restored.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&restored.stderr)
        );
        assert!(!restore().status.success(), "{name}: what is there is not overwritten");
        let server = Process::serve(&place, &[]);
        assert_eq!(server.get("/jobs").1, jobs, "{name}");
        assert_eq!(server.get(&format!("/excitation/{id}")).1, result, "{name}");
        assert_eq!(server.get("/robots/arm").1, robot, "{name}");
        assert_eq!(server.get("/effects/hose").1["expression"], hose["expression"], "{name}");
        assert_eq!(tokens_of(&place), tokens, "{name}");
        drop(server);
        let server = Process::serve(&place, &["--auth", "on"]);
        let expired = token_create(&place, "1ms");
        std::thread::sleep(Duration::from_millis(5));
        let refused = server.send("GET", "/jobs", &[("authorization", &format!("Bearer {expired}"))], "");
        assert_eq!((refused.0, &refused.1["code"]), (401, &json!("token_expired")), "{name}");
        let lasting = token_create(&place, "1h");
        assert_eq!(
            server
                .send("GET", "/jobs", &[("authorization", &format!("Bearer {lasting}"))], "")
                .0,
            200,
            "{name}"
        );
    }
    // Cut off: nothing of it is taken.
    let bytes = std::fs::read(&archive).unwrap();
    std::fs::write(&archive, &bytes[..bytes.len() / 2]).unwrap();
    let cut_off = Place {
        folder: folder.path().join("cut-off"),
        database: None,
        network: None,
    };
    let output = cut_off.command("restore").arg(&archive).output().unwrap();
    assert!(!output.status.success());
    let server = Process::serve(&cut_off, &[]);
    assert_eq!(server.get("/jobs").1["jobs"], json!([]));
}

#[test]
fn a_stopped_server_puts_its_work_back() {
    let folder = Folder::new("stopped");
    let server = Process::serve(&folder.place(), &[]);
    let mut long = quick(1);
    long["search"] = json!({"seed": 1, "time_limit_s": 60});
    let id = server.post("/excitation", &long).1["id"].as_str().unwrap().to_string();
    let best = |server: &Process| server.get(&format!("/jobs/{id}")).1["progress"]["best"].as_f64();
    wait_until("the search has found something", || best(&server).is_some());
    let found = best(&server).unwrap();
    let mut server = server;
    server.signal("TERM");
    let status = server.child.wait().unwrap();
    assert!(status.success(), "{status}");
    // Cancelled while it waits: it is begun once more, to hand out what it has.
    let none = ["--concurrent-jobs", "0"];
    let mut waiting = Process::serve(&folder.place(), &none);
    assert_eq!(waiting.state(&id), "queued");
    assert_eq!(waiting.send("DELETE", &format!("/jobs/{id}"), &[], "").0, 202);
    waiting.signal("TERM");
    waiting.child.wait().unwrap();
    let server = Process::serve(&folder.place(), &[]);
    wait_until("it is cancelled", || server.state(&id) == "cancelled");
    // What the first had found is not lost. What is handed out keeps clear of the limits by 1e-8 of them: its value differs from
    // that of the search by a few times as much.
    let result = server.get(&format!("/excitation/{id}")).1;
    assert!(
        result["condition_number"].as_f64().unwrap() <= found * (1.0 + 1e-6),
        "{found} then {result}"
    );
}

/// A connection that sends half a request does not keep the server from anything.
#[test]
fn half_a_request_holds_nobody_up() {
    let folder = Folder::new("half");
    let server = Process::serve(&folder.place(), &[]);
    let mut half = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
    half.write_all(
        b"POST /excitation HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n{",
    )
    .unwrap();
    finishes(&server, 1);
    half.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    assert!(half.read(&mut [0; 16]).is_err(), "nothing is answered to half a request");
}
