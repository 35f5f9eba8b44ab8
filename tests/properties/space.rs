//! Trajectories keep off the floor, the table and the arm itself, as seen by kinematics and distances of the test's own.

use dynident::excitation::*;
use dynident::io::{NamedRobots, shipped::Shipped};
use dynident::model::Robot;
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
    // Segments are looked at at 41 points each: between two of them a distance to a plane or a convex body is at most this much less.
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

/// Least distance over 5000 moments: floor, table, hand against upper arm.
fn nearest(robot: &Robot, series: &FourierSeries) -> f64 {
    let moments = 5000;
    let at = |k: usize| {
        let t = k as f64 * series.duration() / moments as f64;
        let links = links(robot, &|j| series.state(j, t)[0]);
        let all = || links.iter().flat_map(|(points, r)| points.iter().map(move |p| (p, r)));
        let floor = all().map(|(p, r)| p.z - FLOOR - r).fold(f64::INFINITY, f64::min);
        let table = all().map(|(p, r)| outside(p) - r).fold(f64::INFINITY, f64::min);
        let (upper, hand) = (&links[0], &links[2]);
        let between = |p: &Point3<f64>| upper.0.iter().map(|o| (p - o).norm()).fold(f64::INFINITY, f64::min);
        let folded = hand.0.iter().map(between).fold(f64::INFINITY, f64::min) - upper.1 - hand.1;
        floor.min(table).min(folded)
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
