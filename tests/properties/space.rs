//! Trajectories avoid the floor, the table and the arm itself, as seen by kinematics and distances of the test's own.

use crate::support::FRICTION;
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::excitation::*;
use dynident::model::{Capsule, Joint, JointKind, Limits, Mdh, Robot};
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

struct Forever;

impl Control for Forever {
    fn halt(&self) -> Option<Halt> {
        None
    }

    fn progress(&self, _: &Progress) {}
}

const FLOOR: f64 = -0.36;
const TABLE: [[f64; 3]; 2] = [[0.55, 0.0, -0.05], [0.5, 1.2, 0.62]];
const CLEARANCE: f64 = 0.03;

fn cell() -> SpaceLimits {
    SpaceLimits {
        clearance: CLEARANCE,
        half_spaces: vec![HalfSpace {
            name: "floor".into(),
            normal: Vector3::z() * 2.0,
            offset: 2.0 * FLOOR,
        }],
        boxes: vec![Obstacle {
            name: "table".into(),
            center: TABLE[0].into(),
            size: TABLE[1].into(),
        }],
        self_collision: Some(SelfCollision::default()),
    }
}

fn spec(space: Option<SpaceLimits>) -> ProblemSpec {
    ProblemSpec {
        robot: Shipped.named("iiwa14").unwrap().robot,
        order: 5,
        fundamental_hz: 0.1,
        sample_rate_hz: 20.0,
        criterion: Criterion::ConditionNumber,
        form: Form::Paper,
        start: Start::Zero,
        start_position: None,
        torque_noise: None,
        torque: None,
        space,
        harmonics: None,
        knowledge: Knowledge::default(),
    }
}

fn find(spec: ProblemSpec) -> Design {
    let options = SearchOptions {
        seed: 1,
        max_evaluations: Some(4000),
        ..SearchOptions::default()
    };
    search(&Problem::new(spec).unwrap(), &options, &Forever)
}

#[test]
fn prop_a_cell_is_kept_off_where_the_free_optimum_collides() {
    let robot = Shipped.named("iiwa14").unwrap().robot;
    let (free, kept) = (find(spec(None)), find(spec(Some(cell()))));
    let before = nearest(&robot, &free.series);
    assert!(before < 0.0, "nothing to show: the free optimum keeps {before} m");
    let after = nearest(&robot, &kept.series);
    // Segments are looked at at 41 points each: between two of them a distance to a plane or a convex body is at most this much
    // less.
    let coarse = 1e-3;
    assert!(after >= CLEARANCE - coarse, "{after}");
    let least = kept.clearances.iter().map(|c| c.least).fold(f64::INFINITY, f64::min);
    assert!((least - after).abs() < coarse, "reported {least}, seen {after}");
    assert!(
        kept.clearances
            .iter()
            .all(|c| c.certified >= c.asked && c.certified <= c.least)
    );
    assert!(kept.margins.iter().all(|m| m.margin >= 0.0));
    // The cell costs something, and not everything.
    let cond = |d: &Design| d.criteria.unwrap().condition_number;
    assert!(cond(&kept) < 2.0 * cond(&free), "{} {}", cond(&kept), cond(&free));
}

#[test]
fn prop_a_start_inside_an_obstacle_is_an_infeasible_outcome_that_names_it() {
    let mut inside = cell();
    inside.boxes[0].center = Vector3::new(0.0, 0.0, 0.8);
    let design = find(spec(Some(inside)));
    let Outcome::Infeasible(reason) = &design.status else {
        panic!("{:?}", design.status)
    };
    assert!(reason.contains("`table`") && reason.contains("start_position"), "{reason}");
}

/// Length of a link of the folding arm (m).
const LINK: f64 = 0.4;

/// Three equal links that turn in one plane, the third beside the first two by so little that it cannot pass the first.
fn folding_arm() -> Robot {
    let joint = |i: usize| {
        let mdh = Mdh {
            alpha: 0.0,
            d: if i == 0 { 0.0 } else { LINK },
            theta: 0.0,
            r: if i == 2 { 0.02 } else { 0.0 },
        };
        let limits = Limits {
            position: Some([-2.6, 2.6]),
            velocity: Some(2.0),
            ..Limits::unlimited()
        };
        let capsule = Capsule {
            ends: [Vector3::zeros(), Vector3::x() * LINK],
            radius: 0.05,
        };
        Joint {
            geometry: vec![capsule],
            ..Joint::from_mdh(format!("J{}", i + 1), JointKind::Revolute, mdh).with_limits(limits)
        }
    };
    let gravity = Vector3::new(0.0, -9.81, 0.0);
    Robot::new("folding", gravity, (0..3).map(joint).collect(), FRICTION).unwrap()
}

