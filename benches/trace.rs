//! What a tracing costs: seven joints, a spring on the fourth hidden, from a short log of repeated periods to a long one, and one without periods.
//!
//! `cargo bench --bench trace`

#[path = "../tests/effects/bench/mod.rs"]
mod bench;

use bench::*;
use dynident::identification::{Log, PreprocessOptions, prepare, preprocess::Period};
use dynident::residual::{Stretch, TraceOptions, trace};
use dynident::simulate::{Experiment, HiddenEffect, simulate};
use std::time::Instant;

fn main() {
    println!("| log | rows | preparing | tracing | found |\n|---|---|---|---|---|");
    run("6 periods of 10 s at 200 Hz", 6.0, 200.0, Period::Detect);
    run("16 periods of 10 s at 1 kHz", 16.0, 1000.0, Period::Detect);
    run("30 s at 1 kHz, not repeated", 3.0, 1000.0, Period::None);
    run("80 s at 1 kHz, not repeated", 8.0, 1000.0, Period::None);
}

fn run(name: &str, periods: f64, rate_hz: f64, period: Period) {
    let (robot, phi) = published();
    let spring = HiddenEffect::JointSpring {
        joint: 3,
        stiffness: 1.8,
        rest: 0.2,
    };
    let recorded = simulate(&Experiment {
        robot: &robot,
        parameters: &phi,
        trajectory: &wide_excitation(&robot, 1),
        periods,
        rate_hz,
        effects: &[spring],
        noise: &sensor_noise(7),
        seed: 1,
    });
    let log = Log {
        name: name.into(),
        rate_hz,
        start_s: 0.0,
        usable: vec![true; recorded.time.len()],
        q: recorded.q,
        qd: None,
        tau: recorded.tau,
    };
    let start = Instant::now();
    let options = PreprocessOptions {
        period,
        ..PreprocessOptions::default()
    };
    let prepared = prepare(&log, 7, &options).expect("a good log");
    let stretch = [Stretch::new(&prepared, &log)];
    let preparing = start.elapsed();
    let start = Instant::now();
    let report = trace(&robot, &stretch, &[], &TraceOptions::default()).report;
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
