//! Shapes of links, for keeping the arm off its surroundings and off itself.

use super::INPUT_LIMITS;
use crate::spatial::Transform;
use nalgebra::{Matrix3, Vector3};

/// All points within `radius` of the segment between two points fixed to a link. Chosen generously it contains the link;
/// distances between two of them, and their derivatives, are exact and cheap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// Ends of the segment in the link frame of the dynamics (m).
    pub ends: [Vector3<f64>; 2],
    /// (m)
    pub radius: f64,
}

/// Points on a link, each with all that is nearer to it than a distance (m).
pub type Ball = (Vector3<f64>, f64);

impl Capsule {
    /// The smallest of seven capsules that contain all the balls: its axis runs along x, y, z, a principal direction of the
    /// centres, or the line between the two that are farthest apart in such a direction, and through the middle of what is seen
    /// along it. `None` without balls, or with numbers that no link has.
    pub fn around(balls: &[Ball]) -> Option<Self> {
        let usable =
            |&(p, r): &Ball| p.iter().all(|v| v.abs() <= INPUT_LIMITS.length) && (0.0..=INPUT_LIMITS.length).contains(&r);
        if balls.is_empty() || !balls.iter().all(usable) {
            return None;
        }
        let fitted = directions(balls).into_iter().map(|axis| Self::along(axis, balls));
        fitted
            .filter(|c| c.radius > 0.0)
            .min_by(|a, b| a.volume().total_cmp(&b.volume()))
    }

    /// The capsule around `balls` with this direction (a unit vector).
    fn along(axis: Vector3<f64>, balls: &[Ball]) -> Self {
        let turn = Transform::z_onto(&axis);
        let seen: Vec<Ball> = balls.iter().map(|(p, r)| (turn.transpose() * p, *r)).collect();
        let middle = |k: usize| {
            let low = seen.iter().map(|(p, r)| p[k] - r).fold(f64::INFINITY, f64::min);
            let high = seen.iter().map(|(p, r)| p[k] + r).fold(f64::NEG_INFINITY, f64::max);
            0.5 * (low + high)
        };
        let (x, y) = (middle(0), middle(1));
        let off = |p: &Vector3<f64>| (p.x - x).hypot(p.y - y);
        let radius = seen.iter().map(|(p, r)| off(p) + r).fold(0.0, f64::max);
        // A ball at height z is within the round end around height e where |z − e| is at most this.
        let room = |(p, r): &Ball| ((radius - r).powi(2) - off(p).powi(2)).max(0.0).sqrt();
        let low = seen.iter().map(|b| b.0.z + room(b)).fold(f64::INFINITY, f64::min);
        let high = seen.iter().map(|b| b.0.z - room(b)).fold(f64::NEG_INFINITY, f64::max);
        // Where the ends pass each other, any height between them is a sphere around all.
        let (low, high) = if low > high {
            (0.5 * (low + high), 0.5 * (low + high))
        } else {
            (low, high)
        };
        Self {
            ends: [low, high].map(|z| turn * Vector3::new(x, y, z)),
            radius,
        }
    }

    fn volume(&self) -> f64 {
        let length = (self.ends[1] - self.ends[0]).norm();
        std::f64::consts::PI * self.radius.powi(2) * (length + 4.0 / 3.0 * self.radius)
    }

    /// The capsule as its two round ends.
    pub fn balls(&self) -> [Ball; 2] {
        self.ends.map(|end| (end, self.radius))
    }

    /// In the frame that this frame has the pose `pose` in.
    pub fn moved(&self, pose: &Transform) -> Self {
        Self {
            ends: self.ends.map(|end| pose.rotation * end + pose.translation),
            ..*self
        }
    }
}

/// Capsules of one link at most; more shapes are put into one around them all. Distances between links grow with the square.
const MOST: usize = 4;

/// The capsules of a link that has these shapes.
pub(super) fn few(capsules: Vec<Capsule>) -> Vec<Capsule> {
    if capsules.len() <= MOST {
        return capsules;
    }
    let balls: Vec<Ball> = capsules.iter().flat_map(Capsule::balls).collect();
    Capsule::around(&balls).into_iter().collect()
}

fn directions(balls: &[Ball]) -> Vec<Vector3<f64>> {
    let mean = balls.iter().map(|b| b.0).sum::<Vector3<f64>>() / balls.len() as f64;
    let spread: Matrix3<f64> = balls.iter().map(|b| (b.0 - mean) * (b.0 - mean).transpose()).sum();
    let mut axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    if let Some(own) = spread.try_symmetric_eigen(f64::EPSILON, 100) {
        axes.extend((0..3).map(|k| own.eigenvectors.column(k).into_owned()));
        let longest = own.eigenvectors.column(own.eigenvalues.imax());
        let height = |b: &&Ball| b.0.dot(&longest);
        let ends = [
            balls.iter().min_by(|a, b| height(a).total_cmp(&height(b))),
            balls.iter().max_by(|a, b| height(a).total_cmp(&height(b))),
        ];
        if let [Some(a), Some(b)] = ends {
            axes.extend((b.0 - a.0).try_normalize(1e-9));
        }
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn contains(capsule: &Capsule, (p, r): &Ball) -> bool {
        let along = capsule.ends[1] - capsule.ends[0];
        let part = (along.dot(&(p - capsule.ends[0])) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        // Rounding of a few additions of numbers below 10.
        (p - capsule.ends[0] - part * along).norm() + r <= capsule.radius + 1e-13
    }

    #[test]
    fn prop_a_capsule_contains_what_it_is_fitted_to() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..300 {
            let count = rng.random_range(1..20);
            let ball = |rng: &mut ChaCha8Rng| {
                let p = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
                (p, rng.random_range(0.01..0.4))
            };
            let balls: Vec<Ball> = (0..count).map(|_| ball(&mut rng)).collect();
            let fitted = Capsule::around(&balls).unwrap();
            assert!(balls.iter().all(|b| contains(&fitted, b)), "{fitted:?} {balls:?}");
        }
    }

    #[test]
    fn prop_a_capsule_is_found_again_in_any_pose() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..100 {
            let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let capsule = Capsule {
                ends: [vector(), vector()],
                radius: 0.1,
            };
            let fitted = Capsule::around(&capsule.balls()).unwrap();
            assert!(
                (fitted.radius - 0.1).abs() < 1e-9 && fitted.volume() < capsule.volume() * (1.0 + 1e-7),
                "{fitted:?} {capsule:?}"
            );
        }
    }
}
