//! The published experiment again, on a virtual robot: Table 3's parameters, an excitation trajectory under the paper's
//! constraints, 16 periods of 10 s at 1 kHz, the paper's filters, its (9) and (10a–d), and its four validation trajectories.
//! Prints the paper's Tables 2, 3 and 4 in Markdown, with the paper's own numbers beside them.
//!
//! `cargo run --release --example paper_experiment [evaluations of the excitation search]`

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::excitation::{
    Control, Criterion, Form, Halt, Knowledge, Problem, ProblemSpec, Progress, SearchOptions, Start, search,
};
use dynident::identification::physical::{
    ConsistentOptions, FeasibleMethod, FeasibleOptions, FitObjective, PaperFit, PaperOptions, Triangle, fit_consistent,
    fit_feasible, fit_paper,
};
use dynident::model::{Joint, Robot};
use dynident::parameters::{BaseParameters, Layout};
use dynident::preparation::{Log, Period, PreparedLog, PreprocessOptions, prepare};
use dynident::regression::{AugmentedModel, Estimator, Fitted as BaseFit, Stretch, estimate};
use dynident::simulate::{Experiment, Noise, simulate};
use dynident::trajectory::{QuinticWayPoints, SineSeries, Trajectory};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::f64::consts::TAU;
use std::time::Instant;

const PERIOD_S: f64 = 10.0;
const PERIODS: f64 = 16.0;
const RATE_HZ: f64 = 1000.0;
/// Table 4, first column: what the paper's base parameters leave of the averaged, filtered torques [N m].
const TABLE_4_BASE: [f64; 7] = [0.29, 0.36, 0.13, 0.15, 0.08, 0.18, 0.06];
/// Table 4, physical parameters on the four trajectories [N m].
const TABLE_4_PHYSICAL: [[f64; 7]; 4] = [
    [0.35, 0.39, 0.14, 0.17, 0.09, 0.21, 0.10],
    [0.34, 0.44, 0.23, 0.17, 0.12, 0.22, 0.12],
    [0.55, 0.48, 0.23, 0.25, 0.15, 0.22, 0.12],
    [0.43, 0.74, 0.15, 0.27, 0.06, 0.15, 0.06],
];

/// Ends the search at its number of evaluations alone.
struct Alone;

impl Control for Alone {
    fn halt(&self) -> Option<Halt> {
        None
    }
    fn progress(&self, _: &Progress) {}
}

/// What sensors add: white noise of four times Table 4's errors, so that the mean of 16 periods carries just those.
fn noise() -> Noise {
    Noise {
        position: 1e-5,
        ..Noise::white(TABLE_4_BASE.iter().map(|rms| rms * PERIODS.sqrt()).collect())
    }
}

struct Bench {
    /// With the truth as its priors.
    truth: Robot,
    /// As declared to the identification: without.
    robot: Robot,
    base: BaseParameters,
}

impl Bench {
    fn new() -> Self {
        let truth = Shipped.named("iiwa14").expect("shipped with the program").robot;
        let bare = |joint: &Joint| Joint {
            prior: None,
            ..joint.clone()
        };
        let joints = truth.joints().iter().map(bare).collect();
        let robot = Robot::new(truth.name(), truth.gravity(), joints, truth.friction()).expect("valid without priors");
        Self {
            base: BaseParameters::exact(&robot),
            truth,
            robot,
        }
    }

    fn parameters(&self) -> DVector<f64> {
        Layout::standard(&self.truth)
            .prior(&self.truth)
            .expect("the shipped robot has priors")
    }

    fn run(&self, name: &str, trajectory: &dyn Trajectory, seed: u64) -> Log {
        let recorded = simulate(&Experiment {
            robot: &self.truth,
            parameters: self.parameters().as_slice(),
            trajectory,
            periods: PERIODS,
            rate_hz: RATE_HZ,
            effects: &[],
            noise: &noise(),
            seed,
        });
        Log {
            name: name.to_string(),
            rate_hz: RATE_HZ,
            start_s: 0.0,
            usable: vec![true; recorded.time.len()],
            channels: Vec::new(),
            q: recorded.q,
            qd: None,
            tau: recorded.tau,
        }
    }
}

/// The paper's chain, or the default one with its period stated.
fn prepared(log: &Log, paper: bool) -> PreparedLog {
    let options = match paper {
        true => PreprocessOptions::paper(PERIOD_S),
        false => PreprocessOptions {
            period: Period::Known {
                period_s: PERIOD_S,
                order: None,
            },
            ..PreprocessOptions::default()
        },
    };
    prepare(log, 7, &options).expect("16 whole periods")
}

