//! The two ways in which users hand in a case: the program and the service.

use super::server::Server;
use super::written::unreadable;
use super::{Answer, Case, RobotFile, Work};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

pub trait Way {
    fn name(&self) -> &'static str;

    /// # Errors
    /// What must never be: an error of the program's own, its end, an answer that cannot be read.
    fn answer(&self, case: &Case) -> Result<Answer, String>;
}

/// A folder of its own, removed at its end.
pub struct CommandLine(PathBuf);

impl CommandLine {
    pub fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("dynident-classes-{}-{count}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, content: &[u8]) -> String {
        let path = self.0.join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }

    fn robot(&self, robot: &RobotFile) -> String {
        match robot {
            RobotFile::Named(name) => (*name).to_string(),
            RobotFile::Json(text) => self.write("robot.json", text.as_bytes()),
            RobotFile::Urdf(bytes) => self.write("robot.urdf", bytes),
            RobotFile::Mjcf(text) => self.write("robot.xml", text.as_bytes()),
        }
    }

    fn arguments(&self, case: &Case) -> Vec<String> {
        let robot = self.robot(&case.robot);
        let mut all = vec!["base-parameters".to_string(), "--json".into(), "--robot".into(), robot];
        if matches!(case.work, Work::Read) {
            return all;
        }
        all.splice(
            ..2,
            [if matches!(case.work, Work::Excite) {
                "excite"
            } else {
                "identify"
            }
            .to_string()],
        );
        let request = self.write("request.json", case.request.to_string().as_bytes());
        let out = self.0.join("result.json").display().to_string();
        all.extend(["--request".into(), request, "--out".into(), out]);
        for (name, content) in &case.logs {
            all.extend(["--log".into(), self.write(name, content)]);
        }
        all
    }
}

impl Drop for CommandLine {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Way for CommandLine {
    fn name(&self) -> &'static str {
        "command line"
    }

    fn answer(&self, case: &Case) -> Result<Answer, String> {
        let result = self.0.join("result.json");
        let _ = std::fs::remove_file(&result);
        let mut command = Command::new(env!("CARGO_BIN_EXE_dynident"));
        let output = command.args(self.arguments(case)).output().map_err(|e| e.to_string())?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        if said.contains("panicked") {
            return Err(said);
        }
        if let Some(odd) = unreadable(&said).or(unreadable(&printed)).filter(|odd| !case.gives(odd)) {
            return Err(format!("says {odd}: {said}"));
        }
        match output.status.code() {
            Some(2) => Ok(Answer::Refused(said)),
            // An excitation that meets no constraint has been looked for.
            Some(0 | 3) => {
                let text = if matches!(case.work, Work::Read) {
                    printed
                } else {
                    std::fs::read_to_string(&result).map_err(|e| e.to_string())?
                };
                document(&text, case)
            }
            code => Err(format!("ended with {code:?}: {said}")),
        }
    }
}

fn document(text: &str, case: &Case) -> Result<Answer, String> {
    if let Some(odd) = unreadable(text).filter(|odd| !case.gives(odd)) {
        return Err(format!("the result has {odd}"));
    }
    serde_json::from_str(text)
        .map(Answer::Done)
        .map_err(|e| format!("{e}: {text}"))
}

pub struct Http(Server);

impl Http {
    pub fn new() -> Self {
        Self(Server::start())
    }

    fn read(&self, robot: &Value, case: &Case) -> Result<Answer, String> {
        let answer = self.0.post_json("/robots", &robot.to_string());
        if answer.status != 201 {
            return answered(answer.status, &answer.text, case);
        }
        let id = answer.json()["id"].as_str().unwrap_or_default().to_string();
        let found = self.0.get(&format!("/robots/{id}/base-parameters"));
        self.0.delete(&format!("/robots/{id}"));
        answered(found.status, &found.text, case)
    }
}

fn answered(status: u16, text: &str, case: &Case) -> Result<Answer, String> {
    match status {
        200 => document(text, case),
        400 | 413 | 415 | 422 => match unreadable(text).filter(|odd| !case.gives(odd)) {
            Some(odd) => Err(format!("says {odd}: {text}")),
            // As JSON, so that quotation marks are those of the words.
            None => {
                let said: Value = serde_json::from_str(text).map_err(|e| format!("{e}: {text}"))?;
                let mut words = vec![said["detail"].to_string().replace("\\\"", "\"")];
                words.extend(said["errors"].as_array().into_iter().flatten().map(|e| {
                    let part = |name: &str| e[name].as_str().unwrap_or_default().to_string();
                    format!("{}: {} ({})", part("pointer"), part("detail"), part("hint"))
                }));
                words.extend(said["hint"].as_str().map(String::from));
                Ok(Answer::Refused(words.join("\n")))
            }
        },
        _ => Err(format!("status {status}: {text}")),
    }
}

impl Way for Http {
    fn name(&self) -> &'static str {
        "HTTP"
    }

    fn answer(&self, case: &Case) -> Result<Answer, String> {
        let robot = in_document(&case.robot);
        let mut request = case.request.clone();
        if let Some(fields) = request.as_object_mut() {
            fields.insert("robot".into(), robot.clone());
        }
        let answer = match case.work {
            Work::Read => return self.read(&robot, case),
            Work::Excite => self.0.excite(&request),
            Work::Identify => self
                .0
                .post_raw("/identify", MULTIPART, &multipart(&request, &case.logs), None),
        };
        let alive = self.0.get("/health/live").status == 200;
        if alive {
            answered(answer.status, &answer.text, case)
        } else {
            Err("the server is gone".into())
        }
    }
}

pub const MULTIPART: &str = "multipart/form-data; boundary=XXboundary";

pub fn multipart(request: &Value, logs: &[(String, Vec<u8>)]) -> Vec<u8> {
    let part = |head: String, content: &[u8]| {
        let head = format!("--XXboundary\r\nContent-Disposition: form-data; {head}\r\n\r\n");
        [head.as_bytes(), content, b"\r\n"].concat()
    };
    let mut body = part("name=\"request\"".into(), request.to_string().as_bytes());
    for (name, content) in logs {
        body.extend(part(format!("name=\"log\"; filename=\"{name}\""), content));
    }
    body.extend_from_slice(b"--XXboundary--\r\n");
    body
}

/// The robot as a document has it. What is no JSON, or no text in UTF-8, is sent as it would be by a program that reads the file
/// as Latin-1.
fn in_document(robot: &RobotFile) -> Value {
    match robot {
        RobotFile::Named(name) => json!(name),
        RobotFile::Json(text) => serde_json::from_str(text).unwrap_or_else(|_| json!(text)),
        RobotFile::Urdf(bytes) => {
            let text = String::from_utf8(bytes.clone()).unwrap_or_else(|e| e.as_bytes().iter().map(|b| *b as char).collect());
            json!({"urdf": text})
        }
        RobotFile::Mjcf(text) => json!({"mjcf": text}),
    }
}
