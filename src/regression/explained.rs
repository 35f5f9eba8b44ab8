//! Does a model explain more of the torque than a constant per joint does?
//!
//! Held-out data decide: of a log with periods one half of them predicts the other, of one without each fifth of its rows is
//! predicted from the rest. In-sample fits of noise explain as much as they have parameters; out of sample they explain nothing,
//! whatever the noise's correlation in time.

use super::dataset::Stretch;
use super::joint_normal::JointNormal;
use super::model::AugmentedModel;
use super::product::transposed_product;
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Normal equations per joint: the model's columns, and behind them the joint's constant.
pub(crate) type Part = Vec<JointNormal>;

/// Rows to fit and rows to predict.
pub(crate) struct Fold {
    pub train: Part,
    pub test: Part,
}

/// Shares of the torque's variance about a constant that a model explains, on held-out data.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// Per joint, at most 1 and below 0 where the constant predicts better; `None` for a joint without rows.
    pub joints: Vec<Option<f64>>,
}

impl Explained {
    /// Mean over the joints that have rows; 0 where there is none.
    pub fn mean(&self) -> f64 {
        let known: Vec<f64> = self.joints.iter().flatten().map(|s| s.max(-1.0)).collect();
        known.iter().sum::<f64>() / known.len().max(1) as f64
    }

    /// Whether the model explains more than a constant per joint.
    pub fn is_more_than_a_constant(&self) -> bool {
        self.mean() >= SETTINGS.least_explained
    }
}

/// What `part` makes of each of the folds of so many rows.
fn segments(rows: usize, part: impl Fn(Range<usize>) -> Part) -> Vec<Part> {
    let count = SETTINGS.explained_folds * SETTINGS.explained_stretches;
    let stretch = |k: usize| part(k * rows / count..(k + 1) * rows / count);
    let fold = |k: usize| {
        let further = (1..SETTINGS.explained_stretches).map(|i| stretch(k + i * SETTINGS.explained_folds));
        further.fold(stretch(k), |sum, more| combined(&sum, &more, 1.0))
    };
    (0..SETTINGS.explained_folds).map(fold).collect()
}

/// Folds of rows that follow each other in time: each fifth of them is predicted from the others.
pub(crate) fn folds_in_time(rows: usize, part: impl Fn(Range<usize>) -> Part) -> Vec<Fold> {
    let parts = segments(rows, part);
    let whole = parts[1..]
        .iter()
        .fold(parts[0].clone(), |sum, part| combined(&sum, part, 1.0));
    let fold = |test: Part| Fold {
        train: combined(&whole, &test, -1.0),
        test,
    };
    parts.into_iter().map(fold).collect()
}

/// Each half predicted from the other.
pub(crate) fn folds_both_ways(one: Part, other: Part) -> Vec<Fold> {
    let there = Fold {
        train: one.clone(),
        test: other.clone(),
    };
    vec![there, Fold { train: other, test: one }]
}

/// Normal equations of rows of which `used` are not zero, the constant's behind them; `columns` are the model's, and last the
/// constant's.
pub(crate) fn with_constant(matrix: &DMatrix<f64>, torque: &[f64], used: usize, columns: Vec<usize>) -> JointNormal {
    let w = matrix.ncols();
    let mut whole = transposed_product(matrix, matrix).resize(w + 1, w + 1, 0.0);
    for (c, column) in matrix.column_iter().enumerate() {
        (whole[(c, w)], whole[(w, c)]) = (column.sum(), column.sum());
    }
    whole[(w, w)] = used as f64;
    let torque = DVector::from_column_slice(torque);
    let moment = matrix.tr_mul(&torque).push(torque.sum());
    JointNormal {
        columns,
        gram: whole,
        moment,
        torque_square: torque.norm_squared(),
        rows: used,
        resolution: 0.0,
    }
}

/// `a + sign b`, joint by joint.
fn combined(a: &Part, b: &Part, sign: f64) -> Part {
    let joint = |(a, b): (&JointNormal, &JointNormal)| JointNormal {
        columns: a.columns.clone(),
        gram: &a.gram + &b.gram * sign,
        moment: &a.moment + &b.moment * sign,
        torque_square: a.torque_square + sign * b.torque_square,
        rows: if sign > 0.0 {
            a.rows + b.rows
        } else {
            a.rows.saturating_sub(b.rows)
        },
        resolution: a.resolution.max(b.resolution),
    };
    a.iter().zip(b).map(joint).collect()
}

