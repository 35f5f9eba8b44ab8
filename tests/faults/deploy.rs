//! What `examples/deploy` hands out: the proxy in front of a server, and the units. Skipped where nginx or systemd are not
//! installed.

use crate::process::{Folder, Process, wait_until};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/deploy").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// nginx with the shipped configuration, but for port, certificate and the server's address.
struct Proxy {
    child: Child,
    url: String,
}

impl Proxy {
    /// `None` where nginx or openssl is missing.
    fn start(folder: &Path, server: &str) -> Option<Self> {
        let (key, certificate) = (folder.join("key.pem"), folder.join("cert.pem"));
        let made = Command::new("openssl")
            .args([
                "req",
                "-x509",
                "-newkey",
                "rsa:2048",
                "-nodes",
                "-days",
                "1",
                "-subj",
                "/CN=dynident.example.org",
            ])
            .arg("-keyout")
            .arg(&key)
            .arg("-out")
            .arg(&certificate)
            .output();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let site = example("nginx.conf")
            .replace("listen 443", &format!("listen 127.0.0.1:{port}"))
            .replace(
                "/etc/letsencrypt/live/dynident.example.org/fullchain.pem",
                certificate.to_str()?,
            )
            .replace("/etc/letsencrypt/live/dynident.example.org/privkey.pem", key.to_str()?)
            .replace("http://127.0.0.1:8080", server);
        let at = folder.display();
        let paths: String = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"]
            .iter()
            .map(|name| format!("{name}_temp_path {at}/{name};"))
            .collect();
        let whole = format!(
            "daemon off; user root; pid {at}/pid; error_log {at}/error.log; events {{}}\nhttp {{ access_log off; {paths}\n{site}\n}}\n"
        );
        let path = folder.join("nginx.conf");
        std::fs::write(&path, whole).unwrap();
        let nginx = |arguments: &[&str]| {
            let mut command = Command::new("nginx");
            command.arg("-c").arg(&path).args(arguments).stderr(Stdio::piped());
            command
        };
        let tested = nginx(&["-t"]).output();
        let (Ok(made), Ok(tested)) = (made, tested) else { return None };
        assert!(made.status.success() && tested.status.success(), "{}", text(&tested.stderr));
        let child = nginx(&[]).spawn().unwrap();
        let url = format!("https://127.0.0.1:{port}");
        wait_until("nginx answers", || curl(&[&format!("{url}/health/live")]).status.success());
        Some(Self { child, url })
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        let _ = Command::new("kill").arg(self.child.id().to_string()).status();
        let _ = self.child.wait();
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn curl(arguments: &[&str]) -> Output {
    Command::new("curl").args(["-sSkf"]).args(arguments).output().unwrap()
}

fn document(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output.stdout)))
}

fn search(seconds: f64) -> String {
    json!({"robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50,
        "search": {"seed": 1, "time_limit_s": seconds}})
    .to_string()
}

#[test]
fn the_shipped_proxy_passes_on_results_events_and_large_logs() {
    let folder = Folder::new("proxy");
    let place = folder.place();
    let server = Process::serve(&place, &["--auth", "on"]);
    let Some(proxy) = Proxy::start(folder.path(), &server.url) else {
        println!("SKIPPED the_shipped_proxy_passes_on_results_events_and_large_logs: nginx or openssl is not installed");
        return;
    };
    let address = |path: &str| format!("{}{path}", proxy.url);
    let made = Command::new(env!("CARGO_BIN_EXE_dynident"))
        .args(["token", "create", "--robot", "*", "--role", "run", "--json", "--data"])
        .arg(&place.folder)
        .output();
    let token = document(&made.unwrap())["token"].as_str().unwrap().to_string();
    let bearer = format!("Authorization: Bearer {token}");
    // 22: an answer of 400 or more; nobody gets in without a token because the proxy is on this machine.
    assert_eq!(curl(&[&address("/jobs")]).status.code(), Some(22));

    let headers = ["-H", &bearer, "-H", "Content-Type: application/json"];
    let waited = curl(
        &[
            &headers[..],
            &["-H", "Prefer: wait=30", "-d", &search(2.0), &address("/excitation")],
        ]
        .concat(),
    );
    assert!(document(&waited)["condition_number"].as_f64().unwrap() > 1.0);

    let job = document(&curl(
        &[&headers[..], &["-d", &search(6.0), &address("/excitation")]].concat(),
    ));
    let events = address(job["links"]["events"].as_str().unwrap());
    let begun = Instant::now();
    let mut stream = Command::new("curl")
        .args(["-sSkfN", "-H", &bearer, &events])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let names: Vec<(Duration, String)> = BufReader::new(stream.stdout.take().unwrap())
        .lines()
        .map_while(Result::ok)
        .filter_map(|l| Some((begun.elapsed(), l.strip_prefix("event:")?.trim().to_string())))
        .collect();
    assert!(stream.wait().unwrap().success());
    assert_eq!(names.last().unwrap().1, "end", "{names:?}");
    let early = names.iter().filter(|(at, _)| *at < Duration::from_secs(3)).count();
    assert!(early >= 3, "events are held back: {names:?}");

    let log = log_of_megabytes(folder.path(), 40);
    let form = format!("log=@{}", log.display());
    let request = "request={\"robot\": \"planar_two_link\"}";
    let sent = curl(&["-H", &bearer, "-F", request, "-F", &form, &address("/identify")]);
    assert_eq!(document(&sent)["kind"], "identification");
}

fn log_of_megabytes(folder: &Path, megabytes: usize) -> PathBuf {
    let path = folder.join("log.csv");
    let mut file = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
    writeln!(file, "time,q1,q2,tau1,tau2").unwrap();
    let row = "0.000000,0.000000,0.000000,0.000000,0.000000\n";
    for _ in 0..(megabytes << 20) / row.len() {
        file.write_all(row.as_bytes()).unwrap();
    }
    path
}

#[test]
fn the_shipped_units_are_ones_that_systemd_takes() {
    let folder = Folder::new("units");
    for name in ["dynident.service", "dynident-worker.service"] {
        let unit = example(name);
        // Where the program will be installed there is none yet.
        assert!(unit.contains("ExecStart=/usr/local/bin/dynident "));
        let path = folder.path().join(name);
        std::fs::write(&path, unit.replace("/usr/local/bin/dynident", env!("CARGO_BIN_EXE_dynident"))).unwrap();
        let Ok(output) = Command::new("systemd-analyze").arg("verify").arg(&path).output() else {
            println!("SKIPPED the_shipped_units_are_ones_that_systemd_takes: systemd-analyze is not installed");
            return;
        };
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{name}: {}",
            text(&output.stderr)
        );
        // The command line in it is one that the program takes.
        let line = unit
            .lines()
            .find_map(|l| l.strip_prefix("ExecStart=/usr/local/bin/dynident "))
            .unwrap();
        let (command, flags) = line.split_once(' ').unwrap();
        assert!(["serve", "worker"].contains(&command));
        let settings = folder.place().command("config").args(flags.split(' ')).output().unwrap();
        assert!(settings.status.success(), "{}", text(&settings.stderr));
    }
}
