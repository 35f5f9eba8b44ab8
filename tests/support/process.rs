//! The program as processes that can be killed.
#![allow(dead_code)]

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A `dynident serve` or `dynident worker`; killed when dropped.
pub struct Process {
    pub child: Child,
    /// Of a server.
    pub url: String,
}

/// A data folder, and the database where it is not in the folder.
pub struct Place {
    pub folder: PathBuf,
    pub database: Option<String>,
    /// Network namespace that the program runs in.
    pub network: Option<String>,
}

impl Place {
    pub fn command(&self, command: &str) -> Command {
        let binary = env!("CARGO_BIN_EXE_dynident");
        let mut program = match &self.network {
            Some(name) => {
                let mut inside = Command::new("ip");
                // Not a child of `ip`, but in its place: a signal to it is one to the program.
                inside.args(["netns", "exec", name, binary]);
                inside
            }
            None => Command::new(binary),
        };
        program.arg(command).arg("--data").arg(&self.folder);
        program.env_remove("DATABASE_URL").env_remove("DYNIDENT_CONFIG");
        if let Some(url) = &self.database {
            program.env("DATABASE_URL", url);
        }
        program
    }
}

impl Process {
    pub fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert!(!line.is_empty(), "the program ended: {:?}", child.wait());
        let url = line.trim().trim_start_matches("listening on ").to_string();
        Self { child, url }
    }

    /// A server on a free port, when it answers.
    pub fn serve(place: &Place, arguments: &[&str]) -> Self {
        let mut command = place.command("serve");
        command.args(["--listen", "127.0.0.1:0", "--log", "warn"]).args(arguments);
        let server = Self::start(command);
        wait_until("the server is ready", || server.get("/health/ready").0 == 200);
        server
    }

    pub fn worker(place: &Place, arguments: &[&str]) -> Self {
        let mut command = place.command("worker");
        command.args(["--log", "warn"]).args(arguments);
        Self::start(command)
    }

    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub fn signal(&self, name: &str) {
        let status = Command::new("kill")
            .args([&format!("-{name}"), &self.child.id().to_string()])
            .status();
        assert!(status.unwrap().success());
    }

    /// Status and document; status 0 where no answer came.
    pub fn get(&self, path: &str) -> (u16, Value) {
        self.send("GET", path, &[], "")
    }

    /// An answer that is no document.
    pub fn text(&self, path: &str) -> String {
        let mut answer = ureq::get(format!("{}{path}", self.url)).call().unwrap();
        answer.body_mut().read_to_string().unwrap()
    }

    pub fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> (u16, Value) {
        let agent: ureq::Agent = ureq::Agent::config_builder()
            .http_status_as_error(false)
            .timeout_global(Some(Duration::from_secs(60)))
            .build()
            .into();
        let request = ureq::http::Request::builder()
            .method(method)
            .uri(format!("{}{path}", self.url));
        let request = headers.iter().fold(request, |r, (name, value)| r.header(*name, *value));
        let answer = match body.is_empty() {
            true => agent.run(request.body(()).unwrap()),
            false => agent.run(request.body(body.to_string()).unwrap()),
        };
        let Ok(mut answer) = answer else { return (0, Value::Null) };
        let status = answer.status().as_u16();
        let text = answer.body_mut().with_config().limit(64 << 20).read_to_string();
        (
            status,
            text.ok().and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default(),
        )
    }

    pub fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        self.send("POST", path, &[("content-type", "application/json")], &body.to_string())
    }

    /// The state of a job.
    pub fn state(&self, id: &str) -> String {
        self.get(&format!("/jobs/{id}")).1["state"]
            .as_str()
            .unwrap_or_default()
            .to_string()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn wait_until(what: &str, condition: impl Fn() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < Duration::from_secs(120), "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A temporary folder that goes when this is dropped.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("dynident-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn place(&self) -> Place {
        Place {
            folder: self.0.join("data"),
            database: None,
            network: None,
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