struct Fitted {
    stretch: Stretch,
    /// The paper's (9).
    base: BaseFit,
    objective: FitObjective,
    paper: PaperFit,
    /// The model with the base parameters of the bodies.
    physical: AugmentedModel,
}

fn fit(bench: &Bench, log: &Log, paper: bool) -> Fitted {
    let prepared = prepared(log, paper);
    let stretch = Stretch::new(&prepared, log);
    let estimator = if paper { Estimator::Ordinary } else { Estimator::Weighted };
    let base = estimate(&bench.robot, std::slice::from_ref(&stretch), estimator);
    let objective = FitObjective::new(&base.base, &base.normals, &base.estimate.values);
    let options = FeasibleOptions {
        method: FeasibleMethod::Paper,
        consistent: ConsistentOptions::default(),
        paper: PaperOptions {
            triangle: if paper { Triangle::Diagonal } else { Triangle::Principal },
            ..FeasibleOptions::for_robot(&bench.robot).paper
        },
    };
    let found = fit_feasible(&bench.robot, &objective, &options, &|| false);
    let paper = found.paper.expect("asked for");
    Fitted {
        physical: AugmentedModel {
            values: base.model.base.project(&paper.fit.values),
            ..base.model.clone()
        },
        stretch,
        base,
        objective,
        paper,
    }
}

/// What every constraint costs: fits without one of them, and the convex problem, on the same rows.
fn costs(bench: &Bench, found: &Fitted, triangle: Triangle) {
    let printed = PaperOptions {
        triangle,
        starts: 16,
        ..FeasibleOptions::for_robot(&bench.robot).paper
    };
    let without = |change: &dyn Fn(&mut PaperOptions)| {
        let mut options = printed.clone();
        change(&mut options);
        options
    };
    let problems: [(&str, PaperOptions); 9] = [
        ("(10a–d) as printed", printed.clone()),
        (
            "principal moments' triangle inequality in the place of the diagonal's",
            without(&|o| o.triangle = Triangle::Principal),
        ),
        ("without the triangle inequality", without(&|o| o.triangle = Triangle::None)),
        ("without slender axes", without(&|o| o.slender_ratio = None)),
        ("without the ratio of 100", without(&|o| o.moment_ratio = None)),
        (
            "without the bound on products of inertia",
            without(&|o| o.product_ratio = None),
        ),
        ("without the least moment of 1e-4 kg m²", without(&|o| o.least_moment = 0.0)),
        (
            "without the least viscous friction of 0.1",
            without(&|o| o.least_viscous = 0.0),
        ),
        (
            "(10a–c) alone",
            without(&|o| {
                o.gazebo = false;
                o.triangle = Triangle::None;
                o.least_viscous = 0.0;
            }),
        ),
    ];
    println!("| problem | fit over the unconstrained | lower bound | starts within 0.01 % of the best |\n|---|--:|--:|--:|");
    let loose = ConsistentOptions {
        prior_weight: 0.0,
        ..ConsistentOptions::default()
    };
    for (name, options) in [
        ("convex form (ii), with its pull towards rods", ConsistentOptions::default()),
        ("convex form (ii), without", loose),
    ] {
        let fit = fit_consistent(&bench.robot, &found.objective, &options);
        println!("| {name} | {:.4} | {:.4} | |", fit.fit.ratio, fit.fit.ratio);
    }
    let consistent = fit_consistent(&bench.robot, &found.objective, &ConsistentOptions::default());
    for (name, options) in problems {
        let fit = fit_paper(&bench.robot, &found.objective, &consistent, &options, &|| false);
        let near = fit
            .starts
            .iter()
            .filter(|s| s.feasible && s.cost < fit.fit.fit.cost * 1.0002)
            .count();
        println!(
            "| {name} | {:.4} | {:.4} | {near} of {} |",
            fit.fit.fit.ratio,
            fit.fit.fit.ratio / (1.0 + fit.gap),
            fit.starts.len()
        );
        for s in &fit.starts {
            eprintln!(
                "    {} {:.5} feasible {} evaluations {} {:?}",
                s.from,
                (s.cost / found.objective.unconstrained()).sqrt(),
                s.feasible,
                s.evaluations,
                s.ending
            );
        }
    }
}

