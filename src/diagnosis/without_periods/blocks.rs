//! Normal equations of a fitted model by contiguous blocks of time.

use crate::regression::{Data, SETTINGS as REGRESSION_SETTINGS, System, TimeBlock, pseudo_root, time_blocks, transposed_product};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

/// The blocks of a fitted system, in coordinates z in which all of them together have the unit matrix for their information:
/// `θ = H z`, `Hᵀ G H = 1`.
pub(crate) struct Blocks {
    pub times: Vec<TimeBlock>,
    /// H.
    pub root: DMatrix<f64>,
    /// `J_b H` of every block, joint by joint.
    pub rows: Vec<Vec<DMatrix<f64>>>,
    /// `Hᵀ G_b H` of every block.
    pub inside: Vec<DMatrix<f64>>,
    /// `Hᵀ J_bᵀ r_b` of every block. They add up to zero, since the model is fitted.
    pub gradient: Vec<DVector<f64>>,
    /// Of every joint: sum of squares of the whitened residual.
    pub squares: Vec<f64>,
    /// Of every joint: the independent values that its rows are worth.
    pub effective_rows: Vec<f64>,
}

/// A fit of the model alone to some of the blocks.
pub(crate) struct Partial {
    /// Of its normal matrix, with the ridge.
    factor: Cholesky<f64, Dyn>,
    /// Change of z from the fit to all blocks.
    pub change: DVector<f64>,
}

impl Partial {
    /// `N⁻¹ a`, N the normal matrix of the fit.
    pub fn solve(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        self.factor.solve(a)
    }
}

impl Blocks {
    pub fn of(data: &Data, system: &System) -> Self {
        let root = pseudo_root(&data.normal(system), REGRESSION_SETTINGS.rank_tolerance);
        let count: Vec<usize> = system.blocks.iter().map(|b| b[0].residual.len()).collect();
        let times = time_blocks(&count, REGRESSION_SETTINGS.jackknife_blocks);
        let turned = |time: &TimeBlock| -> Vec<DMatrix<f64>> {
            let joint = |j: usize| system.blocks[time.stretch][j].jacobian.rows(time.rows.start, time.rows.len()) * &root;
            (0..data.noise.len()).map(joint).collect()
        };
        let rows: Vec<Vec<DMatrix<f64>>> = times.par_iter().map(turned).collect();
        let size = root.ncols();
        let inside = rows
            .par_iter()
            .map(|joints| {
                joints
                    .iter()
                    .fold(DMatrix::zeros(size, size), |sum, t| sum + transposed_product(t, t))
            })
            .collect();
        let gradient = times
            .iter()
            .zip(&rows)
            .map(|(time, joints)| {
                let own = |(j, t): (usize, &DMatrix<f64>)| t.tr_mul(&residual(system, time, j));
                joints
                    .iter()
                    .enumerate()
                    .map(own)
                    .fold(DVector::zeros(size), |sum, g| sum + g)
            })
            .collect();
        let joints = 0..data.noise.len();
        Self {
            root,
            inside,
            gradient,
            squares: joints.clone().map(|j| system.joint_chi_square(j)).collect(),
            effective_rows: joints.map(|j| system.effective_rows(j)).collect(),
            times,
            rows,
        }
    }

    /// Fits of the model alone without each block; `None` where the others do not determine it.
    pub fn each_left_out(&self) -> Option<Vec<Partial>> {
        (0..self.times.len()).into_par_iter().map(|b| self.without(&[b])).collect()
    }

    /// The fit of the model alone without these blocks.
    pub fn without(&self, left_out: &[usize]) -> Option<Partial> {
        let size = self.root.ncols();
        let start = DMatrix::identity(size, size) * (1.0 + REGRESSION_SETTINGS.jackknife_ridge);
        let normal = left_out.iter().fold(start, |sum, &b| sum - &self.inside[b]);
        let gradient = left_out.iter().fold(DVector::zeros(size), |sum, &b| sum - &self.gradient[b]);
        let factor = normal.cholesky()?;
        Some(Partial {
            change: factor.solve(&gradient),
            factor,
        })
    }
}

/// Whitened residual of a joint in a block.
pub(crate) fn residual(system: &System, time: &TimeBlock, joint: usize) -> DVector<f64> {
    let own = &system.blocks[time.stretch][joint].residual;
    own.rows(time.rows.start, time.rows.len()).into_owned()
}
