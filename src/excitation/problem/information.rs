//! The observation matrix of a motion, its information, and what is known before.

use super::{Criterion, Given, Problem};
use crate::dynamics::{ColumnSet, Coulomb, Motion, RowBlocks};
use crate::excitation::added::Course;
use crate::excitation::criterion::is_finite;
use crate::excitation::moves::{random_numbers, random_start};
use crate::excitation::variables::Variables;
use crate::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;

impl Problem {
    /// What the search adds to the information of a motion; `None` where nothing is.
    ///
    /// Between rivals it is what is known of all other parameters: else the best motion could be one that tells them apart only
    /// beside the data so far, and whatever changed between the two recordings would pass for one of them.
    pub(in super::super) fn known_before(&self) -> Option<DMatrix<f64>> {
        match self.spec.criterion {
            Criterion::RivalEvidence => self.given.is_some().then(|| self.given_of_others()),
            _ => self.given.clone(),
        }
    }

    /// What is given with the two rivals taken out by their Schur complement; zero where nothing is given.
    pub(in super::super) fn given_of_others(&self) -> DMatrix<f64> {
        let size = self.columns();
        let mut left = DMatrix::zeros(size, size);
        let (Some(given), Some(rivals)) = (&self.given, &self.spec.knowledge.rivals) else {
            return left;
        };
        let base = self.base.len();
        let of_rivals = |c: &usize| {
            *c >= base && (rivals.finding.columns.contains(&(c - base)) || rivals.rival.columns.contains(&(c - base)))
        };
        let (two, others): (Vec<usize>, Vec<usize>) = (0..size).partition(of_rivals);
        let part = |rows: &[usize], columns: &[usize]| given.select_rows(rows).select_columns(columns);
        let cross = part(&others, &two);
        let inverse = pseudo_inverse(&part(&two, &two));
        let rest = part(&others, &others) - &cross * inverse * cross.transpose();
        for (r, &row) in others.iter().enumerate() {
            others
                .iter()
                .enumerate()
                .for_each(|(c, &column)| left[(row, column)] = rest[(r, c)]);
        }
        left
    }

    /// `WᵀW` of all that is known already; `None` where nothing is.
    pub(in super::super) fn given(&self) -> Option<&DMatrix<f64>> {
        self.given.as_ref()
    }

    /// Whether one rival is a special case of the other: it leaves no residual on any motion, two random ones for example.
    pub(super) fn look_for_nesting(&mut self) {
        let Some(rivals) = &self.spec.knowledge.rivals else { return };
        let variables = Variables::new(self);
        let series = (0..2).map(|index| variables.series(&random_start(&variables, &mut random_numbers(0, 0, index))));
        let grams: Vec<DMatrix<f64>> = series.map(|s| self.information_of(&s)).collect();
        let nested = rivals.nested_on(&grams, self.base.len());
        if let Some(rivals) = &mut self.spec.knowledge.rivals {
            rivals.nested = nested;
        }
    }

    pub(super) fn sum_of_given(&self) -> Option<DMatrix<f64>> {
        let information = |given: &Given| match given {
            Given::Motion { series, periods } => self.information_of(series) * *periods,
            Given::Information(matrix) => matrix.clone(),
        };
        self.spec.knowledge.given.iter().map(information).reduce(|a, b| a + b)
    }

    /// `[Y_b, C]` along a motion with the true sign, so many samples at a time; rows go joint by joint within a sample.
    fn for_rows(&self, motion: &Motion, interval: f64, periodic: bool, mut each: impl FnMut(DMatrix<f64>)) {
        let columns = ColumnSet::new(&self.spec.robot, &self.layout, &self.base.kept);
        let (joints, base, samples) = (motion.joints(), self.base.len(), motion.samples());
        let course = Course {
            motion,
            interval,
            periodic,
            coulomb: Coulomb::Sign,
        };
        let added = self.spec.knowledge.added.as_ref().map_or_else(Vec::new, |a| a.along(&course));
        let length = (BLOCK_NUMBERS / (joints * self.columns().max(1))).max(1).min(samples.max(1));
        let (mut part, mut rows) = (Motion::zeros(joints, length), RowBlocks::new(&columns, length));
        for first in (0..samples).step_by(length) {
            let count = length.min(samples - first);
            part.copy_part(motion, first, count);
            rows.shorten(count);
            rows.fill(&self.chain, &columns, &part, Coulomb::Sign);
            let mut all = rows.observation_matrix(&columns).resize_horizontally(self.columns(), 0.0);
            for column in &added {
                for (j, values) in &column.rows {
                    let values = values[first..first + count].iter().enumerate();
                    values.for_each(|(s, v)| all[(s * joints + j, base + column.at)] = *v);
                }
            }
            each(all);
        }
    }