/// Five sines per joint; multiples of the fundamental, so that the robot can run it again and again.
fn sines(bench: &Bench) -> SineSeries {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let terms = bench.robot.joints().iter().map(|joint| {
        let raw: Vec<(f64, f64)> = (0..5)
            .map(|_| {
                (
                    rng.random_range(-1.0..1.0),
                    TAU / PERIOD_S * f64::from(rng.random_range(1..=6)),
                )
            })
            .collect();
        let [_, high] = joint.limits.position.expect("the shipped robot has limits");
        let speed = joint.limits.velocity.expect("the shipped robot has limits");
        // Triangle inequalities on position and velocity, as in (14d, e).
        let (travel, rate) = raw.iter().fold((0.0, 0.0), |(q, qd), (a, w)| (q + a.abs(), qd + a.abs() * w));
        let factor = f64::min(high / travel, speed / rate);
        raw.iter().map(|&(a, w)| (a * factor, w)).collect()
    });
    SineSeries {
        terms: terms.collect(),
        duration: PERIOD_S,
    }
}

/// `count` intervals of random lengths through random way-points, within the limits, back to the first.
fn way_points(bench: &Bench, count: usize, seed: u64) -> QuinticWayPoints {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let raw: Vec<f64> = (0..count).map(|_| rng.random_range(0.5..1.5)).collect();
    let total: f64 = raw.iter().sum();
    let durations: Vec<f64> = raw.iter().map(|d| d * PERIOD_S / total).collect();
    let mut points = vec![vec![0.0; 7]; count + 1];
    for (j, joint) in bench.robot.joints().iter().enumerate() {
        let [low, high] = joint.limits.position.expect("the shipped robot has limits");
        let speed = joint.limits.velocity.expect("the shipped robot has limits");
        // The polynomial's top speed is 15/8 of the mean one; the last interval has to lead home from wherever the others end.
        let reach = |k: usize| speed * durations[k] * 8.0 / 15.0;
        for k in 1..count {
            let home: f64 = (k..count).map(reach).sum();
            let wanted = rng.random_range(0.8 * low..0.8 * high);
            let from = points[k - 1][j];
            points[k][j] = wanted.clamp(from - reach(k - 1), from + reach(k - 1)).clamp(-home, home);
        }
    }
    QuinticWayPoints::new(points, &durations)
}

fn reference() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/ref_base.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect("checked in")).expect("JSON")
}

fn table_2(bench: &Bench, paper: &Fitted, default: &Fitted) {
    let reference = reference();
    // The same columns in the same order; of the names one differs, because ZZ7 stands for itself.
    let number = |key: &str, c: usize| reference[key][c].as_f64().expect("a number");
    println!("| Par. | truth | paper's chain | σ (15) % | σ % | default | σ % | paper (real arm) | σ (15) % |");
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (c, name) in bench.base.names.iter().enumerate() {
        let (p, d) = (&paper.base.estimate, &default.base.estimate);
        println!(
            "| {name} | {:.3} | {:.3} | {:.2} | {:.2} | {:.3} | {:.2} | {:.3} | {:.2} |",
            number("table3_base", c),
            p.values[c],
            100.0 * p.textbook_std_dev[c] / p.values[c].abs(),
            p.relative_std_dev_percent(c),
            d.values[c],
            d.relative_std_dev_percent(c),
            number("table2_value", c),
            number("table2_sigma_pct", c),
        );
    }
    for (what, found) in [("paper's chain", paper), ("default", default)] {
        let score = |c: usize| (found.base.estimate.values[c] - number("table3_base", c)) / found.base.estimate.std_dev(c);
        let scores: Vec<f64> = (0..bench.base.len()).map(score).collect();
        let variance = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
        let within = scores.iter().filter(|z| z.abs() < 3.0).count();
        println!("\n{what}: {within} of 57 within three standard deviations, variance of the standardised errors {variance:.2}");
    }
}

fn table_3(bench: &Bench, found: &PaperFit) {
    println!(
        "| Par. | {} |",
        (1..=7).map(|k| format!("Link {k}")).collect::<Vec<_>>().join(" | ")
    );
    println!("|---|{}", "--:|".repeat(7));
    let truth: Vec<_> = bench.truth.joints().iter().map(|j| j.prior.expect("the truth")).collect();
    let row = |name: &str, of: &dyn Fn(usize) -> (f64, f64)| {
        let cell = |k| {
            let (found, table) = of(k);
            format!("{found:.5} ({table:.5})")
        };
        println!("| {name} | {} |", (0..7).map(cell).collect::<Vec<_>>().join(" | "));
    };
    let links = &found.links;
    row("m", &|k| (links[k].inertia.mass, truth[k].inertia.mass));
    for (axis, name) in ["l_x", "l_y", "l_z"].iter().enumerate() {
        row(name, &|k| {
            (links[k].inertia.center_of_mass[axis], truth[k].inertia.center_of_mass[axis])
        });
    }
    for (name, at) in [
        ("I_xx", (0, 0)),
        ("I_xy", (0, 1)),
        ("I_xz", (0, 2)),
        ("I_yy", (1, 1)),
        ("I_yz", (1, 2)),
        ("I_zz", (2, 2)),
    ] {
        row(name, &|k| (links[k].inertia.inertia[at], truth[k].inertia.inertia[at]));
    }
    row("F_v", &|k| (links[k].viscous, truth[k].viscous));
    row("F_s", &|k| (links[k].coulomb, truth[k].coulomb));
}

