//! Which of the bodies that fit a log equally well is the most plausible one.
//!
//! Near a prior body the geodesic distance of pseudo-inertias P (Lee, Wensing & Park 2019) is the quadratic form
//! `½ tr (P₀⁻¹ (P − P₀) P₀⁻¹ (P − P₀))`, their constant pull-back metric: it does not depend on the frame that the parameters are
//! written in, counts kilograms, metres and kilogram metres squared in one unit, and keeps the problem convex. Its metric says
//! how mass lies, not only how much of it: a wrist's gram four metres away is far from a wrist, however small its ten parameters
//! are.
//!
//! A link's mass lies about the link: its centre of mass is kept in a box around it.

use super::LinkScale;
use crate::model::{LinkPrior, Robot};
use crate::spatial::LinkInertia;
use nalgebra::{DMatrix, Matrix4, Vector3, Vector4};

/// Least eigenvalue of a prior's pseudo-inertia, as a fraction of its mass and radius of gyration: a prior that is thinner would
/// hold the body to its plane by a pull ten thousand times as strong as along it, which nobody who writes a prior means.
const THINNEST: f64 = 1e-2;

/// The pull-back metric at a prior over the ten standard parameters: the cost of `δ` is `½ δᵀ M δ`, without units.
pub(super) fn pull_back_metric(prior: &LinkPrior) -> DMatrix<f64> {
    let LinkScale { mass, length } = LinkScale::from_link(prior);
    let unit = Vector4::new(length, length, length, 1.0) * mass.sqrt();
    let scaled = |p: Matrix4<f64>| Matrix4::from_fn(|r, c| p[(r, c)] / (unit[r] * unit[c]));
    let eigen = scaled(prior.inertia.about_origin().pseudo_inertia()).symmetric_eigen();
    let inverse = Matrix4::from_diagonal(&eigen.eigenvalues.map(|v| v.max(THINNEST).recip()));
    let inverse = eigen.eigenvectors * inverse * eigen.eigenvectors.transpose();
    let along: Vec<Matrix4<f64>> = (0..10)
        .map(|k| {
            let mut parameters = [0.0; 10];
            parameters[k] = 1.0;
            inverse * scaled(LinkInertia::from_parameters(&parameters).pseudo_inertia())
        })
        .collect();
    DMatrix::from_fn(10, 10, |r, c| (along[r] * along[c]).trace())
}

/// Half of a link's longest segment, and the width of a joint at least (m): motors and flanges stick out of the line between
/// joints by that much.
const LEAST_MARGIN: f64 = 0.1;

/// Where the centre of mass of every link may be, in its frame: lowest and highest along x, y and z (m). Around the shape of the
/// link where that is known; otherwise around the line from its joint to the next, with half of the longer of the two segments
/// that meet in it to all sides, because frames of modified DH may lie off the link along the axes of its joints.
pub fn link_boxes(robot: &Robot) -> Vec<[[f64; 2]; 3]> {
    (0..robot.joint_count()).map(|k| link_box(robot, k)).collect()
}

fn link_box(robot: &Robot, k: usize) -> [[f64; 2]; 3] {
    let joints = robot.joints();
    let shape = &joints[k].geometry;
    if !shape.is_empty() {
        let ends = shape.iter().flat_map(|c| c.ends.map(|end| (end, c.radius)));
        return around(ends);
    }
    let own = joints[k].placement.translation.norm();
    let next = joints.get(k + 1).map_or(Vector3::zeros(), |j| j.placement.translation);
    let margin = (0.5 * own.max(next.norm())).max(LEAST_MARGIN);
    around([Vector3::zeros(), next].into_iter().map(|end| (end, margin)))
}

/// The box that holds these points with their margins.
fn around(points: impl Iterator<Item = (Vector3<f64>, f64)>) -> [[f64; 2]; 3] {
    let nothing = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    points.fold(nothing, |mut all, (point, margin)| {
        for (axis, [low, high]) in all.iter_mut().enumerate() {
            *low = low.min(point[axis] - margin);
            *high = high.max(point[axis] + margin);
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::PhysicalInertia;
    use nalgebra::Matrix3;

    /// The form is the second order of the divergence between Gaussians with these second moments,
    /// `tr(P₀⁻¹P) − ln det(P₀⁻¹P) − 4`.
    #[test]
    fn prop_the_metric_is_the_curvature_of_the_divergence() {
        let inertia = PhysicalInertia {
            mass: 3.0,
            center_of_mass: Vector3::new(0.1, -0.05, 0.2),
            inertia: Matrix3::new(0.06, 0.005, -0.002, 0.005, 0.07, 0.004, -0.002, 0.004, 0.05),
        };
        let prior = LinkPrior {
            inertia,
            viscous: 0.0,
            coulomb: 0.0,
        };
        let metric = pull_back_metric(&prior);
        let at = inertia.about_origin();
        let inverse = at.pseudo_inertia().try_inverse().unwrap();
        let divergence = |body: &LinkInertia| {
            let ratio = inverse * body.pseudo_inertia();
            ratio.trace() - ratio.determinant().ln() - 4.0
        };
        let scales = [3.0, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1];
        for k in 0..10 {
            let mut there = at.parameters();
            let step = 1e-4 * scales[k];
            there[k] += step;
            let body = LinkInertia::from_parameters(&there);
            let expected = 0.5 * metric[(k, k)] * step * step;
            let found = divergence(&body);
            assert!((found / expected - 1.0).abs() < 1e-2, "{k}: {found} {expected}");
        }
    }
}
