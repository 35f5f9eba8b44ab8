//! A contender fitted to some blocks of time and held against the others.

use super::blocks::{Blocks, Partial, residual};
use super::contender::Contender;
use crate::diagnosis::nonparametric::pursue;
use crate::regression::{SETTINGS as REGRESSION_SETTINGS, System, jackknife_sum, persistence, reduce, transposed_product};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A contender's coefficients beside the model, and the change of the model's coordinates.
pub(crate) struct Beside {
    pub coefficients: DVector<f64>,
    change: DVector<f64>,
}

/// The columns of a contender that pay their price.
pub(crate) struct Pursued {
    pub chosen: Vec<usize>,
    /// Coefficients of all columns, zero where not chosen.
    pub beside: Beside,
    /// Decrease of the sum of squares, and what is left of it beyond the price.
    pub gain: f64,
    pub evidence: f64,
}

/// A contender held against every block in turn.
pub(crate) struct Validated {
    /// Decrease of the sum of squares by the fit to all blocks.
    pub gain: f64,
    /// Directions of the columns that the model does not hide.
    pub rank: usize,
    /// Per block: decrease of its sum of squares, by fits to all others.
    pub gains: Vec<f64>,
    /// Coefficients of the fit to all blocks.
    pub coefficients: DVector<f64>,
    /// Covariance of the coefficients by the jackknife over the blocks.
    pub covariance: DMatrix<f64>,
}

impl Validated {
    /// Gain over all blocks left out.
    pub fn held_out(&self) -> f64 {
        self.gains.iter().sum()
    }

    /// Standard deviation of [`held_out`](Self::held_out) by the scatter of the blocks.
    pub fn deviation(&self) -> f64 {
        deviation_of_sum(&self.gains)
    }
}

/// Standard deviation of a sum by the scatter of its terms.
pub(crate) fn deviation_of_sum(terms: &[f64]) -> f64 {
    let count = terms.len() as f64;
    let mean = terms.iter().sum::<f64>() / count;
    let scatter: f64 = terms.iter().map(|t| (t - mean).powi(2)).sum();
    (scatter * count / (count - 1.0).max(1.0)).sqrt()
}