/// Root mean square of what the model leaves of the torque averaged over the periods, per joint [N m].
fn mean_errors(model: &AugmentedModel, stretch: &Stretch) -> Vec<f64> {
    let rms = |(j, predicted): (usize, Vec<f64>)| {
        let rows = predicted.iter().zip(&stretch.torque[j]).zip(&stretch.usable[j]);
        let squares: Vec<f64> = rows.filter(|(_, used)| **used).map(|((p, t), _)| (t - p).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    model.predict(stretch).into_iter().enumerate().map(rms).collect()
}

fn table_4(found: &Fitted, logs: &[Log], paper: bool) {
    println!("| joint | π_b, q1 | μ, q1 | μ, q2 | μ, q3 | μ, q4 |\n|---|--:|--:|--:|--:|--:|");
    let mut columns = vec![mean_errors(&found.base.model, &found.stretch)];
    columns.push(mean_errors(&found.physical, &found.stretch));
    for log in logs {
        columns.push(mean_errors(&found.physical, &Stretch::new(&prepared(log, paper), log)));
    }
    let published = |column: usize| {
        if column == 0 {
            TABLE_4_BASE
        } else {
            TABLE_4_PHYSICAL[column - 1]
        }
    };
    let line = |name: &str, of: &dyn Fn(&[f64]) -> f64| {
        let cell = |(c, rms): (usize, &Vec<f64>)| format!("{:.2} ({:.2})", of(rms), of(&published(c)));
        println!(
            "| {name} | {} |",
            columns.iter().enumerate().map(cell).collect::<Vec<_>>().join(" | ")
        );
    };
    for j in 0..7 {
        line(&format!("{}", j + 1), &|rms| rms[j]);
    }
    line("sum", &|rms| rms.iter().sum());
}

fn main() {
    let evaluations = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(75_000);
    let bench = Bench::new();
    let problem = Problem::new(ProblemSpec {
        robot: bench.robot.clone(),
        order: 5,
        fundamental_hz: 1.0 / PERIOD_S,
        sample_rate_hz: 100.0,
        criterion: Criterion::ConditionNumber,
        form: Form::Paper,
        start: Start::Zero,
        start_position: None,
        torque_noise: None,
        torque: None,
        space: None,
        harmonics: None,
        knowledge: Knowledge::default(),
    })
    .expect("the paper's problem");
    let options = SearchOptions {
        max_evaluations: Some(evaluations),
        ..SearchOptions::default()
    };
    let design = search(&problem, &options, &Alone);
    let condition = design.criteria.as_ref().expect("a trajectory").condition_number;
    println!(
        "Excitation: condition number {condition:.1} after {} evaluations (the paper: 65).\n",
        design.evaluations
    );
    let log = bench.run("q1", &design.series, 1);
    let others = [
        bench.run("q2", &sines(&bench), 2),
        bench.run("q3", &way_points(&bench, 10, 3), 3),
        bench.run("q4", &way_points(&bench, 20, 4), 4),
    ];
    let timer = Instant::now();
    let (paper, default) = (fit(&bench, &log, true), fit(&bench, &log, false));
    eprintln!("both fits, many starts each: {:.1?}", timer.elapsed());
    println!("## Table 2\n");
    table_2(&bench, &paper, &default);
    println!("\n## Table 3\n");
    table_3(&bench, &paper.paper);
    for (what, found) in [
        ("paper's chain, (10a–d) as printed", &paper),
        ("default chain, principal moments", &default),
    ] {
        let (fit, gap) = (&found.paper.fit, 100.0 * found.paper.gap);
        println!(
            "\n{what}: {:?}, fit {:.4} times the unconstrained one, at most {gap:.2} % above the global minimum.",
            fit.ending, fit.fit.ratio
        );
    }
    println!("\n## What the constraints cost\n");
    costs(&bench, &paper, Triangle::Diagonal);
    println!("\n## Table 4, the paper's chain\n");
    table_4(&paper, &others, true);
    println!("\n## Table 4, the default chain\n");
    table_4(&default, &others, false);
}
