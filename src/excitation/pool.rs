//! The best points found, one of each niche.
//!
//! Local solves end a percent or two above their local minimum, and one minimum is reached again and again: by value alone a pool
//! fills with copies of one basin within ten rounds, and exchange between its points then leads nowhere. Points are distinguished
//! by distance.

use super::variables::Variables;

/// A trajectory in the coordinates of its search: what searches of one problem hand each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Free coefficients, joint by joint; what they mean is the search's own affair.
    pub x: Vec<f64>,
    /// Logarithm of the criterion.
    pub value: f64,
    /// Whether it is a local minimum on all asked samples.
    pub polished: bool,
}

/// Niches kept: enough to exchange joints between different basins, few enough to press on.
const NICHES: usize = 10;
/// Distance below which two points belong to one niche. On the paper's problem local solves that came back to the point they were
/// disturbed from ended within 0.2 of it, nearly all others beyond 0.3.
const RADIUS: f64 = 0.25;

/// Best first; no two points of one niche.
#[derive(Debug, Clone, Default)]
pub(super) struct Pool(Vec<Point>);

impl Pool {
    pub fn from_points(variables: &Variables, points: impl IntoIterator<Item = Point>) -> Self {
        let mut pool = Self::default();
        pool.merge(variables, points);
        pool
    }

    pub fn points(&self) -> &[Point] {
        &self.0
    }

    pub fn best(&self) -> Option<&Point> {
        self.0.first()
    }

    pub fn mark_polished(&mut self, at: usize) {
        self.0[at].polished = true;
    }

    /// Takes points in; of each niche the best stays, and of the niches the best [`NICHES`].
    pub fn merge(&mut self, variables: &Variables, points: impl IntoIterator<Item = Point>) {
        let mut all = std::mem::take(&mut self.0);
        all.extend(points.into_iter().filter(|p| p.value.is_finite()));
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        for point in all {
            if self.0.len() < NICHES && !self.0.iter().any(|kept| is_near(variables, &kept.x, &point.x)) {
                self.0.push(point);
            }
        }
    }
}

pub(super) fn is_near(variables: &Variables, one: &[f64], other: &[f64]) -> bool {
    distance(variables, one, other) < RADIUS
}

/// Root mean square over the joints of `|x_j − y_j| / sqrt(|x_j| |y_j|)`, every joint scaled to its limits: 0 for equal motions,
/// about √2 for unrelated ones, whatever the joints' speeds.
pub(super) fn distance(variables: &Variables, one: &[f64], other: &[f64]) -> f64 {
    let per_joint = variables.per_joint();
    let (one, other) = (variables.on_the_limits(one), variables.on_the_limits(other));
    let squared = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
    let joints = one.chunks_exact(per_joint).zip(other.chunks_exact(per_joint));
    let sum: f64 = joints
        .map(|(x, y)| {
            let apart: f64 = x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum();
            apart / (squared(x) * squared(y)).sqrt().max(f64::MIN_POSITIVE)
        })
        .sum();
    (sum * per_joint as f64 / one.len() as f64).sqrt()
}
