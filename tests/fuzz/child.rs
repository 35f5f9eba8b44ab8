//! The process in which inputs are tried: one after the other, until one kills it.

use super::bases;
use super::case::{Draft, Recipe, write};
use super::target::{Folders, Taken, Target, run};
use super::words::unprintable;
use rustix::process::{Resource, Rlimit, setrlimit};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Before every line for the parent: the program writes to the same pipe.
pub const MARK: &str = "@@fuzz ";
/// Address space: whoever asks for more is refused by the system and dies, instead of taking the machine along.
const MOST_ADDRESSES: u64 = 4 << 30;
/// As a thread of the server has it.
const STACK: usize = 2 << 20;

/// The first panic of the present input, in whatever thread.
static PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Takes orders from standard input: a recipe, or a folder with the files of an input.
pub fn serve(work: &Path) {
    let limit = Rlimit {
        current: Some(MOST_ADDRESSES),
        maximum: Some(MOST_ADDRESSES),
    };
    setrlimit(Resource::As, limit).expect("limits can be lowered");
    std::panic::set_hook(Box::new(|info| {
        let place = info
            .location()
            .map(|l| format!("{}:{}", l.file(), l.line()))
            .unwrap_or_default();
        let message = info.payload_as_str().unwrap_or("no message");
        eprintln!("panic: {place}: {message}");
        let mut first = PANIC.lock().unwrap_or_else(|e| e.into_inner());
        first.get_or_insert_with(|| format!("panic: {place}: {message}"));
    }));
    let folders = Folders {
        input: work.join("input"),
        output: work.join("output"),
    };
    let mut known: HashMap<Target, Vec<Draft>> = HashMap::new();
    for line in std::io::stdin().lock().lines() {
        let Ok(order) = line
            .map_err(drop)
            .and_then(|l| serde_json::from_str::<Value>(&l).map_err(drop))
        else {
            return;
        };
        let Some((target, size)) = lay_out(&order, &folders, &mut known) else {
            return;
        };
        println!("\n{MARK}{}", json!({"size": size}));
        println!("\n{MARK}{}", tried(target, &folders));
    }
}

/// Puts the files of an input where they are tried.
fn lay_out(order: &Value, folders: &Folders, known: &mut HashMap<Target, Vec<Draft>>) -> Option<(Target, u64)> {
    for folder in [&folders.input, &folders.output] {
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).expect("temporary folders can be made");
    }
    if let Some(folder) = order["folder"].as_str() {
        let target = Target::named(order["target"].as_str()?)?;
        let files = files_of(Path::new(folder));
        let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(name, content)| (name.as_str(), content.clone())).collect();
        return Some((target, write(&files, &folders.input)));
    }
    let recipe = Recipe::from_json(order)?;
    let bases = known.entry(recipe.target).or_insert_with(|| bases::of(recipe.target));
    Some((recipe.target, write(&recipe.draft(bases).render(), &folders.input)))
}

/// Names and contents of the files in a folder.
pub fn files_of(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries
        .map(|e| e.expect("folders can be listed").path())
        .filter(|p| p.is_file());
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name, std::fs::read(path).expect("files can be read"))
    };
    paths.map(read).collect()
}

/// What became of the input that is laid out.
fn tried(target: Target, folders: &Folders) -> Value {
    *PANIC.lock().unwrap_or_else(|e| e.into_inner()) = None;
    reset_peak();
    let before = cpu_seconds();
    let ended = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK);
        let running = thread
            .spawn_scoped(scope, || run(target, folders))
            .expect("threads can be started");
        running.join().unwrap_or_else(|_| Err("panic".into()))
    });
    let (cpu_s, peak) = (cpu_seconds() - before, peak_bytes());
    let panicked = PANIC.lock().unwrap_or_else(|e| e.into_inner()).take();
    let refused = match &ended {
        Ok(Taken::Refused(words)) => words.as_str(),
        _ => "",
    };
    let failure = panicked
        .or(ended.as_ref().err().cloned())
        .or_else(|| unprintable(folders, refused));
    json!({"refused": refused, "accepted": ended == Ok(Taken::Accepted), "failure": failure, "peak": peak, "held": memory("VmRSS:"), "cpu_s": cpu_s})
}

fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Makes the system measure the peak of this process afresh.
fn reset_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Most memory that this process has had since then.
fn peak_bytes() -> u64 {
    memory("VmHWM:")
}

/// A number of bytes that the system knows of this process.
fn memory(field: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(field));
    let kilobytes = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    1024 * kilobytes.unwrap_or(0)
}
