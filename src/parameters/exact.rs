//! The base parameters of a serial arm in closed form.
//!
//! Regrouping rules of Gautier & Khalil (1990), stated for a general fixed transform per joint: a body that is symmetric about a
//! revolute joint's axis may be handed to the link before, because the joint turns it into itself; the rotational inertia of a
//! sliding link may be handed on as it is. At the start of the chain some links cannot turn, or turn about one direction only,
//! and more drops out. Each rule is a null vector `ν` of the regressor, `Y ν = 0`; eliminating from the last parameter to the
//! first leaves the parameters that come first, which is Khalil's choice of names.

use crate::model::{Joint, Robot};
use crate::parameters::Layout;
use crate::spatial::{LinkInertia, Transform};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Null vectors of the regressor over the inertial parameters, one per row, (nulls × p of `layout`).
pub(super) fn null_vectors(robot: &Robot, layout: &Layout) -> DMatrix<f64> {
    let mut nulls = Nulls {
        layout,
        rows: Vec::new(),
    };
    let mut reach = Reach::base(robot.gravity());
    for (k, joint) in robot.joints().iter().enumerate() {
        let before = reach;
        reach = reach.past(joint);
        nulls.handed_on(k, joint, before.turning);
        nulls.never_seen(k, &reach);
    }
    let p = layout.len();
    DMatrix::from_fn(nulls.rows.len(), p, |r, c| nulls.rows[r][c])
}

/// Directions nearer than this are parallel, offsets below it are none: products of a few exact rotations and lengths of order
/// one carry 1e-15, real geometry starts at micrometres.
const NEGLIGIBLE: f64 = 1e-9;

/// How a link can turn.
#[derive(Clone, Copy)]
enum Turning {
    Never,
    /// About one direction only, given in the link's frame.
    About(Vector3<f64>),
    Freely,
}

/// How a link can move, in its own frame.
#[derive(Clone, Copy)]
struct Reach {
    turning: Turning,
    /// A point of the body that never accelerates across the turning direction (in any direction for a link that turns freely).
    pivot: Option<Vector3<f64>>,
    /// Direction of all sliding joints so far; `None` before the first, `Some(None)` when they differ.
    sliding: Option<Option<Vector3<f64>>>,
    /// Gravity at q = 0. Whether it lies along the only turning direction does not depend on q.
    gravity: Vector3<f64>,
}

impl Reach {
    fn base(gravity: Vector3<f64>) -> Self {
        Self {
            turning: Turning::Never,
            pivot: None,
            sliding: None,
            gravity,
        }
    }

    /// The reach of the link behind `joint`. Directions kept are those that the joint leaves in place.
    fn past(&self, joint: &Joint) -> Self {
        let back = joint.placement.inverse();
        let z = Vector3::z();
        let turning = match (self.turning, joint.is_revolute()) {
            (Turning::Never, true) => Turning::About(z),
            (Turning::Never, false) => Turning::Never,
            (Turning::About(a), revolute) => {
                let a = back.rotation * a;
                if revolute && !parallel(&a, &z) {
                    Turning::Freely
                } else {
                    Turning::About(a)
                }
            }
            (Turning::Freely, _) => Turning::Freely,
        };
        let sliding = match self.sliding.map(|same| same.map(|d| back.rotation * d)) {
            None if joint.is_revolute() => None,
            None => Some(Some(z)),
            // Kept by a joint along it; turned away, or joined by another direction, by any other.
            Some(Some(d)) if parallel(&d, &z) => Some(Some(z)),
            Some(_) => Some(None),
        };
        let reach = Self {
            turning,
            pivot: None,
            sliding,
            gravity: back.rotation * self.gravity,
        };
        Self {
            pivot: self.pivot_past(joint, &back, &reach),
            ..reach
        }
    }

    /// Whether all that slides, slides along `direction`.
    fn slides_only_along(&self, direction: &Vector3<f64>) -> bool {
        self.sliding.is_none_or(|same| same.is_some_and(|d| parallel(&d, direction)))
    }

    fn pivot_past(&self, joint: &Joint, back: &Transform, reach: &Reach) -> Option<Vector3<f64>> {
        let z = Vector3::z();
        let before = self.pivot.map(|p| back.rotation * p + back.translation);
        match (self.turning, reach.turning) {
            (_, Turning::Never) => None,
            // The first turning joint: its axis stays where it is if all that slides, slides along it.
            (Turning::Never, _) => reach.slides_only_along(&z).then(Vector3::zeros),
            // The same direction again: a turning joint must share the line, a sliding one keep to it.
            (Turning::About(_), Turning::About(a)) => {
                let point = before?;
                let across = point - a * point.dot(&a);
                let same_line = !joint.is_revolute() || across.norm() < NEGLIGIBLE;
                (same_line && reach.slides_only_along(&a)).then_some(across)
            }
            // A new direction: the point where the new axis meets the old line, if nothing slides.
            (Turning::About(a), Turning::Freely) if reach.sliding.is_none() => meeting_point(&before?, &(back.rotation * a)),
            (Turning::Freely, _) if reach.sliding.is_none() => {
                before.filter(|point| (point - z * point.dot(&z)).norm() < NEGLIGIBLE)
            }
            _ => None,
        }
    }
}

