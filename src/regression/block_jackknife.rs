//! Blocks of time left out of a fit, in turn: what the parameters become without them, and how uncertain they are by that.
//!
//! Where a residual is more than noise its rows are no independent witnesses, and the textbook's covariance is too small by a
//! factor of several. The delete-one jackknife over contiguous blocks (Künsch 1989; Shao & Wu 1989) needs no model of the misfit:
//! blocks that are long beside its memory are independent, and what a fit without one of them says otherwise is what that block
//! contributed by chance.

use super::normal_equations::{Data, Part, System};
use super::product::transposed_product;
use super::rank::pseudo_root;
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// One contiguous block of rows of one stretch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TimeBlock {
    pub stretch: usize,
    pub rows: Range<usize>,
}

/// Blocks of about equal length that cover `rows` rows of every stretch, `blocks` in all and at least one to a stretch.
pub(crate) fn time_blocks(rows: &[usize], blocks: usize) -> Vec<TimeBlock> {
    let total: usize = rows.iter().sum();
    let of = |(stretch, &count): (usize, &usize)| {
        let parts = ((blocks * count) as f64 / total.max(1) as f64).round().max(1.0) as usize;
        (0..parts).map(move |b| TimeBlock {
            stretch,
            rows: b * count / parts..(b + 1) * count / parts,
        })
    };
    rows.iter().enumerate().flat_map(of).collect()
}

fn part(system: &System, block: &TimeBlock) -> Part {
    let p = system.covariance.nrows();
    let mut part = Part {
        normal: DMatrix::zeros(p, p),
        gradient: DVector::zeros(p),
    };
    for joint in &system.blocks[block.stretch] {
        let rows = joint.jacobian.rows(block.rows.start, block.rows.len()).into_owned();
        part.normal += transposed_product(&rows, &rows);
        part.gradient += rows.tr_mul(&joint.residual.rows(block.rows.start, block.rows.len()));
    }
    part
}

impl System {
    /// The blocks of time that the jackknife leaves out, and what each contributes: the same for every parameter.
    fn parts(&self) -> (Vec<TimeBlock>, &[Part]) {
        let rows: Vec<usize> = self.blocks.iter().map(|b| b[0].residual.len()).collect();
        let blocks = time_blocks(&rows, SETTINGS.jackknife_blocks);
        let parts = self.parts.get(|| blocks.par_iter().map(|b| part(self, b)).collect());
        (blocks, parts)
    }
}

/// Blocks of a system, and for each the change of the parameters when it is left out of the (linearised) fit.
pub(crate) fn left_out(data: &Data, system: &System) -> Vec<(TimeBlock, DVector<f64>)> {
    let root = pseudo_root(&data.normal(system), SETTINGS.rank_tolerance);
    let of = |(block, Part { normal, gradient }): (TimeBlock, &Part)| {
        // Rows that say nothing of any parameter change none.
        if root.ncols() == 0 {
            return (block, DVector::zeros(root.nrows()));
        }
        let inside = (root.tr_mul(&(normal * &root))).symmetric_eigen();
        // All rows together leave the gradient zero: without the block it is minus the block's own.
        let along = inside.eigenvectors.tr_mul(&root.tr_mul(gradient));
        let step = DVector::from_fn(along.len(), |i, _| {
            -along[i] / (1.0 - inside.eigenvalues[i]).max(SETTINGS.jackknife_least_outside)
        });
        let change = &root * (&inside.eigenvectors * step);
        (block, change)
    };
    let (blocks, parts) = system.parts();
    blocks.into_par_iter().zip(parts).map(of).collect()
}

/// Covariance of the parameters from what they become without each block: `(B − 1)/B Σ (θᵦ − θ̄)(θᵦ − θ̄)ᵀ`.
pub(crate) fn jackknife_covariance(data: &Data, system: &System) -> DMatrix<f64> {
    let changes: Vec<DVector<f64>> = left_out(data, system).into_iter().map(|(_, change)| change).collect();
    jackknife_sum(&changes)
}

/// `(B − 1)/B Σ (θᵦ − θ̄)(θᵦ − θ̄)ᵀ` over the values (or their changes) without each of B blocks.
pub(crate) fn jackknife_sum(values: &[DVector<f64>]) -> DMatrix<f64> {
    let (count, p) = (values.len() as f64, values[0].len());
    let mean = values.iter().fold(DVector::zeros(p), |sum, v| sum + v) / count;
    let sum = values.iter().fold(DMatrix::zeros(p, p), |sum, v| {
        let off = v - &mean;
        sum + &off * off.transpose()
    });
    sum * ((count - 1.0) / count)
}

impl System {
    /// Covariance of term `at` by the jackknife: each block of time is left out in turn. Without block b the linearised fit moves
    /// by `−(G − G_b)⁻¹ g_b`, which is `−C (1 − G_b C)⁻¹ g_b` with the covariance C of all.
    pub fn jackknife(&self, at: usize) -> DMatrix<f64> {
        let (from, k) = (self.model.offset_of(at), self.model.terms[at].parameters());
        let p = self.covariance.nrows();
        let without = |Part { normal, gradient }: &Part| {
            // What this block determines nearly alone is not extrapolated from the others without bound.
            let others = DMatrix::identity(p, p) * (1.0 + SETTINGS.jackknife_ridge) - normal * &self.covariance;
            let pull = others.lu().solve(gradient).unwrap_or_else(|| gradient.clone());
            -(&self.covariance * pull).rows(from, k).into_owned()
        };
        let moved: Vec<DVector<f64>> = self.parts().1.par_iter().map(without).collect();
        self.no_less_than_independent(at, &jackknife_sum(&moved))
    }

    /// `robust`, no deviation smaller than independent rows of what is left would give.
    fn no_less_than_independent(&self, at: usize, robust: &DMatrix<f64>) -> DMatrix<f64> {
        let k = robust.nrows();
        let joints = (0..self.model.robot.joint_count()).collect::<Vec<_>>();
        let reached = if self.model.terms[at].joints.is_empty() {
            &joints
        } else {
            &self.model.terms[at].joints
        };
        let plain = self.term_covariance(at) * self.mean_square(reached).max(1e-300);
        let grow = |i: usize| (plain[(i, i)] / robust[(i, i)].max(f64::MIN_POSITIVE)).max(1.0).sqrt();
        DMatrix::from_fn(k, k, |r, c| robust[(r, c)] * grow(r) * grow(c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_blocks_cover_every_row_once() {
        for rows in [vec![1000], vec![7], vec![900, 100, 4000], vec![3, 100_000]] {
            let blocks = time_blocks(&rows, SETTINGS.jackknife_blocks);
            for (stretch, &count) in rows.iter().enumerate() {
                let own: Vec<_> = blocks
                    .iter()
                    .filter(|b| b.stretch == stretch)
                    .map(|b| b.rows.clone())
                    .collect();
                assert_eq!((own[0].start, own.last().unwrap().end), (0, count));
                assert!(own.windows(2).all(|w| w[0].end == w[1].start));
            }
            assert!(blocks.len() >= rows.len() && blocks.len() <= SETTINGS.jackknife_blocks + rows.len());
        }
    }
}
