//! Designs held against their limits at 100,000 samples per second, by arithmetic that shares nothing with the proof of the
//! margins.
//!
//! `cargo run --release --example dense_sampling -- [random designs] [optimised designs]`, 10000 and 100 if left out. Every
//! sample of every joint of every design is a sum of the harmonics at that moment: a table of sines and cosines, multiplied with
//! the coefficients.

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use dynident::excitation::*;
use dynident::model::Robot;
use dynident::parameters::Layout;
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::time::Instant;

const RATE_HZ: f64 = 100_000.0;
/// Samples multiplied at once; the products stay in the cache.
const TILE: usize = 400;
const COLUMNS: usize = 128;

struct Forever;

impl Control for Forever {
    fn halt(&self) -> Option<Halt> {
        None
    }

    fn progress(&self, _: &Progress) {}
}

/// The iiwa 14, its accelerations and jerks limited too where asked for.
fn robot(more_limits: bool) -> Robot {
    let robot = Shipped.named("iiwa14").expect("shipped with the program").robot;
    let limited = robot.joints().iter().map(|joint| {
        let mut limits = joint.limits;
        if more_limits {
            (limits.acceleration, limits.jerk) = (Some(4.0), Some(12.0));
        }
        joint.clone().with_limits(limits)
    });
    Robot::new(robot.name(), robot.gravity(), limited.collect(), robot.friction()).expect("as sound as before")
}

fn problem(form: Form, start: Start, more_limits: bool, torque: Option<TorqueLimits>) -> Problem {
    Problem::new(ProblemSpec {
        robot: robot(more_limits),
        order: 5,
        harmonics: None,
        fundamental_hz: 0.1,
        sample_rate_hz: 20.0,
        criterion: Criterion::ConditionNumber,
        form,
        start,
        start_position: None,
        torque_noise: None,
        torque,
        space: None,
        knowledge: Knowledge::default(),
    })
    .expect("a sound problem")
}

/// One joint's motion in one derivative, and its limits.
struct Curve {
    coefficients: [f64; 11],
    range: [f64; 2],
}

/// Every limited quantity of a design: coefficients of `cos`, `sin` and 1.
fn curves(robot: &Robot, series: &FourierSeries) -> Vec<Curve> {
    let omega = TAU * series.fundamental_hz;
    let mut all = Vec::new();
    for (j, joint) in robot.joints().iter().enumerate() {
        let l = joint.limits;
        let both = |v: Option<f64>| v.map(|v| [-v, v]);
        // q = Σ a/w sin − b/w cos; qd = Σ a cos + b sin; and so on.
        let signs: [(Option<[f64; 2]>, i32, [f64; 2]); 4] = [
            (l.position, -1, [-1.0, 1.0]),
            (both(l.velocity), 0, [1.0, 1.0]),
            (both(l.acceleration), 1, [1.0, -1.0]),
            (both(l.jerk), 2, [-1.0, -1.0]),
        ];
        for (quantity, (range, power, [of_cos, of_sin])) in signs.into_iter().enumerate() {
            let Some(range) = range else { continue };
            let mut coefficients = [0.0; 11];
            for h in 0..5 {
                let (a, b) = (series.a[(j, h)], series.b[(j, h)]);
                let weight = (omega * (h + 1) as f64).powi(power);
                // Odd derivatives of q have a with the cosine, even ones with the sine.
                let (with_cos, with_sin) = if quantity % 2 == 1 { (a, b) } else { (b, a) };
                coefficients[h] = of_cos * weight * with_cos;
                coefficients[5 + h] = of_sin * weight * with_sin;
            }
            coefficients[10] = if quantity == 0 { series.offset[j] } else { 0.0 };
            all.push(Curve { coefficients, range });
        }
    }
    all
}

/// Takes values into a range, eight at a time.
fn widen([low, high]: &mut [f64; 2], values: &[f64]) {
    let (mut least, mut most) = ([*low; 8], [*high; 8]);
    let chunks = values.chunks_exact(8);
    let rest = chunks.remainder();
    for chunk in chunks {
        for i in 0..8 {
            least[i] = if chunk[i] < least[i] { chunk[i] } else { least[i] };
            most[i] = if chunk[i] > most[i] { chunk[i] } else { most[i] };
        }
    }
    *low = least.iter().chain(rest).fold(*low, |m, &v| m.min(v));
    *high = most.iter().chain(rest).fold(*high, |m, &v| m.max(v));
}