    /// Sum of `yᵀy` over the rows y of `[Y_b, C]` along any motion.
    pub(in super::super) fn gram_along(&self, motion: &Motion, interval: f64, periodic: bool) -> DMatrix<f64> {
        let mut total = DMatrix::zeros(self.columns(), self.columns());
        self.for_rows(motion, interval, periodic, |y| total += y.tr_mul(&y));
        total
    }

    /// Triangular factors of `[Y_b, C]` of one period on the asked samples, and of the same with every row over the noise of its
    /// joint: what is a matter of lengths and angles of columns is that of the factor, which has as many rows as columns.
    pub(in super::super) fn factors(&self, series: &FourierSeries) -> [DMatrix<f64>; 2] {
        let mut factors = [(); 2].map(|()| DMatrix::zeros(self.columns(), self.columns()));
        self.for_period(series, |y, whitened| {
            factors[0] = factor_of(&factors[0], &y);
            factors[1] = factor_of(&factors[1], &whitened);
        });
        factors
    }

    /// The rows of one period on the asked samples, as they are and over the noise of their joint.
    fn for_period(&self, series: &FourierSeries, mut each: impl FnMut(DMatrix<f64>, DMatrix<f64>)) {
        let noise = self.torque_noise();
        let rate = self.spec.sample_rate_hz;
        self.for_rows(&series.sample(rate), 1.0 / rate, true, |y| {
            let mut whitened = y.clone();
            for (r, mut row) in whitened.row_iter_mut().enumerate() {
                row /= noise[r % noise.len()];
            }
            each(y, whitened);
        });
    }

    /// `WᵀW` of one period of a series, every row over the noise of its joint.
    pub(in super::super) fn information_of(&self, series: &FourierSeries) -> DMatrix<f64> {
        let mut total = DMatrix::zeros(self.columns(), self.columns());
        self.for_period(series, |_, w| total += w.tr_mul(&w));
        total
    }
}

/// Numbers of an observation matrix that are held at a time, 2 MB: several times as many rows as columns, up to thirty joints.
const BLOCK_NUMBERS: usize = 250_000;

/// R of `[upper; lower]`, square; where a decomposition would not end, what is not finite stays in sight.
fn factor_of(upper: &DMatrix<f64>, lower: &DMatrix<f64>) -> DMatrix<f64> {
    let size = upper.ncols();
    if !is_finite(upper) || !is_finite(lower) {
        return DMatrix::from_element(size, size, f64::NAN);
    }
    let mut both = upper.clone().resize_vertically(size + lower.nrows(), 0.0);
    both.rows_mut(size, lower.nrows()).copy_from(lower);
    both.qr().r()
}

/// Of a positive semidefinite matrix scaled to a unit diagonal; directions below 1e-10 of the largest are those in which rivals
/// are the same.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)] * scale[r] * scale[c]);
    // Decompositions do not end on what is not finite.
    if !is_finite(&scaled) {
        return DMatrix::zeros(matrix.nrows(), matrix.ncols());
    }
    let eigen = scaled.symmetric_eigen();
    let least = 1e-10 * eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|v| if v > least { 1.0 / v } else { 0.0 });
    let mut out = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
    for r in 0..out.nrows() {
        (0..out.ncols()).for_each(|c| out[(r, c)] *= scale[r] * scale[c]);
    }
    out
}
