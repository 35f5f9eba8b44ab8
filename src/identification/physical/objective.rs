//! The cost of standard parameters: the weighted residual of the log.

use super::consistent::unconstrained_minimum;
use crate::parameters::BaseParameters;
use crate::regression::{JointNormal, Solution};
use nalgebra::{DMatrix, DVector};

/// `Σ_j ‖τⱼ − Wⱼ K φ‖²/σⱼ²`, as a quadratic form in the standard parameters φ; rows are weighted already.
#[derive(Debug, Clone)]
pub struct FitObjective {
    normals: Vec<JointNormal>,
    /// θ = map · x, x = standard parameters.
    pub map: DMatrix<f64>,
    /// Weighted Gram matrix and moment over θ.
    gram: DMatrix<f64>,
    moment: DVector<f64>,
    torque_square: f64,
    unconstrained: f64,
}

/// How a parameter set fits.
#[derive(Debug, Clone, PartialEq)]
pub struct FitRms {
    /// Per joint [N m or N].
    pub rms: Vec<f64>,
    /// Weighted residual sum of squares.
    pub cost: f64,
    /// Root of the cost over the unconstrained one: 1.02 fits 2 % worse than least squares.
    pub ratio: f64,
}

impl FitObjective {
    /// What is left to the bodies beside effects: `values` holds the base parameters, then what belongs to the effects, whose
    /// torque is taken off. `normals` are of rows that are weighted already.
    pub fn new(base: &BaseParameters, normals: &[JointNormal], values: &DVector<f64>) -> Self {
        let mut effects = values.clone();
        effects.rows_mut(0, base.len()).fill(0.0);
        let left = normals.iter().map(|n| n.without(&effects, base.len())).collect();
        Self::from_normals(left, base.map.clone())
    }

    fn from_normals(normals: Vec<JointNormal>, map: DMatrix<f64>) -> Self {
        let columns = map.nrows();
        let (mut gram, mut moment) = (DMatrix::zeros(columns, columns), DVector::zeros(columns));
        let mut torque_square = 0.0;
        for normal in &normals {
            normal.add_to(&mut gram, &mut moment);
            torque_square += normal.torque_square;
        }
        let mut objective = Self {
            normals,
            map,
            gram,
            moment,
            torque_square,
            unconstrained: 0.0,
        };
        let best = Solution::from_gram(objective.gram.clone(), objective.moment.clone()).values;
        objective.unconstrained = objective.cost_of_columns(&best);
        objective
    }

    /// Number of variables x.
    pub fn len(&self) -> usize {
        self.map.ncols()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn cost_of_columns(&self, theta: &DVector<f64>) -> f64 {
        self.normals.iter().map(|n| n.residual_square(theta)).sum()
    }

    /// `(H, g, c)` with cost = xᵀ H x − 2 gᵀ x + c.
    pub fn quadratic(&self) -> (DMatrix<f64>, DVector<f64>, f64) {
        (
            self.map.transpose() * &self.gram * &self.map,
            self.map.tr_mul(&self.moment),
            self.torque_square,
        )
    }

    /// Where the cost is least without any constraint: of least norm along what the log leaves open.
    pub fn center(&self) -> DVector<f64> {
        let (h, g, _) = self.quadratic();
        unconstrained_minimum(&(h * 2.0), &(g * -2.0))
    }

    /// The least cost without any constraint.
    pub fn unconstrained(&self) -> f64 {
        self.unconstrained
    }

    /// Weighted sum of squares of the torque itself.
    pub fn torque_square(&self) -> f64 {
        self.torque_square
    }

    /// The fit of `x`.
    pub fn fit(&self, x: &[f64]) -> FitRms {
        let theta = &self.map * DVector::from_column_slice(x);
        let rms = self
            .normals
            .iter()
            .map(|n| (n.residual_square(&theta) / n.rows.max(1) as f64).sqrt())
            .collect();
        let cost = self.cost_of_columns(&theta);
        FitRms {
            rms,
            cost,
            ratio: (cost / self.unconstrained.max(f64::MIN_POSITIVE)).sqrt(),
        }
    }
}
