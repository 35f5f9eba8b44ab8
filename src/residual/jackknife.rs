//! Blocks of time left out of a fit, in turn: what the parameters become without them, and how uncertain they are by that.
//!
//! Where a residual is more than noise its rows are no independent witnesses, and the textbook's covariance is too small by a factor of several. The
//! delete-one jackknife over contiguous blocks (Künsch 1989; Shao & Wu 1989) needs no model of the misfit: blocks that are long beside its memory
//! are independent, and what a fit without one of them says otherwise is what that block contributed by chance.

use super::product::transposed_product;
use super::projection::{RANK, pseudo_root};
use super::system::{Data, System};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Blocks over all logs. On the measured logs estimates from two halves differ by 0.9 to 1.4 of their deviations with sixteen, and a standard
/// deviation from sixteen values is itself known to a fifth.
pub(super) const BLOCKS: usize = 16;

/// Directions of which one block holds more than nine tenths of all information would be extrapolated from the others, with more than three times their
/// noise: the step is bounded there.
const LEAST_OUTSIDE: f64 = 0.1;

/// One contiguous block of rows of one stretch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TimeBlock {
    pub stretch: usize,
    pub rows: Range<usize>,
}

/// Blocks of about equal length that cover `rows` rows of every stretch, [`BLOCKS`] in all and at least one to a stretch.
pub(super) fn time_blocks(rows: &[usize]) -> Vec<TimeBlock> {
    let total: usize = rows.iter().sum();
    let of = |(stretch, &count): (usize, &usize)| {
        let parts = ((BLOCKS * count) as f64 / total.max(1) as f64).round().max(1.0) as usize;
        (0..parts).map(move |b| TimeBlock {
            stretch,
            rows: b * count / parts..(b + 1) * count / parts,
        })
    };
    rows.iter().enumerate().flat_map(of).collect()
}

/// Normal matrix and gradient of one block.
struct Part {
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
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

/// Blocks of a system, and for each the change of the parameters when it is left out of the (linearised) fit.
pub(super) fn left_out(data: &Data, system: &System) -> Vec<(TimeBlock, DVector<f64>)> {
    let rows: Vec<usize> = system.blocks.iter().map(|b| b[0].residual.len()).collect();
    let root = pseudo_root(&data.normal(system), RANK);
    let of = |block: TimeBlock| {
        // Rows that say nothing of any parameter change none.
        if root.ncols() == 0 {
            return (block, DVector::zeros(root.nrows()));
        }
        let Part { normal, gradient } = part(system, &block);
        let inside = (root.tr_mul(&(&normal * &root))).symmetric_eigen();
        // All rows together leave the gradient zero: without the block it is minus the block's own.
        let along = inside.eigenvectors.tr_mul(&root.tr_mul(&gradient));
        let step = DVector::from_fn(along.len(), |i, _| {
            -along[i] / (1.0 - inside.eigenvalues[i]).max(LEAST_OUTSIDE)
        });
        let change = &root * (&inside.eigenvectors * step);
        (block, change)
    };
    time_blocks(&rows).into_iter().map(of).collect()
}

/// Covariance of the parameters from what they become without each block: `(B − 1)/B Σ (θᵦ − θ̄)(θᵦ − θ̄)ᵀ`.
pub(super) fn jackknife_covariance(data: &Data, system: &System) -> DMatrix<f64> {
    let changes = left_out(data, system);
    let (p, count) = (system.covariance.nrows(), changes.len() as f64);
    let mean = changes.iter().fold(DVector::zeros(p), |sum, (_, c)| sum + c) / count;
    let sum = changes.iter().fold(DMatrix::zeros(p, p), |sum, (_, c)| {
        let off = c - &mean;
        sum + &off * off.transpose()
    });
    sum * ((count - 1.0) / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_blocks_cover_every_row_once() {
        for rows in [vec![1000], vec![7], vec![900, 100, 4000], vec![3, 100_000]] {
            let blocks = time_blocks(&rows);
            for (stretch, &count) in rows.iter().enumerate() {
                let own: Vec<_> = blocks
                    .iter()
                    .filter(|b| b.stretch == stretch)
                    .map(|b| b.rows.clone())
                    .collect();
                assert_eq!((own[0].start, own.last().unwrap().end), (0, count));
                assert!(own.windows(2).all(|w| w[0].end == w[1].start));
            }
            assert!(blocks.len() >= rows.len() && blocks.len() <= BLOCKS + rows.len());
        }
    }
}