fn parallel(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.cross(b).norm() < NEGLIGIBLE
}

/// Where the line through `point` along `a` meets the z axis, if it does: `z t = point + a s`, hence `(z × a) t = point × a`.
fn meeting_point(point: &Vector3<f64>, a: &Vector3<f64>) -> Option<Vector3<f64>> {
    let z = Vector3::z();
    let (left, right) = (z.cross(a), point.cross(a));
    let t = left.dot(&right) / left.norm_squared();
    ((left * t - right).norm() < NEGLIGIBLE).then_some(z * t)
}

struct Nulls<'a> {
    layout: &'a Layout,
    rows: Vec<Vec<f64>>,
}

impl Nulls<'_> {
    fn push(&mut self, bodies: &[(usize, LinkInertia)]) {
        let mut row = vec![0.0; self.layout.len()];
        for (link, body) in bodies {
            let start = link * self.layout.per_link();
            row[start..start + 10]
                .iter_mut()
                .zip(body.parameters())
                .for_each(|(r, p)| *r += p);
        }
        self.rows.push(row);
    }

    /// Bodies of link k that the link before may carry in its place.
    fn handed_on(&mut self, k: usize, joint: &Joint, before: Turning) {
        let mut bodies = Vec::new();
        if joint.is_revolute() {
            bodies.push(mass());
            bodies.push(first_moment(Vector3::z()));
            bodies.push(rotational(Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0))));
        } else {
            bodies.extend(symmetric_basis().map(rotational));
            // A link that slides along the only direction it turns about keeps its moments about that direction.
            let z_before = joint.placement.rotation * Vector3::z();
            if matches!(before, Turning::About(a) if parallel(&a, &z_before)) {
                bodies.extend([Vector3::x(), Vector3::y(), Vector3::z()].map(first_moment));
            }
        }
        for body in bodies {
            match k {
                0 => self.push(&[(0, body)]),
                _ => self.push(&[(k, negated(&body)), (k - 1, body.transformed(&joint.placement))]),
            }
        }
    }

    /// Bodies of link k that do no work whatever the arm does.
    fn never_seen(&mut self, k: usize, reach: &Reach) {
        let weightless = reach.gravity.norm() == 0.0;
        match reach.turning {
            Turning::Never => {
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    self.push(&[(k, first_moment(axis))]);
                }
                for basis in symmetric_basis() {
                    self.push(&[(k, rotational(basis))]);
                }
            }
            Turning::About(a) => {
                self.push(&[(k, first_moment(a))]);
                for basis in symmetric_basis() {
                    // Only aᵀ I a is seen: take that part out of every basis element.
                    let unseen = basis - a * a.transpose() * a.dot(&(basis * a));
                    self.push(&[(k, rotational(unseen))]);
                }
                let level = parallel(&a, &reach.gravity);
                if let (true, Some(pivot)) = (level, reach.pivot) {
                    self.moments_about(k, pivot);
                }
            }
            Turning::Freely => {
                if let (true, Some(pivot)) = (weightless, reach.pivot) {
                    self.moments_about(k, pivot);
                }
            }
        }
    }

    /// First moments about a point that does not accelerate.
    fn moments_about(&mut self, k: usize, pivot: Vector3<f64>) {
        let there = Transform::trans(pivot.x, pivot.y, pivot.z);
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            self.push(&[(k, first_moment(axis).transformed(&there))]);
        }
    }
}

fn mass() -> LinkInertia {
    LinkInertia {
        mass: 1.0,
        ..LinkInertia::zero()
    }
}

fn first_moment(h: Vector3<f64>) -> LinkInertia {
    LinkInertia {
        first_moment: h,
        ..LinkInertia::zero()
    }
}

fn rotational(inertia: Matrix3<f64>) -> LinkInertia {
    LinkInertia {
        inertia,
        ..LinkInertia::zero()
    }
}

fn negated(body: &LinkInertia) -> LinkInertia {
    LinkInertia {
        mass: -body.mass,
        first_moment: -body.first_moment,
        inertia: -body.inertia,
    }
}

fn symmetric_basis() -> [Matrix3<f64>; 6] {
    let unit = |r: usize, c: usize| {
        let mut m = Matrix3::zeros();
        (m[(r, c)], m[(c, r)]) = (1.0, 1.0);
        m
    };
    [unit(0, 0), unit(0, 1), unit(0, 2), unit(1, 1), unit(1, 2), unit(2, 2)]
}
