//! Two explanations of one residual, and how well a motion tells them apart.
//!
//! If effect A is what moves the arm, the log holds `C_A a` beside `Y_b π_b` and the other effects. A fit with its rival B in A's
//! place takes over what the columns of `Y_b`, of the other effects and of B can imitate; the rest stays as a weighted sum of
//! squares
//!
//! ```text
//! E_A = min_z ‖W (C_A a − R z)‖²,   R = [Y_b, others, C_B],   W = 1/σ_j
//! ```
//!
//! which is the expectation of twice the logarithm of the likelihood ratio between the two, up to the chance part that each
//! further free parameter takes off any residual (one per parameter). A parameter that columns are not linear in stands in R with
//! its derivative at its present value. The motion is as good as its worse direction: `min(E_A, E_B)`.
//!
//! An effect that is a special case of the other (an offset, of a spring with any rest angle) leaves nothing over if it is true,
//! whatever the motion: only parsimony then speaks against the other. Unless the other is a real thing within borders only (a
//! spring with its rest within a turn): then what counts is what the best of those at the border does not explain, since any
//! nearer to the special case is none. Where there are no borders that direction is left out of the minimum.

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// One of two explanations.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Its columns among the added ones.
    pub columns: Range<usize>,
    /// What stands on them if it is true: coefficients as found; zero on derivatives by shapes.
    pub values: Vec<f64>,
    /// Directions of its coefficients at the border of what is a real thing, where beyond it is the other one; none where the
    /// other is no limit of it.
    pub borders: Vec<Vec<f64>>,
}

/// Two explanations that exclude each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Rivals {
    /// The effect that was found.
    pub finding: Hypothesis,
    /// The effect that explains the same.
    pub rival: Hypothesis,
    /// `WᵀW` of the data that both came from, over all columns; `None` where it is not known.
    pub recorded: Option<DMatrix<f64>>,
    /// Whether finding, or rival, is a special case of the other. Found out by [`super::Problem::new`].
    pub nested: [bool; 2],
}

/// Evidence to be expected between two rivals: twice the logarithm of the odds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedEvidence {
    /// Expected evidence where the finding is true.
    pub if_finding: f64,
    /// Expected evidence where the rival is true.
    pub if_rival: f64,
    nested: [bool; 2],
    /// In which case a residual is possible.
    counts: [bool; 2],
}

/// Where a special case is true, tracing excludes what contains it at three standard deviations from the border.
const BEYOND_THE_BORDER: f64 = 9.0;

impl ExpectedEvidence {
    /// In the worse of the two cases, but for one in which no residual is possible.
    pub fn least(&self) -> f64 {
        let least = self.cases().map(|c| c.0).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    }

    /// Whether tracing will exclude the wrong one of the two, whichever it is: at `decisive`, or at three standard deviations
    /// where the true one is a special case of the other.
    pub fn decides(&self, decisive: f64) -> bool {
        let enough = |(evidence, nested): (f64, bool)| evidence >= if nested { BEYOND_THE_BORDER } else { decisive };
        self.counts != [false; 2] && self.cases().all(enough)
    }

    /// Evidence, and whether the true one is a special case of the other, of the cases that count.
    fn cases(&self) -> impl Iterator<Item = (f64, bool)> {
        let evidence = [self.if_finding, self.if_rival];
        let (nested, counts) = (self.nested, self.counts);
        (0..2).filter(move |&i| counts[i]).map(move |i| (evidence[i], nested[i]))
    }
}

/// What is left of an effect is nothing when it is less than this part of it: a ridge of 1e-12 and rounding of the Gram matrix
/// are less, and what is to be seen at all is more.
const NESTED: f64 = 1e-8;

/// Part of a scaled column's square that counts as rounding: exactly dependent columns need no share of the residual.
const RIDGE: f64 = 1e-12;
/// Evidence below which two effects are the same, for logarithms.
const NONE: f64 = 1e-30;

impl Rivals {
    /// From the Gram matrix over all columns, the first `base` of which are those of `Y_b`.
    pub(super) fn expected(&self, gram: &DMatrix<f64>, base: usize) -> ExpectedEvidence {
        let [if_finding, if_rival] = self.both(gram, base).map(|(evidence, _)| evidence);
        let alike = self.nested == [true, true];
        ExpectedEvidence {
            if_finding,
            if_rival,
            nested: self.nested,
            counts: [0, 1].map(|i| self.counts(i) && !alike),
        }
    }

    /// Whether a residual is possible if the finding (0) or the rival (1) is true; of two that are alike, whatever rounding
    /// leaves.
    fn counts(&self, i: usize) -> bool {
        let other = [&self.rival, &self.finding][i];
        !self.nested[i] || self.nested == [true, true] || !other.borders.is_empty()
    }

