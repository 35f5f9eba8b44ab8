//! What a tracing costs: seven joints, a spring on the fourth hidden, from a short log of repeated periods to a long one, and one
//! without periods.
//!
//! `cargo bench --bench trace`

#[path = "../tests/effects/bench/mod.rs"]
mod bench;

use bench::*;
use dynident::diagnosis::{DiagnosisOptions, diagnose};
use dynident::preparation::{Period, PreprocessOptions, prepare};
use dynident::regression::Stretch;
use std::time::Instant;

fn main() {
    println!("| log | rows | preparing | tracing | found |\n|---|---|---|---|---|");
    run("6 periods of 10 s at 200 Hz", 6.0, 200.0, Period::Detect);
    run("16 periods of 10 s at 1 kHz", 16.0, 1000.0, Period::Detect);
    run("30 s at 1 kHz, not repeated", 3.0, 1000.0, Period::None);
    run("80 s at 1 kHz, not repeated", 8.0, 1000.0, Period::None);
}

fn run(name: &str, periods: f64, rate_hz: f64, period: Period) {
    let (robot, log) = long_log(name, periods, rate_hz);
    let start = Instant::now();
    let options = PreprocessOptions {
        period,
        ..PreprocessOptions::default()
    };
    let prepared = prepare(&log, 7, &options).expect("a good log");
    let stretch = [Stretch::new(&prepared, &log)];
    let preparing = start.elapsed();
    let start = Instant::now();
    let report = diagnose(&robot, &stretch, &[], &DiagnosisOptions::default()).report;
    let found: Vec<String> = report
        .findings
        .iter()
        .map(|f| format!("{} {}", f.effect, f.joints.join("+")))
        .collect();
    println!(
        "| {name} | {} | {:.1} s | {:.1} s | {} |",
        log.samples(),
        preparing.as_secs_f64(),
        start.elapsed().as_secs_f64(),
        found.join(", ")
    );
}
