//! Designs meet every constraint, whoever evaluates them, and do not depend on threads.

use crate::support::{iiwa14_limited, structured_arm};
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::inverse_dynamics;
use dynident::excitation::*;
use dynident::model::{Capsule, Joint, Limits, Robot};
use dynident::parameters::Layout;
use dynident::trajectory::Trajectory;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Mutex;
use std::time::{Duration, Instant};

struct Until(Instant);

impl Control for Until {
    fn halt(&self) -> Option<Halt> {
        (Instant::now() > self.0).then_some(Halt::TimeUp)
    }

    fn progress(&self, _: &Progress) {}
}

fn never() -> Until {
    Until(Instant::now() + Duration::from_secs(3600))
}

fn problem(robot: Robot, form: Form, start: Start) -> Problem {
    Problem::new(ProblemSpec {
        robot,
        order: 5,
        fundamental_hz: 0.1,
        sample_rate_hz: 20.0,
        criterion: Criterion::ConditionNumber,
        form,
        start,
        start_position: None,
        torque_noise: None,
        torque: None,
        space: None,
        harmonics: None,
        knowledge: Knowledge::default(),
    })
    .unwrap()
}

fn options(seed: u64, evaluations: u64) -> SearchOptions {
    SearchOptions {
        seed,
        starts: 4,
        max_evaluations: Some(evaluations),
        jobs_per_round: 4,
        until_halted: false,
    }
}

#[test]
fn prop_same_seed_and_evaluations_give_the_same_design_on_any_number_of_threads() {
    let problem = problem(iiwa14_limited(), Form::Paper, Start::Zero);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| search(&problem, &options(7, 3000), &never()))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.series, three.series);
    assert_eq!(one.evaluations, three.evaluations);
    assert_eq!(one.starts, three.starts);
    let other = search(&problem, &options(8, 3000), &never());
    assert_ne!(one.series, other.series, "another seed is another search");
}

/// (14c) corrected, (14d)–(14g), evaluated here from the coefficients alone.
#[test]
fn prop_papers_constraints_hold_exactly_in_what_is_returned() {
    let robot = iiwa14_limited();
    for seed in 1..4 {
        let problem = problem(robot.clone(), Form::Paper, Start::Zero);
        let series = search(&problem, &options(seed, 600), &never()).series;
        let w = TAU * 0.1;
        for (j, joint) in robot.joints().iter().enumerate() {
            let (q_max, qd_max) = (joint.limits.position.unwrap()[1], joint.limits.velocity.unwrap());
            let row = |m: &nalgebra::DMatrix<f64>| m.row(j).iter().copied().collect::<Vec<_>>();
            let (a, b) = (row(&series.a), row(&series.b));
            // Exact zeros, forwards and backwards: the coefficients are on a common binary grid.
            assert_eq!(a.iter().sum::<f64>(), 0.0);
            assert_eq!(a.iter().rev().sum::<f64>(), 0.0);
            assert_eq!((1..=5).map(|l| l as f64 * b[l - 1]).sum::<f64>(), 0.0);
            assert_eq!((1..=5).map(|l| b[l - 1] / l as f64).sum::<f64>(), 0.0);
            assert_eq!(
                series.state(j, 0.0)[1],
                0.0,
                "sign(qd) at the start is 0 by anybody's arithmetic"
            );
            let amplitude = |l: usize| a[l - 1].hypot(b[l - 1]);
            assert!((1..=5).map(|l| amplitude(l) / l as f64).sum::<f64>() <= w * q_max);
            assert!((1..=5).map(amplitude).sum::<f64>() <= qd_max);
            for l in 1..=5 {
                let bound = (l as f64 * w * q_max / 5.0).min(qd_max);
                assert!(a[l - 1].abs() <= bound && b[l - 1].abs() <= bound);
            }
        }
    }
}

#[test]
fn prop_exact_limits_hold_between_the_samples_on_random_arms() {
    for seed in 0..6 {
        let joints = 2 + seed as usize % 4;
        let arm = structured_arm(500 + seed, joints);
        let limits = Limits {
            position: Some([-0.7, 1.9]),
            velocity: Some(1.1),
            acceleration: Some(2.5),
            ..Limits::unlimited()
        };
        let limited = arm.joints().iter().map(|j| j.clone().with_limits(limits)).collect();
        let robot = Robot::new("limited", arm.gravity(), limited, arm.friction()).unwrap();
        let start = if seed % 2 == 0 { Start::Zero } else { Start::Free };
        let design = search(&problem(robot, Form::Exact, start), &options(seed, 400), &never());
        for j in 0..joints {
            for k in 0..100_000 {
                let [q, qd, qdd] = design.series.state(j, k as f64 * 1e-4);
                assert!(
                    (-0.7..=1.9).contains(&q) && qd.abs() <= 1.1 && qdd.abs() <= 2.5,
                    "seed {seed} joint {j} at {k}: {q} {qd} {qdd}"
                );
            }
            let [_, qd, qdd] = design.series.state(j, 0.0);
            assert!(qd == 0.0 && qdd.abs() < 1e-12, "starts at rest");
        }
        for m in &design.margins {
            // The proven extreme lies on the far side of the sampled one.
            let outwards = if m.quantity == Quantity::Position {
                m.limit - 0.6
            } else {
                m.limit
            };
            assert!(m.margin >= 0.0 && (m.certified_peak - m.peak) * outwards >= 0.0, "{m:?}");
        }
    }
}

