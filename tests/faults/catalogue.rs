//! The catalogue of own effects through kill -9, and what acknowledged jobs keep of it.

use crate::children::{log, send};
use crate::postgres::Postgres;
use crate::process::{Folder, Place, Process, wait_until};
use serde_json::{Value, json};
use std::time::Duration;

/// A declared spring on whatever joint it is used on.
pub fn hose(expression: &str) -> Value {
    json!({"name": "hose", "expression": expression, "declared": true, "parameters": [{"name": "k", "unit": "N m"}]})
}

pub fn put(server: &Process, effect: &Value) -> (u16, Value) {
    let path = format!("/effects/{}", effect["name"].as_str().unwrap());
    server.send("PUT", &path, &[("content-type", "application/json")], &effect.to_string())
}

fn on_postgres(folder: &Folder) -> Place {
    Place {
        database: Some(Postgres::shared().database()),
        ..folder.place()
    }
}

/// The definition of version `k`: no two are alike.
fn version(k: usize) -> Value {
    hose(&format!("k*{}*q", k + 1))
}

/// Changes an effect again and again while the server is killed: the one that is kept is never older than the last that was
/// acknowledged, nor one that nobody sent.
fn survives(place: &Place) {
    let mut acknowledged = 0;
    let mut sent = 0;
    for life in 0..20 {
        let server = Process::serve(place, &[]);
        if acknowledged > 0 {
            let kept = server.get("/effects/hose").1["expression"].clone();
            let newest = (acknowledged..=sent).any(|k| kept == version(k)["expression"]);
            assert!(newest, "{kept} of {acknowledged} to {sent}");
        }
        // The ages of the server at its death are spread over all that it does.
        let age = Duration::from_millis(20 + (life * 53) % 200);
        std::thread::scope(|scope| {
            let (server, sent, acknowledged) = (&server, &mut sent, &mut acknowledged);
            scope.spawn(move || {
                loop {
                    *sent += 1;
                    match put(server, &version(*sent)).0 {
                        200 | 201 => *acknowledged = *sent,
                        _ => break,
                    }
                }
            });
            std::thread::sleep(age);
            server.signal("KILL");
        });
    }
    assert!(acknowledged > 20, "{acknowledged} of {sent} acknowledged");
}

#[test]
fn an_accepted_definition_survives_kill_on_sqlite() {
    survives(&Folder::new("effects-kill").place());
}

#[test]
fn an_accepted_definition_survives_kill_on_postgresql() {
    let folder = Folder::new("effects-kill-postgres");
    survives(&on_postgres(&folder));
}

/// A job that waits has the definition of the moment of its acknowledgement, whatever becomes of the catalogue and the server.
fn keeps_the_definition(folder: &Folder, place: &Place) {
    let idle = Process::serve(place, &["--concurrent-jobs", "0", "--short-jobs", "0"]);
    assert_eq!(put(&idle, &hose("k*q")).0, 201);
    let request = json!({"robot": "planar_two_link", "trace": false, "effects": [{"use": "hose", "joint": "J2"}]});
    let (status, job) = send(&idle, &request, "run", &log(folder), false);
    assert_eq!(status, 202, "{job}");
    assert_eq!(put(&idle, &hose("k*sin(q)")).0, 200);
    idle.kill();
    let server = Process::serve(place, &[]);
    let id = job["id"].as_str().unwrap();
    wait_until("the job has ended", || server.state(id) == "finished");
    let result = server.get(&format!("/identify/{id}")).1;
    assert_eq!(result["provenance"]["request"]["effects"][0]["expression"], "k*q", "{result}");
    assert_eq!(server.get("/effects/hose").1["expression"], "k*sin(q)");
}

#[test]
fn an_acknowledged_job_keeps_the_definition_on_sqlite() {
    let folder = Folder::new("effects-job");
    keeps_the_definition(&folder, &folder.place());
}

#[test]
fn an_acknowledged_job_keeps_the_definition_on_postgresql() {
    let folder = Folder::new("effects-job-postgres");
    keeps_the_definition(&folder, &on_postgres(&folder));
}

/// A backup of a version that knew no catalogue is restored, with an empty one.
#[test]
fn a_backup_without_a_catalogue_is_restored() {
    let folder = Folder::new("effects-backup");
    let server = Process::serve(&folder.place(), &[]);
    assert_eq!(put(&server, &hose("k*q")).0, 201);
    let [archive, older] = ["backup.tar", "older.tar"].map(|name| folder.path().join(name));
    let made = folder.place().command("backup").arg(&archive).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    drop(server);
    let mut from = tar::Archive::new(std::fs::File::open(&archive).unwrap());
    let mut to = tar::Builder::new(std::fs::File::create(&older).unwrap());
    let mut left_out = 0;
    for entry in from.entries().unwrap() {
        let entry = entry.unwrap();
        if entry.path().unwrap().ends_with("effects.jsonl") {
            left_out += 1;
            continue;
        }
        let header = entry.header().clone();
        to.append(&header, entry).unwrap();
    }
    to.into_inner().unwrap();
    assert_eq!(left_out, 1);
    let place = Place {
        folder: folder.path().join("restored"),
        database: None,
        network: None,
    };
    let restored = place.command("restore").arg(&older).output().unwrap();
    assert!(restored.status.success(), "{}", String::from_utf8_lossy(&restored.stderr));
    let server = Process::serve(&place, &[]);
    assert_eq!(server.get("/effects").1, json!({"effects": []}));
    assert_eq!(put(&server, &hose("k*q")).0, 201);
}
