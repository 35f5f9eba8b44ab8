//! From a log of the paper's size (16 periods of 10 s at 1 kHz, seven joints: 160,000 rows of 15 numbers) to parameters: time and
//! memory, beside the same chain in pandas, SciPy and Pinocchio (`benches/identify_reference.py`; left out where those are not
//! installed).
//!
//! `cargo bench --bench identify [-- repetitions]`. Every run is a process of its own, so that its peak memory is its own.
//! `PYTHON` names the interpreter, `python3` if it is not set.

use dynident::app::{CancelFlag, LogFile, identify};
use dynident::documents::{NamedRobots, NoExcitations, read_identify_request, shipped::Shipped};
use dynident::formats::Parsed;
use dynident::parameters::Layout;
use dynident::simulate::{Experiment, Noise, simulate};
use dynident::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// The paper's chain and its (9): what the reference computes too; and everything that a default request gives, but for tracing.
const CHAINS: [&str; 2] = ["paper", "default"];

fn request(chain: &str) -> Value {
    match chain {
        "paper" => json!({
            "robot": "iiwa14", "period_s": 10, "trace": false, "estimator": "ols",
            "preprocess": {"method": "paper", "dead_zone": 0}, "feasible": {"method": "none"},
        }),
        _ => json!({"robot": "iiwa14", "trace": false}),
    }
}

fn write_log(path: &Path) -> std::io::Result<()> {
    let robot = Shipped.named("iiwa14").expect("shipped with the program").robot;
    let parameters = Layout::standard(&robot).prior(&robot).expect("the shipped robot has priors");
    let wave = |j: usize, l: usize, phase: f64| 0.1 * (l + 1) as f64 * (phase + 1.3 * j as f64 + 2.1 * l as f64).sin();
    let series = FourierSeries {
        fundamental_hz: 0.1,
        a: DMatrix::from_fn(7, 5, |j, l| wave(j, l, 0.4)),
        b: DMatrix::from_fn(7, 5, |j, l| wave(j, l, 1.7)),
        offset: vec![0.0; 7],
    };
    let noise = Noise {
        position: 1e-5,
        ..Noise::white(vec![0.3, 0.4, 0.15, 0.15, 0.1, 0.2, 0.06])
    };
    let log = simulate(&Experiment {
        robot: &robot,
        parameters: parameters.as_slice(),
        trajectory: &series,
        periods: 16.0,
        rate_hz: 1000.0,
        effects: &[],
        noise: &noise,
        seed: 1,
    });
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    let names = |stem: &str| (1..=7).map(|k| format!(",{stem}{k}")).collect::<String>();
    writeln!(file, "time{}{}", names("q"), names("tau"))?;
    for (s, t) in log.time.iter().enumerate() {
        write!(file, "{t:.3}")?;
        for column in log.q.iter().chain(&log.tau) {
            write!(file, ",{:.9}", column[s])?;
        }
        writeln!(file)?;
    }
    file.flush()
}

/// One identification in this process; prints what the parent reads.
fn run_one(chain: &str, path: &Path) {
    // As the program does.
    let parsed = Parsed {
        value: request(chain),
        problems: Vec::new(),
    };
    let begun = Instant::now();
    let request = read_identify_request(&parsed, &Shipped, &NoExcitations).expect("a valid request");
    let found = identify(&request, &[LogFile::at(path)], &[], &CancelFlag::default(), &|_| {}).expect("a good log");
    let seconds = begun.elapsed().as_secs_f64();
    let rms = &found.document.rms.identification[0].base.rms;
    println!("{}", json!({"seconds": seconds, "rms": rms, "peak_mb": peak_mb()}));
}

/// The largest resident set of this process (MB), where the system tells.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

fn child(mut command: Command) -> Option<Value> {
    let output = command.output().ok()?;
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        return None;
    }
    serde_json::from_slice(output.stdout.trim_ascii()).ok()
}

/// The run of median time.
fn median(mut runs: Vec<Value>) -> Value {
    runs.sort_by(|a, b| {
        a["seconds"]
            .as_f64()
            .unwrap_or(0.0)
            .total_cmp(&b["seconds"].as_f64().unwrap_or(0.0))
    });
    runs.swap_remove(runs.len() / 2)
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if let [flag, chain, path] = arguments.as_slice()
        && flag == "--one"
    {
        run_one(chain, Path::new(path));
        return Ok(());
    }
    let repetitions: usize = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(5);
    let path = std::env::temp_dir().join(format!("dynident-bench-{}.csv", std::process::id()));
    write_log(&path)?;
    let size = std::fs::metadata(&path)?.len() as f64 / 1e6;
    println!("160,000 rows of 15 numbers, {size:.0} MB of CSV; median of {repetitions} runs");
    let me = std::env::current_exe()?;
    let mut own = Vec::new();
    for chain in CHAINS {
        let once = || {
            let mut command = Command::new(&me);
            command.arg("--one").arg(chain).arg(&path);
            child(command).expect("an identification")
        };
        let run = median((0..repetitions).map(|_| once()).collect());
        println!(
            "{chain:8} {:8.3} s, peak {:.0} MB",
            run["seconds"].as_f64().unwrap_or(f64::NAN),
            run["peak_mb"].as_f64().unwrap_or(f64::NAN)
        );
        own.push(run);
    }
    let mut command = Command::new(std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_string()));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    command
        .arg(folder.join("benches/identify_reference.py"))
        .arg(folder.join("examples/robots/iiwa14.urdf"))
        .arg(&path);
    match child(command) {
        None => println!("reference skipped: it needs Python with pandas, scipy and pin (see PYTHON)"),
        Some(reference) => compare(&own, &reference),
    }
    std::fs::remove_file(&path)
}

fn compare(own: &[Value], reference: &Value) {
    let number = |run: &Value, field: &str| run[field].as_f64().unwrap_or(f64::NAN);
    let times = |field: &str, chain: usize| number(reference, field) / number(&own[chain], "seconds");
    println!(
        "reference {:7.3} s as far as base parameters, {:.1} times as long as `paper`; peak {:.0} MB",
        number(reference, "seconds"),
        times("seconds", 0),
        number(reference, "peak_mb"),
    );
    println!(
        "reference {:7.3} s with physical parameters (which fit {:.4} times the base parameters), {:.1} times as long as `default`",
        number(reference, "full_seconds"),
        number(reference, "ratio"),
        times("full_seconds", 1),
    );
    let rms = |run: &Value| -> Vec<f64> {
        run["rms"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_f64)
            .collect()
    };
    let pairs = rms(&own[0]).into_iter().zip(rms(reference));
    let worst = pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("residuals per joint agree to {worst:.1e} of their size");
}