#[test]
fn prop_a_time_limit_is_honoured_within_a_second() {
    let problem = problem(iiwa14_limited(), Form::Paper, Start::Zero);
    let begun = Instant::now();
    let until = Until(begun + Duration::from_millis(500));
    let design = search(
        &problem,
        &SearchOptions {
            until_halted: true,
            ..SearchOptions::default()
        },
        &until,
    );
    assert!(begun.elapsed() < Duration::from_millis(1500), "{:?}", begun.elapsed());
    assert!(design.criteria.unwrap().condition_number.is_finite());
}

#[test]
fn prop_a_joint_that_starts_on_its_limit_is_an_infeasible_outcome() {
    let spec = ProblemSpec {
        start_position: Some(vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 175f64.to_radians()]),
        ..problem(iiwa14_limited(), Form::Paper, Start::Zero).spec().clone()
    };
    let design = search(&Problem::new(spec).unwrap(), &options(1, 100), &never());
    assert!(
        matches!(&design.status, Outcome::Infeasible(reason) if reason.contains("A7")),
        "{:?}",
        design.status
    );
    assert!(design.criteria.is_none());
}

/// The planar arm with so much torque for its first joint, in the space that is handed in.
fn planar(start: Start, torque: Option<f64>, space: Option<SpaceLimits>) -> ProblemSpec {
    let bare = Shipped.named("planar_two_link").unwrap().robot;
    let capsule = Capsule {
        ends: [Vector3::zeros(), Vector3::x()],
        radius: 0.05,
    };
    let shaped = |joint: &Joint| Joint {
        geometry: vec![capsule],
        ..joint.clone()
    };
    let joints = bare.joints().iter().map(shaped).collect();
    let robot = Robot::new(bare.name(), bare.gravity(), joints, bare.friction()).unwrap();
    ProblemSpec {
        torque: torque.map(|first| TorqueLimits {
            limits: Some(vec![first, 1e4]),
            safety_factor: 1.0,
        }),
        space,
        ..problem(robot, Form::Exact, start).spec().clone()
    }
}

/// Nothing higher or lower than half a metre.
fn slab() -> SpaceLimits {
    let half_space = |name: &str, normal: Vector3<f64>| HalfSpace {
        name: name.into(),
        normal,
        offset: -0.5,
    };
    SpaceLimits {
        clearance: 0.02,
        half_spaces: vec![half_space("floor", Vector3::y()), half_space("ceiling", -Vector3::y())],
        boxes: Vec::new(),
        self_collision: None,
    }
}

fn reason(spec: ProblemSpec) -> String {
    let design = search(&Problem::new(spec).unwrap(), &options(1, 100), &never());
    match design.status {
        Outcome::Infeasible(reason) => reason,
        other => panic!("{other:?}"),
    }
}

/// The percentage that stands after the last `words`.
fn percentage(reason: &str, words: &str) -> f64 {
    let (_, rest) = reason
        .rsplit_once(words)
        .unwrap_or_else(|| panic!("no `{words}` in: {reason}"));
    let number = rest.split(" %").next().and_then(|n| n.parse().ok());
    number.unwrap_or_else(|| panic!("no percentage after `{words}` in: {reason}"))
}

/// Whether there is any motion, and not only a posture.
fn moves(spec: ProblemSpec) -> bool {
    random_design(&Problem::new(spec).unwrap(), 1, 0).is_some_and(|series| series.a.amax() > 0.0)
}

/// Torque of the first joint at rest: a kilogram at half a metre, and one at half a metre beyond the first metre.
fn load(q: [f64; 2]) -> f64 {
    9.81 * (1.5 * q[0].cos() + 0.5 * (q[0] + q[1]).cos())
}

