//! Signs of sums over fitted parameters, and whether they are beyond chance.
//!
//! A friction that drives or a kinetic energy below zero accuses a torque column only where its sign is known. Rows next to each
//! other go together, so the scatter of what stretches of time add to the sum says how well it is known (a linearised jackknife
//! over blocks), whatever the residual consists of.

use super::order::Projection;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::f_tail;
use nalgebra::DVector;

/// A fit, and what every stretch of time adds to it.
pub(crate) struct Evidence {
    pub values: DVector<f64>,
    influences: Vec<DVector<f64>>,
}

impl Evidence {
    pub fn of(projection: &Projection, order: &[usize], signs: &[f64]) -> Self {
        Self {
            values: projection.values(order, signs),
            influences: projection.influences(order, signs, SETTINGS.data_quality.sign_blocks),
        }
    }

    /// Parameter c and its standard deviation.
    pub fn with_deviation(&self, c: usize) -> (f64, f64) {
        let unit = DVector::from_fn(self.values.len(), |i, _| f64::from(u8::from(i == c)));
        (self.values[c], self.deviation(&unit))
    }

    fn deviation(&self, sum: &DVector<f64>) -> f64 {
        let of = |u: &DVector<f64>| sum.iter().zip(u.iter()).map(|(a, b)| a * b).sum::<f64>();
        let square: f64 = self.influences.iter().map(|u| of(u).powi(2)).sum();
        (square * SETTINGS.data_quality.sign_blocks as f64 / (SETTINGS.data_quality.sign_blocks - 1) as f64).sqrt()
    }

    /// `sum · values` over its standard deviation.
    pub fn ratio(&self, sum: &DVector<f64>) -> f64 {
        let value: f64 = sum.iter().zip(self.values.iter()).map(|(a, b)| a * b).sum();
        if value == 0.0 {
            return 0.0;
        }
        value / self.deviation(sum).max(f64::MIN_POSITIVE)
    }

    /// +1 or −1 where the sign of the sum is beyond chance, 0 where it is not.
    pub fn sign(&self, sum: &DVector<f64>) -> f64 {
        let ratio = self.ratio(sum);
        match f_tail(ratio * ratio, [1.0, (SETTINGS.data_quality.sign_blocks - 1) as f64]) < SETTINGS.data_quality.sign_chance {
            true => ratio.signum(),
            false => 0.0,
        }
    }
}