/// Largest part of the way from the middle of its range to a limit, over all samples of all curves, and how many curves exceed
/// one.
fn sampled(curves: &[Curve], period_s: f64) -> (f64, usize) {
    let samples = (period_s * RATE_HZ).round() as usize;
    let tiles = samples.div_ceil(TILE);
    let nothing = || vec![[f64::INFINITY, f64::NEG_INFINITY]; curves.len()];
    let extremes = (0..tiles)
        .into_par_iter()
        .fold(nothing, |mut seen, tile| {
            let first = tile * TILE;
            let rows = TILE.min(samples - first);
            let table = DMatrix::from_fn(11, rows, |c, r| {
                let phase = |l: usize| TAU * l as f64 * (first + r) as f64 / samples as f64;
                match c {
                    0..5 => phase(c + 1).cos(),
                    5..10 => phase(c - 4).sin(),
                    _ => 1.0,
                }
            })
            .transpose();
            let mut product = DMatrix::zeros(rows, COLUMNS);
            for (block, seen) in curves.chunks(COLUMNS).zip(seen.chunks_mut(COLUMNS)) {
                let coefficients = DMatrix::from_fn(11, block.len(), |r, c| block[c].coefficients[r]);
                product.columns_mut(0, block.len()).gemm(1.0, &table, &coefficients, 0.0);
                for (column, range) in product.as_slice().chunks_exact(rows).zip(seen) {
                    widen(range, column);
                }
            }
            seen
        })
        .reduce(nothing, |a, b| {
            let join = |(x, y): (&[f64; 2], &[f64; 2])| [x[0].min(y[0]), x[1].max(y[1])];
            a.iter().zip(&b).map(join).collect()
        });
    let used = |(curve, [low, high]): (&Curve, &[f64; 2])| {
        let (middle, half) = (
            0.5 * (curve.range[0] + curve.range[1]),
            0.5 * (curve.range[1] - curve.range[0]),
        );
        ((high - middle) / half).max((middle - low) / half)
    };
    let all: Vec<f64> = curves.iter().zip(&extremes).map(used).collect();
    (
        all.iter().copied().fold(0.0, f64::max),
        all.iter().filter(|u| **u > 1.0).count(),
    )
}

/// The same of torques: largest |τ| over what is allowed, by inverse dynamics at every sample.
fn sampled_torque(robot: &Robot, series: &FourierSeries, allowed: &[f64]) -> f64 {
    let (chain, layout) = (Chain::new(robot), Layout::standard(robot));
    let parameters = layout.prior(robot).expect("the iiwa has prior parameters");
    let samples = (series.duration() * RATE_HZ).round() as usize;
    let pieces = samples.div_ceil(10_000);
    let used = |piece: usize| {
        let first = piece * 10_000;
        let motion = Motion::from_fn(robot.joint_count(), 10_000.min(samples - first), |j, s| {
            series.state(j, (first + s) as f64 / RATE_HZ)
        });
        let torque = inverse_dynamics_batch(&chain, &layout, parameters.as_slice(), &motion, Coulomb::Sign);
        let of = |j: usize| {
            let row = &torque[j * motion.stride()..j * motion.stride() + motion.samples()];
            row.iter().fold(0.0f64, |most, t| most.max(t.abs())) / allowed[j]
        };
        (0..robot.joint_count()).map(of).fold(0.0, f64::max)
    };
    (0..pieces).into_par_iter().map(used).reduce(|| 0.0, f64::max)
}

fn optimised(problem: &Problem, seed: u64) -> FourierSeries {
    let options = SearchOptions {
        seed,
        starts: 2,
        max_evaluations: Some(300),
        jobs_per_round: 2,
        until_halted: false,
    };
    search(problem, &options, &Forever).series
}

fn main() {
    let argument = |at: usize, default: usize| std::env::args().nth(at).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (random, best) = (argument(1, 10_000), argument(2, 100));
    let kinds = [
        ("paper, zero", Form::Paper, Start::Zero, false),
        ("exact, zero", Form::Exact, Start::Zero, false),
        ("exact, free", Form::Exact, Start::Free, false),
        ("exact, free, acceleration and jerk", Form::Exact, Start::Free, true),
    ];
    println!("kind                                designs   largest part of a limit used   limits exceeded   s");
    let mut exceeded = 0;
    for (name, form, start, more_limits) in kinds {
        let begun = Instant::now();
        let problem = problem(form, start, more_limits, None);
        let mut designs: Vec<FourierSeries> = (0..random / kinds.len())
            .into_par_iter()
            .filter_map(|i| random_design(&problem, 1, i))
            .collect();
        designs.extend((0..best / kinds.len()).map(|i| optimised(&problem, i as u64)));
        let all: Vec<Curve> = designs.iter().flat_map(|s| curves(problem.robot(), s)).collect();
        let (used, over) = sampled(&all, 10.0);
        exceeded += over;
        println!(
            "{name:35} {:7}   {used:28.9}   {over:15}   {:.0}",
            designs.len(),
            begun.elapsed().as_secs_f64()
        );
    }
    let begun = Instant::now();
    let limits = TorqueLimits {
        limits: Some(vec![60.0, 90.0, 40.0, 45.0, 12.0, 10.0, 3.0]),
        safety_factor: 1.0,
    };
    let problem = problem(Form::Exact, Start::Zero, false, Some(limits.clone()));
    let allowed = limits.limits.expect("given above");
    let count = best.div_ceil(10);
    let used = (0..count).map(|i| {
        let series = optimised(&problem, i as u64);
        sampled_torque(problem.robot(), &series, &allowed)
    });
    let used: Vec<f64> = used.collect();
    let over = used.iter().filter(|u| **u > 1.0).count();
    exceeded += over;
    println!(
        "{:35} {count:7}   {:28.9}   {over:15}   {:.0}",
        "exact, zero, torques that bind",
        used.iter().copied().fold(0.0, f64::max),
        begun.elapsed().as_secs_f64()
    );
    assert_eq!(exceeded, 0, "a limit is exceeded between the samples of the proof");
}