/// The arm lies level where the motion starts.
#[test]
fn prop_a_torque_limit_below_the_load_is_an_infeasible_outcome_with_both_numbers() {
    let said = reason(planar(Start::Zero, Some(8.0), None));
    let needs = format!("`J1` needs {:.4}", load([0.0, 0.0]));
    for words in [needs.as_str(), "constraints.torque allows 8.0000", "start_position"] {
        assert!(said.contains(words), "{words} not in: {said}");
    }
    // The share of postures that the limit allows, counted on a grid over nine tenths of the range.
    let (cells, half) = (500, 0.9 * 150f64.to_radians());
    let at = |i: usize| half * ((2 * i + 1) as f64 / cells as f64 - 1.0);
    let allowed = |i: usize| (0..cells).filter(|&k| load([at(i), at(k)]).abs() < 8.0).count();
    let share = (0..cells).map(allowed).sum::<usize>() as f64 / (cells * cells) as f64;
    let reported = 0.01 * percentage(&said, "constraints.torque allows ");
    // Counted from 2000 random ones: five standard deviations, and the rounding of what is reported.
    let scatter = 5.0 * (share * (1.0 - share) / 2000.0).sqrt() + 0.0005;
    assert!((reported - share).abs() < scatter, "{reported} of {share}");
    // Somewhere else it can be held: with a free start the motion is there.
    assert!(moves(planar(Start::Free, Some(8.0), None)));
}

/// In the slab the first link is within 26° of level, and needs 9.81 · (1.5 cos 26° − 0.5) = 8.3 N m at least.
#[test]
fn prop_limits_that_fight_are_named_with_what_each_allows_alone() {
    let said = reason(planar(Start::Free, Some(8.0), Some(slab())));
    assert!(said.contains("`J1` needs"), "{said}");
    let alone = ["constraints.torque allows ", "constraints.space allows "].map(|words| percentage(&said, words));
    assert!(alone.iter().all(|percent| *percent > 0.0), "{said}");
    assert_eq!(percentage(&said, "both together "), 0.0, "{said}");
    // Each of the two alone leaves room, and so do both with more torque.
    assert!(moves(planar(Start::Free, Some(8.0), None)));
    assert!(moves(planar(Start::Free, None, Some(slab()))));
    assert!(!moves(planar(Start::Free, Some(8.0), Some(slab()))));
    assert!(moves(planar(Start::Free, Some(19.0), Some(slab()))));
}

/// A hundredth is where drawing in gives up, not the least that may be asked for.
#[test]
fn regress_a_first_run_of_less_than_a_hundredth_is_made() {
    let problem = problem(iiwa14_limited(), Form::Exact, Start::Zero);
    let series = random_design(&problem, 1, 0).unwrap();
    let asked = Backoff {
        amplitude: 0.004,
        slowness: 1.0,
    };
    let run = first_run(&problem, &series, asked).expect("a part of a motion within the limits is within them");
    assert_eq!(run.amplitude, asked.amplitude);
    assert_eq!(run.series.a, &series.a * asked.amplitude);
}

#[test]
fn prop_a_start_outside_the_position_limits_is_refused_with_the_joint_and_its_limits() {
    let spec = ProblemSpec {
        start_position: Some(vec![0.0, 3.0]),
        ..planar(Start::Zero, None, None)
    };
    let found = Problem::new(spec).unwrap_err().0;
    let [only] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!(only.pointer, "/constraints/start_position/1");
    for words in ["is 3,", "[-2.617", "`J2`"] {
        assert!(only.detail.contains(words), "{words} not in: {}", only.detail);
    }
}

/// Twenty thousand moments of one period by the recursive algorithm, which the search does not use.
#[test]
fn prop_torque_limits_bind_and_are_never_exceeded() {
    let robot = Shipped.named("planar_two_link").unwrap().robot;
    // Hanging down, so that no torque is needed at rest.
    let hanging = ProblemSpec {
        start_position: Some(vec![-TAU / 4.0, 0.0]),
        ..problem(robot.clone(), Form::Paper, Start::Zero).spec().clone()
    };
    let free = Problem::new(hanging).unwrap();
    let unlimited = search(&free, &options(3, 20_000), &never());
    let spec = ProblemSpec {
        // The first joint holds two links against gravity: 62 % of what it takes without limits, 1.5 times over.
        torque: Some(TorqueLimits {
            limits: Some(vec![1.5 * 0.62 * torque_peak(&robot, &unlimited), 1e4]),
            safety_factor: 1.5,
        }),
        ..free.spec().clone()
    };
    let limited = search(&Problem::new(spec).unwrap(), &options(3, 20_000), &never());
    let allowed = 0.62 * torque_peak(&robot, &unlimited);
    let reached = torque_peak(&robot, &limited);
    // Bisection stops within 0.1 % of the amplitude, and half a step between samples is left free.
    assert!(reached <= allowed && reached > 0.98 * allowed, "{reached} of {allowed}");
    let margin = limited
        .margins
        .iter()
        .filter(|m| m.quantity == Quantity::Torque)
        .map(|m| m.margin);
    assert!(margin.clone().all(|m| m >= 0.0) && margin.fold(1.0, f64::min) < 0.02);
    assert!(limited.criteria.unwrap().condition_number > unlimited.criteria.unwrap().condition_number);
}