/// No floor and no table: all that the arm can hit is itself, and from a folded start the free optimum does.
#[test]
fn prop_an_arm_keeps_off_itself_where_the_free_optimum_folds_into_itself() {
    let robot = folding_arm();
    let alone = SpaceLimits {
        clearance: CLEARANCE,
        half_spaces: Vec::new(),
        boxes: Vec::new(),
        self_collision: Some(SelfCollision::default()),
    };
    let asked = |space: Option<SpaceLimits>| ProblemSpec {
        robot: robot.clone(),
        start_position: Some(vec![0.0, 1.9, 1.5]),
        ..spec(space)
    };
    let (free, kept) = (find(asked(None)), find(asked(Some(alone))));
    let before = nearest_to_itself(&robot, &free.series);
    assert!(before < 0.0, "nothing to show: the free optimum keeps {before} m");
    // Points on the bodies are never nearer than the bodies: no allowance for how few they are.
    let after = nearest_to_itself(&robot, &kept.series);
    assert!(after >= CLEARANCE, "{after}");
    // It binds: drawing in stops within 0.1 % of the amplitude, which is 2.6 rad at most, of a tip 1.2 m away at most.
    assert!(after < CLEARANCE + 1e-3 * 2.6 * 3.0 * LINK, "{after}");
    // Neighbours touch by nature: the first and the third link are the one pair there is.
    let [pair] = kept.clearances.as_slice() else {
        panic!("{:?}", kept.clearances)
    };
    assert_eq!((pair.joint, pair.from.as_str()), (2, "J1"));
    assert!(
        pair.asked <= pair.certified && pair.certified <= pair.least.min(after),
        "{pair:?} {after}"
    );
    assert!(kept.margins.iter().all(|m| m.margin >= 0.0));
}

/// Least distance of the arm from itself over 5000 moments.
fn nearest_to_itself(robot: &Robot, series: &FourierSeries) -> f64 {
    let moments = 5000;
    let at = |k: usize| {
        let t = k as f64 * series.duration() / moments as f64;
        folded(&links(robot, &|j| series.state(j, t)[0]))
    };
    (0..moments).map(at).fold(f64::INFINITY, f64::min)
}

/// Distance of the third body from the first, point by point: of the iiwa's hand from its upper arm.
fn folded(links: &[(Vec<Point3<f64>>, f64)]) -> f64 {
    let (first, third) = (&links[0], &links[2]);
    let between = |p: &Point3<f64>| first.0.iter().map(|o| (p - o).norm()).fold(f64::INFINITY, f64::min);
    third.0.iter().map(between).fold(f64::INFINITY, f64::min) - first.1 - third.1
}

/// Least distance over 5000 moments: floor, table, hand against upper arm.
fn nearest(robot: &Robot, series: &FourierSeries) -> f64 {
    let moments = 5000;
    let at = |k: usize| {
        let t = k as f64 * series.duration() / moments as f64;
        let links = links(robot, &|j| series.state(j, t)[0]);
        let all = || links.iter().flat_map(|(points, r)| points.iter().map(move |p| (p, r)));
        let floor = all().map(|(p, r)| p.z - FLOOR - r).fold(f64::INFINITY, f64::min);
        let table = all().map(|(p, r)| outside(p) - r).fold(f64::INFINITY, f64::min);
        floor.min(table).min(folded(&links))
    };
    (0..moments).map(at).fold(f64::INFINITY, f64::min)
}

/// Distance to the table from outside; negative depth inside.
fn outside(p: &Point3<f64>) -> f64 {
    let away: [f64; 3] = std::array::from_fn(|i| (p[i] - TABLE[0][i]).abs() - 0.5 * TABLE[1][i]);
    let beyond = away.iter().map(|a| a.max(0.0).powi(2)).sum::<f64>().sqrt();
    beyond + away.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
}

/// Points along the axis of every capsule, and its radius, by modified DH of Khalil.
fn links(robot: &Robot, q: &dyn Fn(usize) -> f64) -> Vec<(Vec<Point3<f64>>, f64)> {
    let turn =
        |axis: Vector3<f64>, angle: f64| Isometry3::from_parts(Translation3::identity(), UnitQuaternion::new(axis * angle));
    let mut here = Isometry3::identity();
    let mut found = Vec::new();
    for (j, joint) in robot.joints().iter().enumerate() {
        let mdh = joint.mdh.unwrap();
        here = here
            * turn(Vector3::x(), mdh.alpha)
            * Translation3::new(mdh.d, 0.0, 0.0)
            * turn(Vector3::z(), mdh.theta + q(j))
            * Translation3::new(0.0, 0.0, mdh.r);
        for capsule in &joint.geometry {
            let [from, to] = capsule.ends;
            let points = (0..=40).map(|i| here * Point3::from(from + (to - from) * (i as f64 / 40.0)));
            found.push((points.collect(), capsule.radius));
        }
    }
    found
}
