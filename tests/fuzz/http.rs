//! Mutated bodies against a running server: every one is answered, none with an error of the server's own, and no job ends with
//! one.

use super::bases;
use super::case::Recipe;
use super::process::{Folder, Process};
use super::target::Target;
use libtest_mimic::Failed;
use serde_json::{Value, json};

/// Bodies of each kind.
const BODIES: u64 = 120;

pub fn bodies() -> Result<(), Failed> {
    let folder = Folder::new("fuzz-http");
    let mut server = Process::serve(&folder.place(), &["--requests-per-second", "0", "--waiting-jobs", "10000"]);
    let mut failed = Vec::new();
    for (target, send) in [
        (Target::Motion, motion as Send),
        (Target::BaseParameters, robot as Send),
        (Target::Excite, excitation as Send),
        (Target::Identify, effects as Send),
        (Target::Identify, preview as Send),
        (Target::Identify, identification as Send),
    ] {
        let bases = bases::of(target);
        for seed in 0..BODIES {
            let recipe = Recipe::of_seed(target, 7_000_000 + seed);
            let files = recipe.draft(&bases).render();
            let status = send(&server, &files);
            // No answer is status 0.
            if status == 0 || status == 500 {
                failed.push(format!("{status} to {}", recipe.to_json()));
            }
        }
    }
    failed.extend(jobs(&server));
    if let Some(status) = server.child.try_wait()? {
        failed.push(format!("the server ended: {status}"));
    }
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n").into())
    }
}

type Files<'a> = &'a [(&'static str, Vec<u8>)];
type Send = fn(&Process, Files) -> u16;

fn part<'a>(files: &'a [(&'static str, Vec<u8>)], name: &str) -> Option<&'a [u8]> {
    files.iter().find(|(n, _)| *n == name).map(|(_, content)| content.as_slice())
}

/// The robot's file as documents hold it: JSON as it is, XML as a text.
fn robot_text(file: &[u8]) -> String {
    let text = String::from_utf8_lossy(file);
    if text.trim_start().starts_with('<') {
        json!({"urdf": text}).to_string()
    } else {
        text.into_owned()
    }
}

/// The request with the other parts in it, whether they are JSON or not.
fn request(files: Files) -> String {
    let text = String::from_utf8_lossy(part(files, bases::REQUEST).unwrap_or(b"{}")).into_owned();
    let mut fields = String::new();
    if let Some(robot) = part(files, bases::ROBOT) {
        fields.push_str(&format!("\"robot\":{},", robot_text(robot)));
    }
    if let Some(model) = part(files, bases::MODEL) {
        fields.push_str(&format!("\"model\":{},", String::from_utf8_lossy(model)));
    }
    match text.strip_prefix('{') {
        Some(rest) if rest.trim() == "}" => format!("{{{}}}", fields.trim_end_matches(',')),
        Some(rest) => format!("{{{fields}{rest}"),
        None => text,
    }
}

fn post(server: &Process, path: &str, kind: &str, body: &[u8]) -> u16 {
    let body = String::from_utf8_lossy(body);
    server.send("POST", path, &[("content-type", kind)], &body).0
}

fn motion(server: &Process, files: Files) -> u16 {
    post(server, "/motion", "application/json", request(files).as_bytes())
}

fn robot(server: &Process, files: Files) -> u16 {
    let text = robot_text(part(files, bases::ROBOT).unwrap_or_default());
    post(server, "/robots", "application/json", text.as_bytes())
}

/// Keeps the first effect of the files or the request; what is none is refused.
fn effects(server: &Process, files: Files) -> u16 {
    let parsed = |name: &str| -> Value { serde_json::from_slice(part(files, name).unwrap_or(b"null")).unwrap_or_default() };
    let (listed, of_request) = (parsed(bases::EFFECTS), parsed(bases::REQUEST));
    let effect = listed.get(0).unwrap_or(&of_request["effects"][0]).to_string();
    let kind = [("content-type", "application/json")];
    let kept = server.send("PUT", "/effects/hose", &kind, &effect).0;
    let listed = server.get("/effects").0;
    if listed == 200 { kept } else { listed }
}

fn excitation(server: &Process, files: Files) -> u16 {
    post(server, "/excitation", "application/json", request(files).as_bytes())
}

fn preview(server: &Process, files: Files) -> u16 {
    upload(server, "/identify/preview", files)
}

fn identification(server: &Process, files: Files) -> u16 {
    upload(server, "/identify", files)
}

fn upload(server: &Process, path: &str, files: Files) -> u16 {
    let mut body = format!(
        "--XXboundary\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n",
        request(files)
    )
    .into_bytes();
    for (name, file) in [("log", bases::LOG), ("validation", bases::VALIDATION)] {
        if let Some(content) = part(files, file) {
            body.extend(
                format!("--XXboundary\r\nContent-Disposition: form-data; name=\"{name}\"; filename=\"{file}\"\r\n\r\n").bytes(),
            );
            body.extend(content);
            body.extend(b"\r\n");
        }
    }
    body.extend(b"--XXboundary--\r\n");
    post(server, path, "multipart/form-data; boundary=XXboundary", &body)
}

/// Jobs that ended with an error of the program's own, when all have ended.
fn jobs(server: &Process) -> Vec<String> {
    let all = || {
        let (mut jobs, mut next) = (Vec::new(), Some("/jobs?limit=100".to_string()));
        while let Some(address) = next {
            let page: Value = server.get(&address).1;
            jobs.extend(page["jobs"].as_array().cloned().unwrap_or_default());
            next = page["next"].as_str().map(str::to_string);
        }
        jobs
    };
    super::process::wait_until("all jobs have ended", || {
        all()
            .iter()
            .all(|j| !matches!(j["state"].as_str(), Some("queued" | "running")))
    });
    let failed = all()
        .into_iter()
        .filter(|j| matches!(j["error"]["code"].as_str(), Some("internal")));
    failed.map(|j| format!("job: {j}")).collect()
}