/// Shares explained over all folds.
pub(crate) fn shares(folds: &[Fold]) -> Explained {
    let joints = folds.first().map_or(0, |f| f.test.len());
    let per_fold: Vec<Vec<[f64; 2]>> = folds.par_iter().map(predicted).collect();
    let of = |j: usize| {
        let [constant, model] = per_fold
            .iter()
            .fold([0.0; 2], |[c, m], fold| [c + fold[j][0], m + fold[j][1]]);
        (constant > 0.0 && model.is_finite()).then(|| 1.0 - model / constant)
    };
    Explained {
        joints: (0..joints).map(of).collect(),
    }
}

/// Per joint: what the constant, and what the model with it, leave of the rows to predict.
fn predicted(fold: &Fold) -> Vec<[f64; 2]> {
    let means: Vec<f64> = fold.train.iter().map(mean).collect();
    let values = fitted(fold, &means);
    let of = |(normal, &mean): (&JointNormal, &f64)| {
        let (own, (moment, square)) = (
            DVector::from_iterator(normal.columns.len(), normal.columns.iter().map(|&c| values[c])),
            about(normal, mean),
        );
        // Of rows that are all alike rounding remains.
        let constant = if square > 1e-20 * normal.torque_square { square } else { 0.0 };
        [
            constant,
            (square - 2.0 * own.dot(&moment) + own.dot(&(&normal.gram * &own))).max(0.0),
        ]
    };
    fold.test.iter().zip(&means).map(of).collect()
}

fn mean(normal: &JointNormal) -> f64 {
    let last = normal.moment.len() - 1;
    if normal.rows == 0 {
        0.0
    } else {
        normal.moment[last] / normal.rows as f64
    }
}

/// Moments and square of the torque less `mean`.
fn about(normal: &JointNormal, mean: f64) -> (DVector<f64>, f64) {
    let last = normal.moment.len() - 1;
    let moment = &normal.moment - normal.gram.column(last) * mean;
    let square = normal.torque_square - 2.0 * mean * normal.moment[last] + mean * mean * normal.rows as f64;
    (moment, square.max(0.0))
}

/// Least squares of the rows to fit, every joint by the inverse of its variance, with a ridge of a part of all information where
/// the rows do not determine a direction clearly.
fn fitted(fold: &Fold, means: &[f64]) -> DVector<f64> {
    let size = fold.train.iter().flat_map(|n| &n.columns).max().map_or(0, |c| c + 1);
    let (mut own, mut all, mut moment) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size), DVector::zeros(size));
    let mut rows = 0;
    for ((train, test), &mean) in fold.train.iter().zip(&fold.test).zip(means) {
        let (right, square) = about(train, mean);
        let weight = if square > 0.0 { train.rows as f64 / square } else { 0.0 };
        rows += if square > 0.0 { train.rows } else { 0 };
        for (b, &cb) in train.columns.iter().enumerate() {
            moment[cb] += weight * right[b];
            for (a, &ca) in train.columns.iter().enumerate() {
                own[(ca, cb)] += weight * train.gram[(a, b)];
                all[(ca, cb)] += weight * (train.gram[(a, b)] + test.gram[(a, b)]);
            }
        }
    }
    // The weighed squares of the torques add up to their number.
    solved(&own, &all, &moment, rows as f64)
}

/// Least squares by the information `own` and the moment, direction by direction of unit information in `all`. What the rows to
/// fit know of a direction is a share g of that; `g / (g + SETTINGS.explained_ridge)` of its estimate counts, or more where its
/// part of the torque stands out of the noise by itself (James & Stein 1961: all but noise over part), since a single event in
/// the rows to predict may hold most of the information about what the others determine well enough.
fn solved(own: &DMatrix<f64>, all: &DMatrix<f64>, moment: &DVector<f64>, square: f64) -> DVector<f64> {
    let is_usable = |m: &DMatrix<f64>| m.iter().all(|v| v.is_finite());
    if !is_usable(all) || !is_usable(own) || all.diagonal().iter().all(|v| *v <= 0.0) {
        return DVector::zeros(moment.len());
    }
    let scale = all.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { 0.0 });
    let scaled = |m: &DMatrix<f64>| {
        DMatrix::from_fn(m.nrows(), m.ncols(), |r, c| {
            0.5 * (m[(r, c)] + m[(c, r)]) * scale[r] * scale[c]
        })
    };
    let whole = scaled(all).symmetric_eigen();
    let kept: Vec<usize> = (0..scale.len())
        .filter(|&i| whole.eigenvalues[i] > SETTINGS.explained_rounding * whole.eigenvalues.amax())
        .collect();
    let mut root = whole.eigenvectors.select_columns(&kept);
    kept.iter()
        .enumerate()
        .for_each(|(c, &i)| root.column_mut(c).scale_mut(whole.eigenvalues[i].sqrt().recip()));
    let known = (root.tr_mul(&(scaled(own) * &root))).symmetric_eigen();
    root *= &known.eigenvectors;
    let along = root.tr_mul(&moment.component_mul(&scale));
    // A share of nothing but rounding has no part of its own.
    let part = |i: usize| {
        if known.eigenvalues[i] > SETTINGS.explained_rounding {
            along[i] * along[i] / known.eigenvalues[i]
        } else {
            0.0
        }
    };
    let explained: f64 = (0..along.len()).map(part).sum();
    let noise = (square - explained).max(0.0) / (square - along.len() as f64).max(1.0);
    let step = |i: usize, _| {
        let share = known.eigenvalues[i].max(0.0);
        let by_itself = if part(i) > noise { 1.0 - noise / part(i) } else { 0.0 };
        match by_itself > share / (share + SETTINGS.explained_ridge) {
            true => by_itself * along[i] / share,
            false => along[i] / (share + SETTINGS.explained_ridge),
        }
    };
    (root * DVector::from_fn(along.len(), step)).component_mul(&scale)
}

