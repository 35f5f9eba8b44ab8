//! A body that was not there when the model was made.

use super::{About, Column, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene};
use crate::dynamics::{Chain, ColumnSet, Coulomb, RowBlocks};
use crate::model::Robot;
use crate::parameters::{Inertial, Layout};
use crate::spatial::LinkInertia;
use nalgebra::{DMatrix, DVector, Matrix4};

/// Ten inertial parameters at the last link.
pub struct Payload;

impl Effect for Payload {
    fn code(&self) -> &'static str {
        "payload"
    }

    fn about(&self) -> About {
        About {
            name: "Payload",
            phrase: "a payload at the last link",
            meaning: "A body at the last link that the model does not contain.",
            over: PlotVariable::Torque,
            identifiable: "against an existing model only: in an identification it is a part of the last link's parameters",
            rivals: &["base_tilt", "torque_gain", "torque_offset"],
            source: "Khalil, Gautier & Lemoine 2007; consistency: Traversaro et al. 2016",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn kind(&self) -> EffectKind {
        EffectKind::AgainstModel
    }

    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        vec![vec![robot.joint_count() - 1]]
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        let layout = Layout::standard(scene.robot);
        let wanted: Vec<usize> = Inertial::ALL.iter().map(|&i| layout.inertial(joints[0], i)).collect();
        let set = ColumnSet::new(scene.robot, &layout, &wanted);
        let mut rows = RowBlocks::new(&set, scene.samples());
        rows.fill(&Chain::new(scene.robot), &set, scene.motion, Coulomb::Sign);
        let mut columns = vec![Column { rows: Vec::new() }; wanted.len()];
        for j in 0..scene.robot.joint_count() {
            for (values, &output) in rows.block(j).chunks_exact(rows.stride()).zip(set.row(j)) {
                columns[output].rows.push((j, values[..scene.samples()].to_vec()));
            }
        }
        columns
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        let named = [("mass", "kg"), ("center_x", "m"), ("center_y", "m"), ("center_z", "m")];
        let inertia = ["xx", "xy", "xz", "yy", "yz", "zz"].map(|i| ParameterInfo::new(format!("inertia_{i}"), "kg m^2"));
        named
            .map(|(n, u)| ParameterInfo::new(n, u))
            .into_iter()
            .chain(inertia)
            .collect()
    }

    fn consistent(&self, coefficients: &[f64], information: &DMatrix<f64>) -> Vec<f64> {
        consistent_payload(coefficients, information).to_vec()
    }

    /// Mass, centre of mass in the last link's frame, inertia about the centre of mass.
    fn reported(&self, _form: usize, coefficients: &[f64], _shape: &[f64]) -> Vec<f64> {
        let body = LinkInertia::from_parameters(coefficients);
        let c = body.first_moment / body.mass;
        let about = body.physical().map_or(body.inertia, |p| p.inertia);
        let i = |r, k| about[(r, k)];
        vec![body.mass, c.x, c.y, c.z, i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2)]
    }
}

/// The physically consistent body nearest to the estimate `theta` (10) in the metric of its information matrix (10 × 10):
/// pseudo-inertia `J = L Lᵀ` with L lower triangular, found by Levenberg-Marquardt over the ten entries of L.
///
/// An estimate that is consistent already comes back as it is.
pub fn consistent_payload(theta: &[f64], information: &DMatrix<f64>) -> [f64; 10] {
    let estimate: [f64; 10] = std::array::from_fn(|i| theta[i]);
    let body = LinkInertia::from_parameters(&estimate);
    let eigen = body.pseudo_inertia().symmetric_eigen();
    if eigen.eigenvalues.min() > 0.0 {
        return estimate;
    }
    // Start: negative eigenvalues lifted to a thousandth of the largest.
    let least = 1e-3 * eigen.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let lifted =
        eigen.eigenvectors * Matrix4::from_diagonal(&eigen.eigenvalues.map(|v| v.max(least))) * eigen.eigenvectors.transpose();
    let Some(start) = lifted.cholesky() else { return estimate };
    nearest(&estimate, information, start.l())
}

fn nearest(estimate: &[f64; 10], information: &DMatrix<f64>, start: Matrix4<f64>) -> [f64; 10] {
    let root = information.clone().symmetric_eigen();
    let weight = DMatrix::from_diagonal(&root.eigenvalues.map(|v| v.max(0.0).sqrt())) * root.eigenvectors.transpose();
    let target = DVector::from_column_slice(estimate);
    let residual = |x: &[f64; 10]| &weight * (DVector::from_column_slice(&parameters_of(x)) - &target);
    let mut x: [f64; 10] = std::array::from_fn(|i| start[LOWER[i]]);
    let mut damping = 1e-3;
    let mut r = residual(&x);
    for _ in 0..200 {
        let jacobian = (0..10).fold(DMatrix::zeros(10, 10), |mut jac, c| {
            let step = 1e-6 * x[c].abs().max(1e-3);
            let mut there = x;
            there[c] += step;
            jac.set_column(c, &((residual(&there) - &r) / step));
            jac
        });
        let mut normal = jacobian.tr_mul(&jacobian);
        for i in 0..10 {
            normal[(i, i)] += damping * normal[(i, i)].max(1e-12);
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&jacobian.tr_mul(&r))) else {
            break;
        };
        let there: [f64; 10] = std::array::from_fn(|i| x[i] - step[i]);
        let tried = residual(&there);
        if tried.norm_squared() < r.norm_squared() {
            let settled = r.norm_squared() - tried.norm_squared() < 1e-12 * r.norm_squared();
            (x, r) = (there, tried);
            damping *= 0.3;
            if settled {
                break;
            }
        } else {
            damping *= 4.0;
        }
    }
    parameters_of(&x)
}

const LOWER: [(usize, usize); 10] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (3, 3)];

/// Standard parameters of the body with pseudo-inertia `L Lᵀ`: `I = tr(Σ) E − Σ`.
fn parameters_of(x: &[f64; 10]) -> [f64; 10] {
    let mut l = Matrix4::zeros();
    LOWER.iter().zip(x).for_each(|(&at, &v)| l[at] = v);
    let j = l * l.transpose();
    let trace = j[(0, 0)] + j[(1, 1)] + j[(2, 2)];
    [
        j[(3, 3)],
        j[(0, 3)],
        j[(1, 3)],
        j[(2, 3)],
        trace - j[(0, 0)],
        -j[(0, 1)],
        -j[(0, 2)],
        trace - j[(1, 1)],
        -j[(1, 2)],
        trace - j[(2, 2)],
    ]
}
