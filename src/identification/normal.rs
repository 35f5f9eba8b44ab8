//! Normal equations per joint: everything that weighted least squares needs of the rows, in w² numbers per joint.

use super::{JointRows, Observation};
use matrixmultiply::dgemm;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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
    /// Standard deviation that recording has added to a torque, of the coarsest log [N m or N].
    pub resolution: f64,
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
    /// The equations of the first `count` model columns, with the torque that `known` values of the others make taken off.
    pub fn without(&self, known: &DVector<f64>, count: usize) -> Self {
        let own: Vec<usize> = (0..self.columns.len()).filter(|&c| self.columns[c] < count).collect();
        let values = DVector::from_iterator(self.columns.len(), self.columns.iter().map(|&c| known[c]));
        let moment = &self.moment - &self.gram * &values;
        Self {
            columns: own.iter().map(|&c| self.columns[c]).collect(),
            gram: self.gram.select_rows(&own).select_columns(&own),
            moment: moment.select_rows(&own),
            torque_square: self.residual_square(known),
            rows: self.rows,
            resolution: self.resolution,
        }
    }

    /// Of no rows.
    pub(super) fn none(rows: &JointRows) -> Self {
        let w = rows.columns.len();
        Self {
            columns: rows.columns.clone(),
            gram: DMatrix::zeros(w, w),
            moment: DVector::zeros(w),
            torque_square: 0.0,
            rows: rows.used_rows(),
            resolution: rows.resolution,
        }
    }

    /// Takes up rows.
    pub(super) fn add(&mut self, matrix: &DMatrix<f64>, torque: &DVector<f64>) {
        self.gram += gram(matrix);
        self.moment += matrix.tr_mul(torque);
        self.torque_square += torque.norm_squared();
    }

    fn join(&mut self, other: &Self) {
        assert_eq!(self.columns, other.columns, "observations of one model have the same columns");
        self.gram += &other.gram;
        self.moment += &other.moment;
        self.torque_square += other.torque_square;
        self.rows += other.rows;
        self.resolution = self.resolution.max(other.resolution);
    }
}

/// Normal equations of all joints over several logs of the same model.
///
/// # Panics
/// When the observations have different columns, or there is none.
pub fn normal_equations(observations: &[Observation]) -> Vec<JointNormal> {
    summed(observations, |_, _, normal, matrix, torque| normal.add(matrix, &torque))
}

/// Normal equations to which `add` takes up the rows of every joint: number of the observation and of the joint, what to add to, rows and
/// torques. Joints are worked on side by side.
pub(super) fn summed(
    observations: &[Observation],
    add: impl Fn(usize, usize, &mut JointNormal, &DMatrix<f64>, DVector<f64>) + Sync,
) -> Vec<JointNormal> {
    let of = |(number, o): (usize, &Observation)| -> Vec<JointNormal> {
        let joint = |(j, rows): (usize, &JointRows)| {
            let mut normal = JointNormal::none(rows);
            add(number, j, &mut normal, &o.matrices[j], rows.torque.clone());
            normal
        };
        o.joints.par_iter().enumerate().map(joint).collect()
    };
    observations
        .iter()
        .enumerate()
        .map(of)
        .reduce(|mut sum, part| {
            sum.iter_mut().zip(&part).for_each(|(a, b)| a.join(b));
            sum
        })
        .expect("at least one observation")
}

/// `MᵀM`: the kernel packs both factors by blocks that stay in the cache.
pub(crate) fn gram(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, w) = matrix.shape();
    let mut product = DMatrix::zeros(w, w);
    if rows == 0 || w == 0 {
        return product;
    }
    let (step, out, values) = (rows as isize, w as isize, matrix.as_ptr());
    // SAFETY: `matrix` holds rows × w values and `product` w × w, both column after column; the first factor is read as its transpose.
    unsafe {
        dgemm(
            w,
            rows,
            w,
            1.0,
            values,
            step,
            1,
            values,
            1,
            step,
            0.0,
            product.as_mut_ptr(),
            1,
            out,
        );
    }
    product
}