/// Share of the torques on `stretches` that `model`, without its effects, explains on held-out data: of stretches with periods,
/// one half of them predicts the other.
pub fn explained_share(model: &AugmentedModel, stretches: &[Stretch]) -> Explained {
    let p = model.values.len();
    let folds = stretches.iter().flat_map(|stretch| {
        let rows = model.base_rows(stretch);
        let kept: Vec<Vec<bool>> = (0..stretch.joints()).map(|j| stretch.kept(&stretch.motion, j)).collect();
        let part = |torque: &[Vec<f64>], range: Range<usize>| {
            let joint = |j: usize| {
                let at: Vec<usize> = range.clone().filter(|&s| kept[j][s]).collect();
                let matrix = DMatrix::from_fn(at.len(), rows[j].len(), |r, c| rows[j][c].1[at[r]]);
                let own: Vec<f64> = at.iter().map(|&s| torque[j][s]).collect();
                let columns = rows[j].iter().map(|c| c.0).chain([p + j]).collect();
                with_constant(&matrix, &own, at.len(), columns)
            };
            (0..stretch.joints()).map(joint).collect()
        };
        let count = stretch.periods.len();
        if count < 2 {
            return folds_in_time(stretch.rows(), |range| part(&stretch.torque, range));
        }
        let [even, odd] = [0, 1].map(|half| {
            let mean = stretch.mean_over(&(half..count).step_by(2).collect::<Vec<_>>());
            part(&mean, 0..stretch.rows())
        });
        folds_both_ways(even, odd)
    });
    shares(&folds.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Rows of eight harmonics of a motion, their torque, and what they explain of it.
    fn explained_of(torque: impl Fn(&DMatrix<f64>) -> Vec<f64>) -> f64 {
        let rows = 1000;
        let matrix = DMatrix::from_fn(rows, 8, |s, c| {
            (0.011 * (c + 1) as f64 * s as f64 + c as f64).sin() + if c == 3 { 5.0 } else { 0.0 }
        });
        let torque = torque(&matrix);
        let part = |range: Range<usize>| {
            let own = matrix.rows(range.start, range.len()).into_owned();
            vec![with_constant(&own, &torque[range.clone()], range.len(), (0..9).collect())]
        };
        shares(&folds_in_time(rows, part)).mean()
    }

    /// First-order noise of this correlation from row to row.
    fn noise(seed: u64, correlation: f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut last = 0.0;
        let fresh = |rng: &mut ChaCha8Rng| (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        (0..1000)
            .map(|_| {
                last = correlation * last + (1.0 - correlation * correlation).sqrt() * fresh(&mut rng);
                last
            })
            .collect()
    }

    #[test]
    fn prop_noise_is_not_explained_at_any_scale() {
        for seed in 0..50 {
            for scale in [1e-9, 1.0, 1e9] {
                let correlation = [0.0, 0.5, 0.9][seed as usize % 3];
                let share = explained_of(|_| noise(seed, correlation).iter().map(|v| scale * (v + 20.0)).collect());
                assert!(
                    share < SETTINGS.least_explained,
                    "{share} with seed {seed}, correlation {correlation}, scale {scale}"
                );
            }
        }
    }

    #[test]
    fn prop_a_torque_of_the_motion_is_explained() {
        for seed in 0..20 {
            let torque = |m: &DMatrix<f64>| -> Vec<f64> {
                let made = m * DVector::from_fn(8, |c, _| 1.0 + c as f64);
                made.iter().zip(noise(seed, 0.5)).map(|(v, e)| v + 3.0 * e).collect()
            };
            let share = explained_of(torque);
            // The ridge takes a hundredth of it, the noise as much as it has.
            assert!(share > 0.8, "{share}");
        }
    }
}
