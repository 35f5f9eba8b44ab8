//! Normal equations per joint: everything that weighted least squares needs of the rows, in w² numbers per joint.

use nalgebra::{DMatrix, DVector};

/// `Wⱼᵀ Wⱼ`, `Wⱼᵀ τⱼ`, `τⱼᵀ τⱼ` of one joint, summed over logs.
#[derive(Debug, Clone, PartialEq)]
pub struct JointNormal {
    /// Model column of every row and column of `gram`.
    pub columns: Vec<usize>,
    /// `Wⱼᵀ Wⱼ`, w × w.
    pub gram: DMatrix<f64>,
    /// `Wⱼᵀ τⱼ`, w.
    pub moment: DVector<f64>,
    /// `τⱼᵀ τⱼ` [(N·m)² or N²; without unit where rows are whitened].
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

    /// Adds this joint to the p × p equations.
    pub fn add_to(&self, gram: &mut DMatrix<f64>, moment: &mut DVector<f64>) {
        for (b, &cb) in self.columns.iter().enumerate() {
            moment[cb] += self.moment[b];
            for (a, &ca) in self.columns.iter().enumerate() {
                gram[(ca, cb)] += self.gram[(a, b)];
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
}
