//! Normal equations per joint: everything that weighted least squares needs of the rows, in w² numbers per joint.

use super::{JointRows, Observation};
use nalgebra::{DMatrix, DVector};

/// `Wⱼᵀ Wⱼ`, `Wⱼᵀ τⱼ`, `τⱼᵀ τⱼ` of one joint, summed over logs.
#[derive(Debug, Clone, PartialEq)]
pub struct JointNormal {
    /// Model column of every row and column of `gram`.
    pub columns: Vec<usize>,
    pub gram: DMatrix<f64>,
    pub moment: DVector<f64>,
    pub torque_square: f64,
    /// Rows that are data.
    pub rows: usize,
}

impl JointNormal {
    /// Residual sum of squares for parameters of the whole model: `τᵀτ − 2 θᵀWᵀτ + θᵀWᵀW θ`.
    pub fn residual_square(&self, values: &DVector<f64>) -> f64 {
        let own = DVector::from_iterator(self.columns.len(), self.columns.iter().map(|&c| values[c]));
        (self.torque_square - 2.0 * own.dot(&self.moment) + own.dot(&(&self.gram * &own))).max(0.0)
    }

    /// Adds `weight` times this joint to the p × p equations.
    pub fn add_to(&self, weight: f64, gram: &mut DMatrix<f64>, moment: &mut DVector<f64>) {
        for (b, &cb) in self.columns.iter().enumerate() {
            moment[cb] += weight * self.moment[b];
            for (a, &ca) in self.columns.iter().enumerate() {
                gram[(ca, cb)] += weight * self.gram[(a, b)];
            }
        }
    }
}

impl JointNormal {
    pub(super) fn of(rows: &JointRows) -> Self {
        Self {
            columns: rows.columns.clone(),
            gram: gram(&rows.matrix),
            moment: rows.matrix.tr_mul(&rows.torque),
            torque_square: rows.torque.norm_squared(),
            rows: rows.used_rows(),
        }
    }

    pub(super) fn sum(parts: impl Iterator<Item = Self>) -> Self {
        parts
            .reduce(|mut sum, part| {
                assert_eq!(sum.columns, part.columns, "observations of one model have the same columns");
                sum.gram += part.gram;
                sum.moment += part.moment;
                sum.torque_square += part.torque_square;
                sum.rows += part.rows;
                sum
            })
            .expect("at least one observation")
    }
}

/// Normal equations of all joints over several logs of the same model.
///
/// # Panics
/// When the observations have different columns, or there is none.
pub fn normal_equations(observations: &[Observation]) -> Vec<JointNormal> {
    let joints = observations.first().expect("at least one observation").joints.len();
    (0..joints)
        .map(|j| JointNormal::sum(observations.iter().map(|o| JointNormal::of(&o.joints[j]))))
        .collect()
}

/// `MᵀM` by blocks of rows: the stored transpose of a block fits the cache, which the product of the whole would not.
pub(crate) fn gram(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    const BLOCK: usize = 512;
    let w = matrix.ncols();
    let mut sum = DMatrix::zeros(w, w);
    for start in (0..matrix.nrows()).step_by(BLOCK) {
        let rows = BLOCK.min(matrix.nrows() - start);
        let block = matrix.rows(start, rows).into_owned();
        sum.gemm(1.0, &block.transpose(), &block, 1.0);
    }
    sum
}
