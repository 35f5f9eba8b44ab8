//! Rows of W of a long log, made when they are needed.

use super::PreparedLog;
use super::filter::{Padding, zero_phase};
use super::preprocess::RowFilter;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Makes any rows of a log that does not repeat from its motion alone.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RowMaker {
    chain: Chain,
    set: ColumnSet,
    motion: Arc<Motion>,
    filter: RowFilter,
}

/// Doubles of unfiltered columns in a block (32 MB).
const BLOCK: usize = 4 << 20;
/// Settling times beyond a block's ends that are filtered with it. Each is a factor of a thousand: what a filter remembers of the cut is then
/// below the rounding of what it passes.
const HALO: usize = 6;

impl RowMaker {
    pub fn new(robot: &Robot, set: ColumnSet, log: &PreparedLog) -> Self {
        Self {
            chain: Chain::new(robot),
            set,
            motion: log.motion.clone(),
            filter: log.row_filter.clone(),
        }
    }

    fn halo(&self) -> usize {
        self.filter.columns.as_ref().map_or(0, |f| HALO * f.settling_samples())
    }

    /// Rows in a block of a log of `rows`: no fewer than what the halo is worth four times over, and than noise is correlated over
    /// ([`super::NoiseSpectrum::from_residual`]).
    pub fn rows_per_block(&self, rows: usize) -> usize {
        let width: usize = (0..self.set.joints()).map(|j| self.set.row(j).len()).sum();
        let samples = (BLOCK / width.max(1)).max(4 * self.halo());
        let correlated = (2.0 * (rows as f64).sqrt()).ceil() as usize;
        (samples / self.filter.decimation).max(correlated).max(1)
    }

    /// W at the given samples, which ascend: one matrix per joint.
    pub fn rows(&self, samples: &[usize]) -> Vec<DMatrix<f64>> {
        let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else {
            return (0..self.set.joints())
                .map(|j| DMatrix::zeros(0, self.set.row(j).len()))
                .collect();
        };
        let from = first.saturating_sub(self.halo());
        let to = (last + self.halo() + 1).min(self.motion.samples());
        let part = Motion::from_fn(self.motion.joints(), to - from, |j, s| self.motion.get(j, from + s));
        let mut blocks = RowBlocks::new(&self.set, to - from);
        blocks.fill(&self.chain, &self.set, &part, Coulomb::Sign);
        let joint = |j: usize| {
            let columns = blocks.block(j).chunks_exact(blocks.stride());
            let data = columns.flat_map(|column| {
                let column = self.filtered(&column[..to - from]);
                samples.iter().map(move |&s| column[s - from])
            });
            DMatrix::from_iterator(samples.len(), self.set.row(j).len(), data)
        };
        (0..self.set.joints()).map(joint).collect()
    }

    fn filtered(&self, column: &[f64]) -> Vec<f64> {
        match &self.filter.columns {
            Some(filter) => zero_phase(filter, column, Padding::Odd, filter.settling_samples()),
            None => column.to_vec(),
        }
    }
}
