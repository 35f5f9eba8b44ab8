//! The rows of a motion, a block of samples at a time: a design at the limits of the documents has rows of hundreds of megabytes.

use crate::dynamics::{Chain, ColumnSet, Coulomb, LANES, Motion, MotionGradient, RowBlocks};

/// So many samples in a row: their motion, rows, weights and gradient.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Samples of the whole motion.
    samples: usize,
    /// Samples of every block but the last.
    length: usize,
    /// The block that `rows` is of.
    pub filled: Option<usize>,
    pub motion: Motion,
    pub rows: RowBlocks,
    pub weights: RowBlocks,
    pub gradient: MotionGradient,
}

impl Block {
    /// Blocks of about `numbers` numbers in their rows; one where that is enough for all samples.
    pub fn new(columns: &ColumnSet, samples: usize, numbers: usize) -> Self {
        let joints = columns.joints();
        let per_sample: usize = (0..joints).map(|j| columns.row(j).len()).sum();
        let most = (numbers / per_sample.max(1)).max(LANES);
        // Blocks of equal length: the last is hardly shorter than the others.
        let length = samples
            .div_ceil(samples.div_ceil(most).max(1))
            .next_multiple_of(LANES)
            .min(samples);
        let rows = RowBlocks::new(columns, length);
        Self {
            samples,
            length,
            filled: None,
            motion: Motion::zeros(joints, length),
            weights: rows.clone(),
            rows,
            gradient: MotionGradient::new(joints, length),
        }
    }

    pub fn count(&self) -> usize {
        self.samples.div_ceil(self.length)
    }

    /// Samples from one joint, or one column, to the next.
    pub fn stride(&self) -> usize {
        self.rows.stride()
    }

    /// Sample of the motion that the filled block begins with.
    pub fn first(&self) -> usize {
        self.filled.unwrap_or(0) * self.length
    }

    /// Samples of the filled block.
    pub fn samples(&self) -> usize {
        self.rows.samples()
    }

    /// Computes the rows of the block at `index`.
    pub fn fill(&mut self, index: usize, chain: &Chain, columns: &ColumnSet, motion: &Motion, coulomb: Coulomb) {
        let first = index * self.length;
        let samples = self.length.min(self.samples - first);
        self.motion.copy_part(motion, first, samples);
        self.rows.shorten(samples);
        self.rows.fill(chain, columns, &self.motion, coulomb);
        self.filled = Some(index);
    }
}
