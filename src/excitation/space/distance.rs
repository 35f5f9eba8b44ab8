//! Poses of the links, and distances between capsules and obstacles.

use super::pairs::{Against, Pair};
use crate::model::Robot;
use crate::spatial::Transform;
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::contact;
use parry3d_f64::query::details::closest_points_segment_segment_with_locations_nD;
use parry3d_f64::shape::{Capsule as Round, Cuboid};

/// Pose of every link in the base frame.
pub(super) fn poses(robot: &Robot, q: &dyn Fn(usize) -> f64, out: &mut Vec<Transform>) {
    out.clear();
    let mut here = Transform::identity();
    for (j, joint) in robot.joints().iter().enumerate() {
        here = here * joint.pose(q(j));
        out.push(here);
    }
}

/// How far two bodies are apart: negative where they overlap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distance {
    pub value: f64,
    /// From the second body to the first, unit length.
    pub normal: Vector3<f64>,
    /// Nearest point of the first body, and of the second, in the base frame; on the segment or the surface, all move with the
    /// body.
    pub points: [Vector3<f64>; 2],
}

impl Pair {
    pub(super) fn distance(&self, poses: &[Transform]) -> Distance {
        let ends = self.ends(poses);
        match &self.against {
            Against::HalfSpace { normal, offset } => {
                let heights = ends.map(|p| normal.dot(&p) - offset);
                let lower = usize::from(heights[1] < heights[0]);
                Distance {
                    value: heights[lower] - self.capsule.radius,
                    normal: *normal,
                    points: [ends[lower]; 2],
                }
            }
            Against::Box { center, size } => from_box(ends, self.capsule.radius, center, size),
            Against::Link { link, capsule } => {
                let other = capsule.ends.map(|p| poses[*link].rotation * p + poses[*link].translation);
                between_segments(ends, other, self.capsule.radius + capsule.radius)
            }
        }
    }

    fn ends(&self, poses: &[Transform]) -> [Vector3<f64>; 2] {
        let pose = &poses[self.link];
        self.capsule.ends.map(|p| pose.rotation * p + pose.translation)
    }

    /// Adds `weight ∂distance/∂q_k` to `add(k, …)` for all joints: `normal · (J_first − J_second)`.
    pub(super) fn gradient(&self, robot: &Robot, poses: &[Transform], at: &Distance, mut add: impl FnMut(usize, f64)) {
        let second = match &self.against {
            Against::Link { link, .. } => Some(*link),
            _ => None,
        };
        for (k, joint) in robot.joints().iter().enumerate() {
            let axis = poses[k].rotation.column(2).into_owned();
            let moved = |point: &Vector3<f64>| {
                if joint.is_revolute() {
                    axis.cross(&(point - poses[k].translation))
                } else {
                    axis
                }
            };
            let mut change = 0.0;
            if k <= self.link {
                change += at.normal.dot(&moved(&at.points[0]));
            }
            if second.is_some_and(|link| k <= link) {
                change -= at.normal.dot(&moved(&at.points[1]));
            }
            add(k, change);
        }
    }
}

fn to_parry(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_parry(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// Nothing of an arm is farther away than this (m).
const FAR: f64 = 1e3;

fn from_box(ends: [Vector3<f64>; 2], radius: f64, center: &Vector3<f64>, size: &Vector3<f64>) -> Distance {
    let round = Round::new(to_parry(&ends[0]), to_parry(&ends[1]), radius);
    let (here, there) = (Pose::IDENTITY, Pose::from_translation(to_parry(center)));
    let found = contact(&here, &round, &there, &Cuboid::new(to_parry(&(size * 0.5))), FAR);
    match found {
        Ok(Some(c)) => Distance {
            value: c.dist,
            normal: -from_parry(c.normal1),
            points: [from_parry(c.point1), from_parry(c.point2)],
        },
        _ => Distance {
            value: FAR,
            normal: Vector3::zeros(),
            points: ends,
        },
    }
}

fn between_segments(one: [Vector3<f64>; 2], other: [Vector3<f64>; 2], radii: f64) -> Distance {
    let (a, b) = (one.map(|p| to_parry(&p)), other.map(|p| to_parry(&p)));
    let (on_one, on_other) = closest_points_segment_segment_with_locations_nD((&a[0], &a[1]), (&b[0], &b[1]));
    let (u, v) = (on_one.barycentric_coordinates(), on_other.barycentric_coordinates());
    let points = [one[0] * u[0] + one[1] * u[1], other[0] * v[0] + other[1] * v[1]];
    let apart = points[0] - points[1];
    let length = apart.norm();
    Distance {
        value: length - radii,
        // Axes that cross have no direction to part in; the search then relies on other samples.
        normal: if length > 0.0 { apart / length } else { Vector3::zeros() },
        points,
    }
}
