//! Whether data that a fit has not seen would show an effect as well.
//!
//! The search asks that the gain D on folds of time left out ([`Folds`]) exceeds a share g of the gain G of the fit. Both are
//! quadratic forms of the sums `[J C]ᵀ y` over the folds. For `y` an effect of size s in noise of unit variance, with a hat
//! what the effect makes of them at size one, c what the noise does, and `v_f` the gradient of `D − g G` by the sums of fold f,
//! of normal matrix `G_f`,
//!
//! ```text
//! E(D − g G) = s² (D̂ − g Ĝ) + c,    var(D − g G) ≈ s² Σ_f v_fᵀ G_f v_f.
//! ```
//!
//! Of an effect that one fold alone shows, as of a joint that turns round once, D̂ is below g Ĝ: the search takes it at no size.

use super::planned::Planned;
use super::signals::Signal;
use crate::diagnosis::selection::{Candidate, FoldBasis, Folds, columns_of, sum};
use crate::diagnosis::settings::SETTINGS;
use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, Normal};

/// The size from which on a candidate of this shape generalises to folds left out with the power asked for; infinite where none
/// does.
pub(super) fn generalises_from(planned: &Planned, candidate: &Candidate, shape: &[f64], signal: &Signal) -> f64 {
    let system = &planned.system;
    let columns = columns_of(planned.data, system, candidate, &[shape.to_vec()]);
    let folds = Folds::new(system, &columns);
    let sums = folds.sums(system, &columns, |stretch, joint| {
        signal.rows[stretch].iter().find(|r| r.0 == joint).map(|r| &r.1)
    });
    let all = sum(&sums);
    let mut excess = Form::zero(&sums);
    let share = SETTINGS.selection.least_generalisation;
    for (size, sign) in [(system.covariance.nrows(), 1.0), (all.len(), -1.0)] {
        let bases = folds.bases(size);
        bases
            .iter()
            .enumerate()
            .for_each(|(f, base)| excess.add_loss(sign, base, f, &sums, &all));
        excess.add_fit(sign * share, &bases[0], &all);
    }
    excess.positive_from(&folds)
}

/// A quadratic form of the sums of the folds.
struct Form {
    /// For an effect of size one.
    signal: f64,
    /// Its mean for noise alone.
    noise: f64,
    /// By the sums of each fold, at size one.
    gradient: Vec<DVector<f64>>,
}

impl Form {
    fn zero(sums: &[DVector<f64>]) -> Self {
        Self {
            signal: 0.0,
            noise: 0.0,
            gradient: sums.iter().map(|s| DVector::zeros(s.len())).collect(),
        }
    }

    /// What a fit without a fold loses on it: with w and v the sums of the rest and of the fold along directions that hold a
    /// share σ of their information in the fold, and variance d by the rest, `Σ d² σ w² − 2 d w v`.
    fn add_loss(&mut self, sign: f64, base: &FoldBasis, fold: usize, sums: &[DVector<f64>], all: &DVector<f64>) {
        let size = base.directions.nrows();
        let along = |r: &DVector<f64>| base.directions.tr_mul(&r.rows(0, size));
        let (v, w) = (along(&sums[fold]), along(&(all - &sums[fold])));
        let (mut by_w, mut by_v) = (DVector::zeros(w.len()), DVector::zeros(w.len()));
        for (i, (share, variance)) in base.outside().enumerate() {
            by_w[i] = 2.0 * variance * (variance * share * w[i] - v[i]);
            by_v[i] = -2.0 * variance * w[i];
            self.signal += sign * variance * w[i] * (variance * share * w[i] - 2.0 * v[i]);
            self.noise += sign * variance * share;
        }
        for (f, gradient) in self.gradient.iter_mut().enumerate() {
            let along = if f == fold { &by_v } else { &by_w };
            gradient.rows_mut(0, size).gemv(sign, &base.directions, along, 1.0);
        }
    }

    /// What a fit to all data gains: the square of the sums along directions of unit information.
    fn add_fit(&mut self, factor: f64, base: &FoldBasis, all: &DVector<f64>) {
        let size = base.directions.nrows();
        let along = base.directions.tr_mul(&all.rows(0, size));
        self.signal += factor * along.norm_squared();
        self.noise += factor * along.len() as f64;
        for gradient in &mut self.gradient {
            gradient.rows_mut(0, size).gemv(2.0 * factor, &base.directions, &along, 1.0);
        }
    }

    /// The size from which on it is positive with the power asked for.
    fn positive_from(&self, folds: &Folds) -> f64 {
        if self.signal <= 0.0 {
            return f64::INFINITY;
        }
        let square = |(v, normal): (&DVector<f64>, &nalgebra::DMatrix<f64>)| v.dot(&(normal * v));
        let variance: f64 = self.gradient.iter().zip(&folds.normal).map(square).sum();
        let z = Normal::standard().inverse_cdf(SETTINGS.detectable.power);
        let (linear, discriminant) = (z * variance.sqrt(), z * z * variance - 4.0 * self.signal * self.noise);
        if discriminant < 0.0 {
            return 0.0;
        }
        ((linear + discriminant.sqrt()) / (2.0 * self.signal)).max(0.0)
    }
}
