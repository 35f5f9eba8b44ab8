//! Running out of file handles: open connections are served, and new ones as soon as there are handles again.

use crate::process::{Folder, Process, wait_until};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::Duration;

/// A connection that is kept open.
struct Kept(TcpStream);

impl Kept {
    fn open(server: &Process) -> Self {
        let stream = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        Self(stream)
    }

    fn ask(&mut self, path: &str) {
        let request = format!("GET {path} HTTP/1.1\r\nhost: localhost\r\n\r\n");
        self.0.write_all(request.as_bytes()).unwrap();
    }

    /// Whether 200 is answered within `time`.
    fn answered(&mut self, time: Duration) -> bool {
        self.0.set_read_timeout(Some(time)).unwrap();
        let mut buffer = [0; 4096];
        let read = self.0.read(&mut buffer).unwrap_or(0);
        buffer[..read].starts_with(b"HTTP/1.1 200 ")
    }
}

/// Sets the soft limit on the handles of a process that runs.
fn limit(server: &Process, handles: usize) {
    let status = Command::new("prlimit")
        .args(["--pid", &server.child.id().to_string(), &format!("--nofile={handles}:")])
        .status();
    assert!(status.unwrap().success());
}

#[test]
fn without_handles_open_connections_are_served_and_new_ones_wait() {
    let folder = Folder::new("no-handles");
    let server = Process::serve(&folder.place(), &[]);
    let mut kept = Kept::open(&server);
    kept.ask("/health/live");
    assert!(kept.answered(Duration::from_secs(10)));
    // Fewer than are open: every further one is refused by the system.
    limit(&server, 5);
    let mut late = Kept::open(&server);
    late.ask("/health/live");
    assert!(!late.answered(Duration::from_millis(500)), "there was a handle left");
    for path in ["/health/live", "/jobs", "/robots"] {
        kept.ask(path);
        assert!(kept.answered(Duration::from_secs(10)), "{path}");
    }
    limit(&server, 1000);
    assert!(late.answered(Duration::from_secs(10)), "the connection that waited is served");
}

#[test]
fn with_few_handles_many_connections_do_not_take_those_of_the_work() {
    let folder = Folder::new("few-handles");
    let served = folder.place().command("serve");
    let mut command = Command::new("prlimit");
    command
        .arg("--nofile=80:80")
        .arg(served.get_program())
        .args(served.get_args());
    command.env_remove("DATABASE_URL").env_remove("DYNIDENT_CONFIG");
    command.args(["--listen", "127.0.0.1:0", "--log", "off", "--header-timeout-s", "2"]);
    let server = Process::start(command);
    wait_until("the server is ready", || server.get("/health/ready").0 == 200);
    // More than handles, and few enough to stand in the line of 128 that systems keep: further ones would try again after
    // seconds.
    let idle: Vec<Kept> = (0..120).map(|_| Kept::open(&server)).collect();
    // Those without a request are closed after two seconds, a few at a time; meanwhile nothing fails for want of handles.
    std::thread::sleep(Duration::from_millis(200));
    drop(idle);
    let robot = r#"{"robot": "planar_two_link", "fourier": {"order": 2, "fundamental_hz": 0.2}, "sample_rate_hz": 20,
        "search": {"seed": 1, "starts": 2, "max_evaluations": 100}}"#;
    let headers = [("content-type", "application/json"), ("prefer", "wait=60")];
    let (status, result) = server.send("POST", "/excitation", &headers, robot);
    assert_eq!(status, 200, "{result}");
}
