//! Solving weighted normal equations, and saying which directions the data do not determine.

use super::joint_normal::JointNormal;
use super::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

/// The normal equations `Σ WⱼᵀWⱼ θ = Σ Wⱼᵀτⱼ` of weighted rows, decomposed after scaling columns to equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// p; of least norm (in scaled columns) within what the data leave open.
    pub values: DVector<f64>,
    /// Pseudo-inverse of the weighted Gram matrix, p × p, over the directions that are determined.
    pub inverse: DMatrix<f64>,
    /// Of the scaled matrix, largest first; p of them.
    pub singular_values: Vec<f64>,
    /// Rank of the equations.
    pub rank: usize,
    /// One unit vector over the scaled columns per undetermined direction.
    pub null_directions: Vec<DVector<f64>>,
    /// Length of every weighted column.
    pub column_scale: DVector<f64>,
}

impl Solution {
    /// Summed over the joints; `columns` is p.
    pub fn new(normals: &[JointNormal], columns: usize) -> Self {
        let (mut gram, mut moment) = (DMatrix::zeros(columns, columns), DVector::zeros(columns));
        normals.iter().for_each(|normal| normal.add_to(&mut gram, &mut moment));
        Self::from_gram(gram, moment)
    }

    /// Solves `gram θ = moment` in the directions that the data determine.
    pub fn from_gram(gram: DMatrix<f64>, moment: DVector<f64>) -> Self {
        let p = moment.len();
        let scale = DVector::from_fn(p, |c, _| gram[(c, c)].max(0.0).sqrt());
        // A column of zeros keeps its place and turns up as a null direction of its own.
        let divisor = scale.map(|s| if s > 0.0 { s } else { 1.0 });
        let scaled = DMatrix::from_fn(p, p, |r, c| gram[(r, c)] / (divisor[r] * divisor[c]));
        let eigen = scaled.symmetric_eigen();
        let mut order: Vec<usize> = (0..p).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let singular_values: Vec<f64> = order.iter().map(|&i| eigen.eigenvalues[i].max(0.0).sqrt()).collect();
        let largest = singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values
            .iter()
            .filter(|&&s| s > SETTINGS.determined_tolerance * largest && s > 0.0)
            .count();
        let mut inverse = DMatrix::zeros(p, p);
        for &i in &order[..rank] {
            let direction = eigen.eigenvectors.column(i).component_div(&divisor);
            inverse.ger(1.0 / eigen.eigenvalues[i], &direction, &direction, 1.0);
        }
        let mut values = &inverse * &moment;
        // One step of refinement: eigenvectors are good to 1e-15 times the condition of the Gram matrix.
        values += &inverse * (&moment - &gram * &values);
        let null_directions = order[rank..]
            .iter()
            .map(|&i| eigen.eigenvectors.column(i).into_owned())
            .collect();
        Self {
            values,
            inverse,
            singular_values,
            rank,
            null_directions,
            column_scale: scale,
        }
    }

    /// Ratio of the extreme singular values of the scaled matrix; infinite when directions are missing.
    pub fn condition_number(&self) -> f64 {
        match (self.singular_values.first(), self.singular_values.last()) {
            (Some(first), Some(last)) if self.rank == self.singular_values.len() => first / last,
            _ => f64::INFINITY,
        }
    }

    /// Whether the data determine parameter `c`: no undetermined direction has a part in it. Directions are unit vectors whose
    /// entries carry rounding of 1e-15 over the gap to the next eigenvalue; a thousandth is far above that.
    pub fn is_determined(&self, c: usize) -> bool {
        self.null_directions.iter().all(|v| v[c].abs() < 1e-3)
    }
}
