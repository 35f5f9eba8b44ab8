//! Watches over a process that tries inputs.

use super::case::Recipe;
use super::child::MARK;
use super::target::Target;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Processor time of one input (s), and what every byte of it may cost in addition. A whole identification of these sizes takes a
/// tenth of a second; the limit is far above that, so that only work without end, or of the square of its input, reaches it.
const CPU_S: f64 = 10.0;
const CPU_S_PER_BYTE: f64 = 20e-6;
/// Wall time in the same unit: a process that waits for ever uses no processor.
const WALL_PER_CPU: f64 = 12.0;
/// Memory: 200 MB and ten times the input.
const MEMORY: u64 = 200_000_000;
const MEMORY_PER_BYTE: u64 = 10;
/// Memory with which a process is replaced.
const GROWN: u64 = 100_000_000;

/// What became of an input.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Verdict {
    pub accepted: bool,
    /// What the program said where it refused the input.
    pub refused: String,
    /// Kind and detail, as in `panic: src/x.rs:3: …`.
    pub failure: Option<String>,
    pub peak: u64,
    pub cpu_s: f64,
    pub size: u64,
    /// Memory that the process keeps after it.
    pub held: u64,
}

/// What to try.
pub enum Order<'a> {
    Recipe(&'a Recipe),
    Folder(Target, &'a Path),
}

impl Order<'_> {
    fn to_json(&self) -> Value {
        match self {
            Order::Recipe(recipe) => recipe.to_json(),
            Order::Folder(target, folder) => json!({"target": target.name(), "folder": folder}),
        }
    }
}

/// A process, started again when an input has killed it.
pub struct Runner {
    work: PathBuf,
    process: Option<Process>,
}

struct Process {
    child: Child,
    orders: ChildStdin,
    lines: Receiver<Value>,
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        self.process = None;
        let _ = std::fs::remove_dir_all(&self.work);
    }
}

impl Runner {
    pub fn new() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let work = std::env::temp_dir().join(format!("dynident-fuzz-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&work).expect("temporary folders can be made");
        Self { work, process: None }
    }

    /// The files of the last input.
    pub fn input(&self) -> PathBuf {
        self.work.join("input")
    }

    pub fn run(&mut self, order: &Order) -> Verdict {
        let work = self.work.clone();
        let process = self.process.get_or_insert_with(|| Process::start(&work));
        let verdict = process.run(order, &work);
        // A process that keeps much of what a large input took would be charged to the next one: as in the service, another takes
        // its place.
        if verdict.as_ref().map_or(true, |v| v.held > GROWN) {
            self.process = None;
        }
        verdict.unwrap_or_else(|died| died)
    }
}

impl Process {
    fn start(work: &Path) -> Self {
        let errors = File::create(work.join("errors")).expect("temporary files can be written");
        let program = std::env::current_exe().expect("this program has a path");
        let mut child = Command::new(program)
            .arg("child")
            .arg(work)
            // One thread each: several processes run side by side.
            .envs([
                ("RAYON_NUM_THREADS", "1"),
                ("OPENBLAS_NUM_THREADS", "1"),
                ("MALLOC_ARENA_MAX", "1"),
                ("RUST_BACKTRACE", "0"),
            ])
            .env_remove("DATABASE_URL")
            .env_remove("DYNIDENT_CONFIG")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(errors)
            .spawn()
            .expect("this program can be started");
        let output = child.stdout.take().expect("is piped");
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                let marked = line.strip_prefix(MARK).and_then(|l| serde_json::from_str(l).ok());
                if let Some(value) = marked
                    && sender.send(value).is_err()
                {
                    return;
                }
            }
        });
        Self {
            orders: child.stdin.take().expect("is piped"),
            child,
            lines,
        }
    }

    /// An error is a verdict too: the process is gone.
    fn run(&mut self, order: &Order, work: &Path) -> Result<Verdict, Verdict> {
        let mut size = 0;
        let failed = |failure: String, size: u64| Verdict {
            failure: Some(failure),
            size,
            ..Verdict::default()
        };
        if writeln!(self.orders, "{}", order.to_json()).is_err() {
            return Err(failed(format!("death: {}", self.last_words(work)), 0));
        }
        // Bases are made before the first input, which takes its time.
        let (mut started, mut cpu_before) = (Instant::now(), self.cpu_s() + CPU_S);
        loop {
            let limit = CPU_S + CPU_S_PER_BYTE * size as f64;
            match self.lines.recv_timeout(Duration::from_millis(50)) {
                Ok(value) if value["size"].is_u64() => {
                    size = value["size"].as_u64().unwrap_or(0);
                    (started, cpu_before) = (Instant::now(), self.cpu_s());
                }
                Ok(value) => return Ok(judged(&value, size)),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failed(format!("death: {}", self.last_words(work)), size));
                }
                Err(RecvTimeoutError::Timeout) => {
                    let used = self.cpu_s() - cpu_before;
                    if used > limit || started.elapsed().as_secs_f64() > WALL_PER_CPU * limit {
                        return Err(failed(format!("endless: more than {limit:.0} s for {size} bytes"), size));
                    }
                }
            }
        }
    }

    /// Processor time that the process has used so far.
    fn cpu_s(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap_or_default();
        let after_name = stat.rsplit(')').next().unwrap_or_default();
        let ticks = |field: usize| after_name.split_whitespace().nth(field).and_then(|t| t.parse::<f64>().ok());
        // User and system time are fields 14 and 15, in hundredths of a second on every Linux.
        (ticks(11).unwrap_or(0.0) + ticks(12).unwrap_or(0.0)) / 100.0
    }

    /// How the process ended, and what it said last.
    fn last_words(&mut self, work: &Path) -> String {
        let status = self.child.wait().map(|s| s.to_string()).unwrap_or_default();
        let errors = std::fs::read(work.join("errors")).unwrap_or_default();
        let text = String::from_utf8_lossy(&errors);
        let last: Vec<&str> = text.lines().rev().filter(|l| !l.trim().is_empty()).take(2).collect();
        format!("{status}: {}", last.into_iter().rev().collect::<Vec<_>>().join(" / "))
    }
}

fn judged(value: &Value, size: u64) -> Verdict {
    let peak = value["peak"].as_u64().unwrap_or(0);
    let most = MEMORY + MEMORY_PER_BYTE * size;
    let failure = value["failure"].as_str().map(str::to_string);
    let hungry = (peak > most).then(|| format!("memory: {} MB for {} kB", peak / 1_000_000, size / 1000));
    Verdict {
        accepted: value["accepted"].as_bool().unwrap_or(false),
        failure: failure.or(hungry),
        refused: value["refused"].as_str().unwrap_or_default().to_string(),
        peak,
        cpu_s: value["cpu_s"].as_f64().unwrap_or(0.0),
        size,
        held: value["held"].as_u64().unwrap_or(0),
    }
}
