//! A server on a free port, and a client that hands back every answer whatever its status.
#![allow(dead_code)]

use dynident::service::{Config, serve};
use serde_json::Value;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::sync::oneshot;

/// A server that ends when this is dropped.
pub struct Server {
    pub address: SocketAddr,
    shutdown: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// An answer: status, headers, body.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub text: String,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap_or_else(|e| panic!("{e}: {}", self.text))
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers
            .iter()
            .find(|(n, _)| n.eq_ignore_ascii_case(name))
            .map(|(_, v)| v.as_str())
    }

    /// The problem document, checked to be one.
    pub fn problem(&self) -> Value {
        assert_eq!(self.header("content-type"), Some("application/problem+json"), "{self:?}");
        let problem = self.json();
        assert_eq!(problem["status"], self.status);
        for field in ["type", "title", "code", "detail"] {
            assert!(problem[field].is_string(), "{field} in {problem}");
        }
        problem
    }

    /// `pointer: detail (hint)` of every bad field.
    pub fn errors(&self) -> Vec<String> {
        let problem = self.problem();
        let line = |e: &Value| {
            let text = |name: &str| e[name].as_str().unwrap_or_default().to_string();
            format!("{}: {} ({})", text("pointer"), text("detail"), text("hint"))
        };
        problem["errors"]
            .as_array()
            .map(|all| all.iter().map(line).collect())
            .unwrap_or_default()
    }
}

impl Server {
    pub fn start() -> Self {
        Self::with(Config::default())
    }

    /// Its work is done in processes, as by the program, unless the configuration has a program of its own.
    pub fn with(config: Config) -> Self {
        let program = config.program.or_else(|| Some(env!("CARGO_BIN_EXE_dynident").into()));
        let config = Config { program, ..config };
        let (shutdown, stop) = oneshot::channel();
        let (sender, address) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Runtime::new().unwrap();
            runtime.block_on(async move {
                let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
                sender.send(listener.local_addr().unwrap()).unwrap();
                serve(listener, config, async move { drop(stop.await) }).await.unwrap();
            });
        });
        Self {
            address: address.recv().unwrap(),
            shutdown: Some(shutdown),
            thread: Some(thread),
        }
    }

    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    pub fn get(&self, path: &str) -> Answer {
        self.send("GET", path, &[], "")
    }

    pub fn delete(&self, path: &str) -> Answer {
        self.send("DELETE", path, &[], "")
    }

    pub fn post_json(&self, path: &str, body: &str) -> Answer {
        self.send("POST", path, &[("content-type", "application/json")], body)
    }

    /// POSTs an excitation and waits for its result.
    pub fn excite(&self, request: &Value) -> Answer {
        let headers = [("content-type", "application/json"), ("prefer", "wait=60")];
        self.send("POST", "/excitation", &headers, &request.to_string())
    }

    pub fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let agent: ureq::Agent = ureq::Agent::config_builder()
            .http_status_as_error(false)
            .timeout_global(Some(Duration::from_secs(120)))
            .allow_non_standard_methods(true)
            .build()
            .into();
        let request = ureq::http::Request::builder().method(method).uri(self.url(path));
        let request = headers.iter().fold(request, |r, (name, value)| r.header(*name, *value));
        let mut response = match body.is_empty() {
            true => agent.run(request.body(()).unwrap()).unwrap(),
            false => agent.run(request.body(body.to_string()).unwrap()).unwrap(),
        };
        let text = |v: &ureq::http::HeaderValue| String::from_utf8_lossy(v.as_bytes()).to_string();
        Answer {
            status: response.status().as_u16(),
            headers: response.headers().iter().map(|(n, v)| (n.to_string(), text(v))).collect(),
            text: response.body_mut().with_config().limit(200 << 20).read_to_string().unwrap(),
        }
    }

    /// POSTs a body of any bytes; with `declared`, one that says it is longer than it is and then hangs up.
    pub fn post_raw(&self, path: &str, content_type: &str, body: &[u8], declared: Option<usize>) -> Answer {
        use std::io::{Read, Write};
        let mut stream = std::net::TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let length = declared.unwrap_or(body.len());
        let head = format!(
            "POST {path} HTTP/1.1\r\nhost: {}\r\ncontent-type: {content_type}\r\ncontent-length: {length}\r\nprefer: wait=60\r\nconnection: close\r\n\r\n",
            self.address
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body).unwrap();
        // A client that closes its side is gone, as far as the server is concerned.
        // Where the server has answered and hung up before, there is no side left to close.
        if declared.is_some() {
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
        let mut text = Vec::new();
        // A server may close the connection of a client that hung up.
        let _ = stream.read_to_end(&mut text);
        let text = String::from_utf8_lossy(&text).to_string();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let mut lines = head.lines();
        let status = lines
            .next()
            .and_then(|l| l.split(' ').nth(1))
            .and_then(|s| s.parse().ok())
            .unwrap_or(0);
        let headers = lines
            .filter_map(|l| l.split_once(": "))
            .map(|(n, v)| (n.to_string(), v.to_string()))
            .collect();
        Answer {
            status,
            headers,
            text: body.to_string(),
        }
    }

    /// Ends the server as SIGTERM would and waits until it has.
    pub fn stop(&mut self) {
        drop(self.shutdown.take());
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Changes the database of a data folder behind the back of its server.
pub fn in_database(folder: &std::path::Path, sql: &str) {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    runtime.block_on(async {
        let address = format!("sqlite://{}", folder.join("dynident.sqlite").display());
        let pool = sqlx::SqlitePool::connect(&address).await.unwrap();
        sqlx::query(sqlx::AssertSqlSafe(sql.to_string()))
            .execute(&pool)
            .await
            .unwrap();
        pool.close().await;
    });
}

/// A problem small enough to be solved in well under a second.
pub fn quick_request() -> Value {
    serde_json::json!({
        "robot": "planar_two_link",
        "fourier": {"order": 3, "fundamental_hz": 0.2},
        "sample_rate_hz": 50,
        "constraints": {"form": "paper", "start": "zero"},
        "search": {"seed": 1, "starts": 2, "time_limit_s": 1}
    })
}

/// A problem that takes as long as it is given.
pub fn long_request() -> Value {
    serde_json::json!({
        "robot": "iiwa14",
        "fourier": {"order": 5, "fundamental_hz": 0.1},
        "sample_rate_hz": 100,
        "constraints": {"form": "paper", "start": "zero"},
        "search": {"seed": 1, "starts": 5000, "time_limit_s": 600}
    })
}