fn torque_peak(robot: &Robot, design: &Design) -> f64 {
    let layout = Layout::standard(robot);
    let phi = layout.prior(robot).expect("the arm has parameters");
    let torque = |k: usize| {
        let t = k as f64 * design.series.duration() / 20_000.0;
        let state = |j: usize| design.series.state(j, t);
        let [q, qd, qdd] = [0, 1, 2].map(|d| (0..2).map(|j| state(j)[d]).collect::<Vec<f64>>());
        inverse_dynamics(robot, &layout, phi.as_slice(), &q, &qd, &qdd)[0].abs()
    };
    (0..20_000).map(torque).fold(0.0, f64::max)
}

#[test]
fn prop_a_search_goes_on_from_an_earlier_design() {
    let problem = problem(iiwa14_limited(), Form::Paper, Start::Zero);
    let earlier = search(&problem, &options(1, 4000), &never());
    let on = search_from(&problem, &options(2, 100), Some(&earlier.series), &never());
    let (before, after) = (
        earlier.criteria.unwrap().condition_number,
        on.criteria.unwrap().condition_number,
    );
    // The grid of the coefficients moves the value by less than a millionth.
    assert!(after <= before * (1.0 + 1e-6), "{before} {after}");
    let wider = ProblemSpec {
        order: 6,
        form: Form::Exact,
        ..problem.spec().clone()
    };
    let on = search_from(
        &Problem::new(wider).unwrap(),
        &options(2, 400),
        Some(&earlier.series),
        &never(),
    );
    assert!(on.margins.iter().all(|m| m.margin >= 0.0));
    assert!(on.criteria.unwrap().condition_number < before);
}

/// A search that hears of `others` once, and keeps what it tells.
struct Beside {
    others: Mutex<Vec<Point>>,
    reported: Mutex<Vec<(usize, f64, Vec<Point>)>>,
}

impl Beside {
    fn hearing(others: Vec<Point>) -> Self {
        Self {
            others: Mutex::new(others),
            reported: Mutex::default(),
        }
    }

    fn reported(self) -> Vec<(usize, f64, Vec<Point>)> {
        self.reported.into_inner().unwrap()
    }
}

impl Control for Beside {
    fn halt(&self) -> Option<Halt> {
        None
    }

    fn progress(&self, _: &Progress) {}

    fn found(&self, found: &Found) {
        self.reported
            .lock()
            .unwrap()
            .push((found.epochs, found.best(), found.points()));
    }

    fn others(&self) -> Vec<Point> {
        std::mem::take(&mut self.others.lock().unwrap())
    }
}

#[test]
fn prop_a_search_goes_on_from_what_another_has_found() {
    let problem = problem(iiwa14_limited(), Form::Paper, Start::Zero);
    let alone = search(&problem, &options(1, 4000), &never());
    let first = Beside::hearing(vec![]);
    // Being observed changes nothing.
    assert_eq!(search(&problem, &options(1, 4000), &first), alone);
    let reported = first.reported();
    assert!(reported.windows(2).all(|w| w[1].1 <= w[0].1 && w[1].0 >= w[0].0));
    let (_, best, mut points) = reported.last().unwrap().clone();
    assert!(points.windows(2).all(|w| w[0].value <= w[1].value) && points[0].value == best);
    // What another version of the program might write is left aside.
    let (mut short, mut wild) = (points[0].clone(), points[0].clone());
    short.x.pop();
    wild.x[0] = f64::NAN;
    points.extend([short, wild]);
    let second = Beside::hearing(points);
    let on = search(&problem, &options(2, 100), &second);
    let value = |d: &Design| d.criteria.unwrap().condition_number;
    // The grid of the coefficients moves the value by less than a millionth.
    assert!(
        value(&on) <= value(&alone) * (1.0 + 1e-6),
        "{} then {}",
        value(&alone),
        value(&on)
    );
    assert!(second.reported()[0].1 <= best + 1e-6, "it knows from the first round on");
}

/// The paper's own result is 65; an eighth of a minute of one core is enough to be below it.
#[test]
fn val_the_papers_condition_number_is_reached() {
    let spec = ProblemSpec {
        sample_rate_hz: 100.0,
        ..problem(iiwa14_limited(), Form::Paper, Start::Zero).spec().clone()
    };
    let design = search(
        &Problem::new(spec).unwrap(),
        &SearchOptions {
            max_evaluations: Some(15_000),
            ..SearchOptions::default()
        },
        &never(),
    );
    assert!(design.criteria.unwrap().condition_number < 65.0, "{:?}", design.criteria);
}