impl Contender<'_> {
    /// The contender fitted beside the model to all blocks but these.
    pub fn beside(&self, blocks: &Blocks, partial: &Partial, left_out: &[usize]) -> (Beside, f64, usize) {
        let (through, rest, open) = self.projected(blocks, partial, left_out);
        let reduced = reduce(&self.whole, &rest, &open);
        let change = &partial.change - through * &reduced.coefficients;
        let beside = Beside {
            coefficients: reduced.coefficients,
            change,
        };
        (beside, reduced.gain, reduced.rank)
    }

    /// The columns that pay `price` each, one after the other, fitted to all blocks but these.
    pub fn pursued(&self, blocks: &Blocks, partial: &Partial, left_out: &[usize], price: f64) -> Pursued {
        let (through, rest, open) = self.projected(blocks, partial, left_out);
        let (chosen, gain, found) = pursue(&self.whole, &rest, &open, price);
        let mut coefficients = DVector::zeros(open.len());
        chosen
            .iter()
            .zip(found.iter())
            .for_each(|(&k, value)| coefficients[k] = *value);
        let change = &partial.change - through * &coefficients;
        Pursued {
            evidence: gain - price * chosen.len() as f64,
            beside: Beside { coefficients, change },
            chosen,
            gain,
        }
    }

    /// Normal equations of the columns beside the model, fitted to all blocks but these: what a unit of each column changes of
    /// the model, the matrix, and the right-hand side.
    fn projected(&self, blocks: &Blocks, partial: &Partial, left_out: &[usize]) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let sum = |parts: &[DMatrix<f64>]| {
            let mut all = DMatrix::zeros(parts[0].nrows(), parts[0].ncols());
            (0..parts.len())
                .filter(|b| !left_out.contains(b))
                .for_each(|b| all += &parts[b]);
            all
        };
        let cross = sum(&self.cross);
        let own = sum(&self.own);
        let right = (0..blocks.times.len())
            .filter(|b| !left_out.contains(b))
            .fold(DVector::zeros(own.nrows()), |all, b| all + &self.right[b]);
        let through = partial.solve(&cross);
        let rest = own + &self.open * REGRESSION_SETTINGS.jackknife_ridge - transposed_product(&cross, &through);
        let open = right - cross.tr_mul(&partial.change);
        (through, rest, open)
    }

    /// Change of the sum of squares of block `b` from the fit to all of it without the contender to `beside`.
    fn cost_on(&self, blocks: &Blocks, b: usize, beside: &Beside) -> f64 {
        let (z, x) = (&beside.change, &beside.coefficients);
        let model = (z.transpose() * &blocks.inside[b] * z)[0] - 2.0 * z.dot(&blocks.gradient[b]);
        let own = (x.transpose() * &self.own[b] * x)[0] - 2.0 * x.dot(&self.right[b]);
        model + own + 2.0 * (z.transpose() * &self.cross[b] * x)[0]
    }

    /// Decrease of the sum of squares of block `b` by the contender.
    pub fn gain_on(&self, blocks: &Blocks, partial: &Partial, b: usize, beside: &Beside) -> f64 {
        let z = &partial.change;
        let before = (z.transpose() * &blocks.inside[b] * z)[0] - 2.0 * z.dot(&blocks.gradient[b]);
        before - self.cost_on(blocks, b, beside)
    }

    /// Every block predicted by fits to all others, with and without the contender.
    pub fn validated(&self, blocks: &Blocks, folds: &[Partial], all: &Partial) -> Validated {
        let (full, gain, rank) = self.beside(blocks, all, &[]);
        let fold = |(b, partial): (usize, &Partial)| {
            let (beside, _, _) = self.beside(blocks, partial, &[b]);
            (self.gain_on(blocks, partial, b, &beside), beside.coefficients)
        };
        let (gains, coefficients): (Vec<f64>, Vec<DVector<f64>>) = folds.iter().enumerate().map(fold).unzip();
        Validated {
            gain,
            rank,
            gains,
            covariance: jackknife_sum(&coefficients),
            coefficients: full.coefficients,
        }
    }

    /// Whitened residual of a block and joint where the contender is in the model.
    fn left(&self, system: &System, blocks: &Blocks, [b, j]: [usize; 2], beside: &Beside) -> DVector<f64> {
        let time = &blocks.times[b];
        let change = &beside.change - &self.along * &beside.coefficients;
        let mut left = residual(system, time, j) - &blocks.rows[b][j] * change;
        if let Some((_, m)) = self.columns[time.stretch].iter().find(|(own, _)| *own == j) {
            left -= m.rows(time.rows.start, time.rows.len()) * &beside.coefficients;
        }
        left
    }

    /// Rows over which the residual of a joint keeps its sign where the contender is in the model.
    pub fn persistence(&self, system: &System, blocks: &Blocks, joint: usize, beside: &Beside) -> f64 {
        let mut stretches = vec![Vec::new(); system.blocks.len()];
        for (b, time) in blocks.times.iter().enumerate() {
            let left = self.left(system, blocks, [b, joint], beside);
            stretches[time.stretch].extend_from_slice(left.as_slice());
        }
        persistence(stretches.iter().map(Vec::as_slice))
    }

    /// Gains of every joint on the blocks left out, one list per joint.
    pub fn gains_by_joint(&self, system: &System, blocks: &Blocks, folds: &[Partial]) -> Vec<Vec<f64>> {
        let joints = system.model.robot.joint_count();
        let of = |(b, partial): (usize, &Partial)| -> Vec<f64> {
            let (beside, _, _) = self.beside(blocks, partial, &[b]);
            let gain = |j: usize| {
                let before = residual(system, &blocks.times[b], j) - &blocks.rows[b][j] * &partial.change;
                before.norm_squared() - self.left(system, blocks, [b, j], &beside).norm_squared()
            };
            (0..joints).map(gain).collect()
        };
        let by_fold: Vec<Vec<f64>> = folds.par_iter().enumerate().map(of).collect();
        (0..joints).map(|j| by_fold.iter().map(|gains| gains[j]).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_sum_deviates_by_the_scatter_of_its_terms() {
        assert_eq!(deviation_of_sum(&[2.0; 7]), 0.0);
        // Four terms at one and minus one: variance 4/3 each, of the sum four times that.
        let deviation = deviation_of_sum(&[1.0, -1.0, 1.0, -1.0]);
        assert!((deviation - (16.0f64 / 3.0).sqrt()).abs() < 1e-12, "{deviation}");
    }

    /// Estimates without each of n blocks of a mean differ by 1/(n − 1) of what the blocks differ by.
    #[test]
    fn prop_the_jackknife_of_a_mean_is_its_variance() {
        let blocks = [1.0, 4.0, 2.0, 7.0, 3.0];
        let n = blocks.len() as f64;
        let sum: f64 = blocks.iter().sum();
        let without: Vec<DVector<f64>> = blocks
            .iter()
            .map(|b| DVector::from_element(1, (sum - b) / (n - 1.0)))
            .collect();
        let mean = sum / n;
        let variance = blocks.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        assert!((jackknife_sum(&without)[0] - variance).abs() < 1e-12);
    }
}