    /// Residual of either after a fit of the other, with the vectors of [`left_over`].
    fn both(&self, gram: &DMatrix<f64>, base: usize) -> [(f64, DVector<f64>); 2] {
        let pairs = [(&self.finding, &self.rival), (&self.rival, &self.finding)];
        [0, 1].map(|i| {
            let (of, other) = pairs[i];
            match self.nested[i] && self.nested != [true, true] {
                true => left_over_at_borders(gram, base, of, other),
                false => left_over(gram, base, of),
            }
        })
    }

    /// Which of the two leave nothing over on the motions with these Gram matrices.
    pub(super) fn nested_on(&self, grams: &[DMatrix<f64>], base: usize) -> [bool; 2] {
        [&self.finding, &self.rival].map(|of| {
            grams.iter().all(|gram| {
                let own = base + of.columns.start;
                let values = DVector::from_column_slice(&of.values);
                let all = gram.view((own, own), (values.len(), values.len())) * &values;
                left_over(gram, base, of).0 <= NESTED * all.dot(&values)
            })
        })
    }

    /// `−½ ln` of a soft minimum of the two, with its derivative G: `dF = tr(G dM)`.
    pub(super) fn smooth(&self, gram: &DMatrix<f64>, base: usize, power: f64) -> (f64, DMatrix<f64>) {
        let both = self.both(gram, base);
        let counts = |i: &usize| self.counts(*i);
        let least = [0, 1]
            .into_iter()
            .filter(counts)
            .map(|i| both[i].0.max(NONE))
            .fold(f64::INFINITY, f64::min);
        let shares = [0, 1].map(|i| {
            if counts(&i) {
                (least / both[i].0.max(NONE)).powf(power)
            } else {
                0.0
            }
        });
        let sum = shares[0] + shares[1];
        let mut slope = DMatrix::zeros(gram.nrows(), gram.ncols());
        for ((evidence, v), share) in both.iter().zip(shares) {
            slope.ger(-0.5 * share / (sum * evidence.max(NONE)), v, v, 1.0);
        }
        (0.5 * (sum.ln() / power - least.ln()), slope)
    }

    /// The logarithm of what is minimised, nothing smoothed.
    pub(super) fn true_log_value(&self, gram: &DMatrix<f64>, base: usize) -> f64 {
        -0.5 * self.expected(gram, base).least().max(NONE).ln()
    }
}

/// `min_z` of the quadratic form at `v = (values, −z)`, and that v: by the envelope theorem its derivative by M is `v vᵀ`.
fn left_over(gram: &DMatrix<f64>, base: usize, of: &Hypothesis) -> (f64, DVector<f64>) {
    let size = gram.nrows();
    let own = base + of.columns.start..base + of.columns.end;
    let mut v = DVector::zeros(size);
    own.clone().zip(&of.values).for_each(|(i, value)| v[i] = *value);
    let pull = gram * &v;
    let free: Vec<usize> = (0..size).filter(|i| !own.contains(i) && gram[(*i, *i)] > 0.0).collect();
    let scale: Vec<f64> = free.iter().map(|&i| gram[(i, i)].sqrt().recip()).collect();
    let right = DVector::from_fn(free.len(), |i, _| pull[free[i]] * scale[i]);
    let mut ridge = RIDGE;
    let solved = loop {
        let mut scaled = DMatrix::from_fn(free.len(), free.len(), |r, c| gram[(free[r], free[c])] * scale[r] * scale[c]);
        (0..free.len()).for_each(|i| scaled[(i, i)] += ridge);
        match scaled.cholesky() {
            Some(factor) => break factor.solve(&right),
            // Rounding made it indefinite: a unit matrix at the latest is not.
            None => ridge *= 100.0,
        }
    };
    free.iter()
        .zip(&scale)
        .zip(solved.iter())
        .for_each(|((&i, s), z)| v[i] = -s * z);
    ((gram * &v).dot(&v).max(0.0), v)
}

/// [`left_over`] where the other explanation stands at one of its borders, the one that leaves less; nothing where it has none.
fn left_over_at_borders(gram: &DMatrix<f64>, base: usize, of: &Hypothesis, other: &Hypothesis) -> (f64, DVector<f64>) {
    let size = gram.nrows();
    let at = |border: &Vec<f64>| {
        // The columns of the other become one: what stands on the border's direction.
        let mut map = DMatrix::identity(size, size);
        let first = base + other.columns.start;
        for i in base + other.columns.start..base + other.columns.end {
            map[(i, i)] = 0.0;
        }
        border.iter().enumerate().for_each(|(i, b)| map[(first + i, first)] = *b);
        let (left, v) = left_over(&(map.tr_mul(gram) * &map), base, of);
        (left, map * v)
    };
    let all = other.borders.iter().map(at);
    all.min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or_else(|| (0.0, DVector::zeros(size)))
}
