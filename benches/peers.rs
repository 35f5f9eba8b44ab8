//! Ours and other libraries on the same robot and motion, in one run: `cargo bench --bench peers [-- rounds]`.
//!
//! Peers are left out by name where they are not installed. Pinocchio's C++ interface is compiled here against the headers of its
//! wheel (`scripts/setup test` installs that; Debian's `libeigen3-dev` is needed beside it), with `-O3 -march=native`; Python's
//! interpreter is `PYTHON`, else that of the wheel: `pip install cvxpy figaroh` there adds two peers. Ours is the release
//! profile, with vector widths chosen at run time.
//!
//! The peers take turns, round by round of the whole list; ratios are those of the medians, with the least and largest ratio of
//! two rounds. Absolute times say little on a machine that has other work.

#[path = "../tests/instructions/problem.rs"]
mod problem;

use dynident::dynamics::{Chain, ColumnSet, Coulomb, RowBlocks, inverse_dynamics_batch};
use dynident::identification::physical::{ConsistentOptions, FitObjective, fit_consistent};
use dynident::model::Robot;
use dynident::parameters::{BaseParameters, Layout};
use dynident::preparation::{Log, PreprocessOptions, prepare};
use dynident::regression::{Estimator, Stretch, estimate};
use dynident::simulate::{Experiment, Noise, simulate};
use dynident::trajectory::FourierSeries;
use nalgebra::DMatrix;
use problem::{SAMPLES, motion, paper_search, robot};
use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Microseconds per sample, round by round.
type Rounds = BTreeMap<String, Vec<f64>>;

/// What is compared: a title, ours, and the peers.
const COMPARED: &[(&str, &str, &[&str])] = &[
    (
        "inverse dynamics, per sample",
        "inverse_dynamics",
        &["pinocchio_inverse_dynamics", "python_inverse_dynamics"],
    ),
    (
        "regressor, per sample (ours: base columns with friction)",
        "base_regressor",
        &["pinocchio_regressor", "python_regressor", "figaroh_regressor"],
    ),
    (
        "design criterion with gradient, per sample (Pinocchio: regressor and Gram matrix alone; SciPy: condition number by differences)",
        "criterion_and_gradient",
        &["pinocchio_regressor_and_gram", "scipy_criterion_and_gradient"],
    ),
    (
        "physically consistent bodies of seven links, per fit (CVXPY with Clarabel: the cone programme once, ours with the choice of the pull's weight)",
        "consistent_bodies",
        &["cvxpy_consistent_bodies"],
    ),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let rounds: usize = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(5);
    let mut all = Rounds::new();
    let pinocchio = compiled().map_err(|e| println!("skipped Pinocchio in C++: {e}")).ok();
    for round in 0..rounds {
        ours(&mut all);
        if let Some(program) = &pinocchio {
            collect(&mut all, "pinocchio_", Command::new(program).args(["1000", "1"]), round);
        }
        let script = format!("{ROOT}/benches/peers/peers.py");
        let mut peers = Command::new(python());
        peers
            .args([&script, &urdf(), "200", "1"])
            .env("OPENBLAS_NUM_THREADS", "1")
            .env("OMP_NUM_THREADS", "1");
        collect(&mut all, "", &mut peers, round);
    }
    COMPARED.iter().for_each(|compared| print_ratios(&all, compared));
}

fn urdf() -> String {
    format!("{ROOT}/examples/robots/iiwa14.urdf")
}

fn wheel() -> PathBuf {
    Path::new(ROOT).join("target/simulators")
}

fn python() -> PathBuf {
    std::env::var_os("PYTHON").map_or_else(|| wheel().join("bin/python"), PathBuf::from)
}

/// The program of `benches/peers/pinocchio.cpp`, compiled once.
fn compiled() -> Result<PathBuf, String> {
    let program = Path::new(ROOT).join("target/peers-pinocchio");
    let source = Path::new(ROOT).join("benches/peers/pinocchio.cpp");
    let changed = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
    if changed(&program) > changed(&source) {
        return Ok(program);
    }
    let library = Command::new(wheel().join("bin/python"))
        .args([
            "-c",
            "import cmeel, os; print(os.path.dirname(os.path.dirname(cmeel.__file__)))",
        ])
        .output()
        .map_err(|e| format!("the wheel `pin`: {e}"))?;
    let prefix = PathBuf::from(String::from_utf8_lossy(&library.stdout).trim()).join("cmeel.prefix");
    let (include, lib) = (prefix.join("include"), prefix.join("lib"));
    // As the wheel itself was built.
    let boost = [
        "MPL_LIMIT_LIST_SIZE=30",
        "MPL_LIMIT_VECTOR_SIZE=30",
        "MPL_CFG_NO_PREPROCESSED_HEADERS",
        "FUSION_INVOKE_MAX_ARITY=12",
    ];
    let output = Command::new("c++")
        .args(["-O3", "-DNDEBUG", "-march=native", "-std=c++17", "-I/usr/include/eigen3"])
        .args(boost.map(|d| format!("-DBOOST_{d}")))
        .arg(format!("-I{}", include.display()))
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .arg(format!("-L{}", lib.display()))
        .arg("-lpinocchio_default")
        .arg(format!("-Wl,-rpath,{0},-rpath-link,{0}", lib.display()))
        .output()
        .map_err(|e| e.to_string())?;
    let said = String::from_utf8_lossy(&output.stderr);
    let error = said.lines().find(|l| l.contains("error")).unwrap_or("the compiler failed");
    output.status.success().then_some(program).ok_or_else(|| error.to_string())
}

