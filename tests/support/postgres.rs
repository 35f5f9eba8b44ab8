//! A PostgreSQL server for the tests of this process: made afresh in a temporary folder, gone when the process ends, however it
//! ends.
#![allow(dead_code)]

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Starts and stops the server on a word from standard input, and takes everything away at its end: when the tests are gone, even
/// killed, their end of the pipe is closed. PostgreSQL refuses to run as root. Besides this machine, it knows the network
/// namespaces of the tests (198.18.0.0/15 is for tests of networks, and nobody's).
const KEEPER: &str = r#"
folder=$(mktemp -d "$3/dynident-postgres.XXXXXX"); bin=$1; port=$2; as=""
if [ "$(id -u)" = 0 ]; then chown postgres "$folder"; as="setpriv --reuid=postgres --regid=postgres --init-groups"; fi
cd "$folder"
$as "$bin/initdb" -D "$folder/db" -U dynident -A trust --no-sync -E UTF8 > /dev/null 2> "$folder/log" || { cat "$folder/log" >&2; exit 1; }
echo "host all all 198.18.0.0/15 trust" >> "$folder/db/pg_hba.conf"
start() { $as "$bin/postgres" -D "$folder/db" -p "$port" -k "$folder" -c listen_addresses='*' -c fsync=off -c max_connections=200 2> /dev/null & pid=$!; }
stop() { kill -INT $pid; wait $pid; }
start
while read -r word; do $word; done
stop; rm -rf "$folder"
"#;

pub struct Postgres {
    bin: PathBuf,
    port: u16,
    keeper: Mutex<Child>,
    databases: AtomicUsize,
}

fn installed() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = versions
        .map(|v| v.path().join("bin"))
        .filter(|b| b.join("initdb").exists())
        .collect();
    found.sort();
    found.pop()
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

impl Postgres {
    /// A server of its own.
    pub fn start() -> Self {
        Self::start_in(&std::env::temp_dir())
    }

    /// Its files in `folder`, which the user `postgres` can enter.
    pub fn start_in(folder: &Path) -> Self {
        if installed().is_none() {
            let setup = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/setup");
            assert!(Command::new(setup).status().unwrap().success(), "{setup} failed");
        }
        let bin = installed().expect("scripts/setup installs PostgreSQL");
        let port = free_port();
        let keeper = Command::new("sh")
            .args(["-c", KEEPER, "keeper"])
            .arg(&bin)
            .arg(port.to_string())
            .arg(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let server = Self {
            bin,
            port,
            keeper: Mutex::new(keeper),
            databases: AtomicUsize::new(0),
        };
        server.wait();
        server
    }

    /// The server that the tests of this process share.
    pub fn shared() -> &'static Self {
        static SHARED: OnceLock<Postgres> = OnceLock::new();
        SHARED.get_or_init(Self::start)
    }

    fn wait(&self) {
        let started = Instant::now();
        let ready = || {
            let mut ask = Command::new(self.bin.join("pg_isready"));
            ask.args(["-q", "-h", "127.0.0.1", "-p", &self.port.to_string()]);
            TcpStream::connect(("127.0.0.1", self.port)).is_ok() && ask.status().is_ok_and(|s| s.success())
        };
        while !ready() {
            assert!(started.elapsed() < Duration::from_secs(60), "PostgreSQL does not start");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn say(&self, word: &str) {
        let mut keeper = self.keeper.lock().unwrap();
        writeln!(keeper.stdin.as_mut().unwrap(), "{word}").unwrap();
    }

    /// Ends the server as a crash of its machine would for its clients.
    pub fn go_away(&self) {
        self.say("stop");
        let started = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_ok() {
            assert!(started.elapsed() < Duration::from_secs(60), "PostgreSQL does not stop");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub fn come_back(&self) {
        self.say("start");
        self.wait();
    }

    /// Address of a new, empty database.
    pub fn database(&self) -> String {
        let name = format!("test{}", self.databases.fetch_add(1, Ordering::Relaxed));
        let mut create = Command::new(self.bin.join("createdb"));
        create.args(["-h", "127.0.0.1", "-p", &self.port.to_string(), "-U", "dynident", &name]);
        assert!(create.status().unwrap().success());
        format!("postgres://dynident@127.0.0.1:{}/{name}", self.port)
    }

    /// What a query with one number says.
    pub fn ask(&self, database: &str, sql: &str) -> String {
        let answer = Command::new(self.bin.join("psql"))
            .args(["-tA", database, "-c", sql])
            .output()
            .unwrap();
        assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
        String::from_utf8_lossy(&answer.stdout).trim().to_string()
    }
}