/// Lines of a peer: a name and its time, or what is skipped.
fn collect(all: &mut Rounds, prefix: &str, command: &mut Command, round: usize) {
    let output = match command.output() {
        Ok(output) => output,
        Err(error) => return println!("skipped {command:?}: {error}"),
    };
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        match words.next().and_then(|w| w.parse().ok()) {
            Some(time) => all.entry(format!("{prefix}{name}")).or_default().push(time),
            None if round == 0 => println!("{line}"),
            None => (),
        }
    }
}

/// Best of a few repetitions [µs per unit].
fn best(units: f64, mut work: impl FnMut()) -> f64 {
    let times = (0..5).map(|_| {
        let begun = Instant::now();
        work();
        begun.elapsed().as_secs_f64()
    });
    1e6 * times.fold(f64::INFINITY, f64::min) / units
}

fn ours(all: &mut Rounds) {
    let robot = robot();
    let (layout, chain) = (Layout::standard(&robot), Chain::new(&robot));
    let columns = ColumnSet::new(&robot, &layout, &BaseParameters::exact(&robot).kept);
    let motion = motion();
    let phi: Vec<f64> = (0..layout.len()).map(|i| (i as f64).sin()).collect();
    let mut rows = RowBlocks::new(&columns, SAMPLES);
    let mut add = |name: &str, time: f64| all.entry(name.to_string()).or_default().push(time);
    let samples = SAMPLES as f64;
    add(
        "base_regressor",
        best(samples, || rows.fill(&chain, &columns, &motion, Coulomb::Sign)),
    );
    let torques = || {
        black_box(inverse_dynamics_batch(&chain, &layout, &phi, &motion, Coulomb::Sign));
    };
    add("inverse_dynamics", best(samples, torques));
    let objective = bodies_objective(&robot);
    let bodies = || {
        black_box(fit_consistent(&robot, &objective, &ConsistentOptions::default()));
    };
    add("consistent_bodies", best(1.0, bodies));
    add("criterion_and_gradient", evaluation());
}

/// What bodies are fitted to: ten periods of a motion at 100 Hz with noise.
fn bodies_objective(robot: &Robot) -> FitObjective {
    let parameters = Layout::standard(robot).prior(robot).expect("the shipped robot has priors");
    let wave = |j: usize, l: usize, phase: f64| 0.1 * (l + 1) as f64 * (phase + 1.3 * j as f64 + 2.1 * l as f64).sin();
    let series = FourierSeries {
        fundamental_hz: 0.1,
        a: DMatrix::from_fn(7, 5, |j, l| wave(j, l, 0.4)),
        b: DMatrix::from_fn(7, 5, |j, l| wave(j, l, 1.7)),
        offset: vec![0.0; 7],
    };
    let recorded = simulate(&Experiment {
        robot,
        parameters: parameters.as_slice(),
        trajectory: &series,
        periods: 10.0,
        rate_hz: 100.0,
        effects: &[],
        noise: &Noise::white(vec![0.3, 0.4, 0.15, 0.15, 0.1, 0.2, 0.06]),
        seed: 1,
    });
    let log = Log {
        name: "simulated".to_string(),
        rate_hz: 100.0,
        start_s: 0.0,
        usable: vec![true; recorded.time.len()],
        channels: Vec::new(),
        q: recorded.q,
        qd: None,
        tau: recorded.tau,
    };
    let prepared = prepare(&log, 7, &PreprocessOptions::default()).expect("a good log");
    let found = estimate(robot, &[Stretch::new(&prepared, &log)], Estimator::Weighted);
    FitObjective::new(&found.base, &found.normals, &found.estimate.values)
}

/// One evaluation in a search on the paper's problem, solver and projection onto the limits included [µs per sample: local solves
/// go over 100 of them].
fn evaluation() -> f64 {
    let begun = Instant::now();
    let evaluations = paper_search(2000);
    1e6 * begun.elapsed().as_secs_f64() / evaluations as f64 / 104.0
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

fn print_ratios(all: &Rounds, (title, ours, peers): &(&str, &str, &[&str])) {
    let Some(own) = all.get(*ours) else { return };
    println!("\n{title}\n  {:32} {:10.3} µs", "dynident", median(own.clone()));
    for peer in peers.iter().filter(|p| all.contains_key(**p)) {
        let times = &all[*peer];
        let ratios: Vec<f64> = times.iter().zip(own).map(|(t, o)| t / o).collect();
        let (least, most) = ratios
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(l, m), r| (l.min(*r), m.max(*r)));
        println!(
            "  {peer:32} {:10.3} µs   {:8.1} times ours ({least:.1} to {most:.1})",
            median(times.clone()),
            median(times.clone()) / median(own.clone())
        );
    }
}
