//! Weighted least squares of an augmented model: normal equations at a model, Gauss-Newton, and what a further block of columns would gain.

use super::evaluation::{Evaluated, ShapedRows};
use super::product::transposed_product;
use super::store::ColumnStore;
use super::{AugmentedModel, NoiseModel, NoiseSource, Stretch, Term};
use crate::dynamics::Motion;
use crate::effects::Column;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// What an earlier identification knows about the first parameters of a model (its base parameters, then its own effects).
#[derive(Debug, Clone)]
pub struct Prior {
    pub mean: DVector<f64>,
    /// Inverse covariance.
    pub information: DMatrix<f64>,
}

/// Data and noise: all that a fit needs besides the model.
pub(crate) struct Data<'a> {
    pub stretches: &'a [Stretch],
    /// Per joint.
    pub noise: Vec<NoiseModel>,
    pub prior: Option<&'a Prior>,
    /// Decrease of the sum of squares that a fit stops at.
    settled: f64,
    /// Rows of the base parameters along the undistorted motion, per stretch: they are the same in every fit.
    base: Arc<OnceLock<Vec<ShapedRows>>>,
    /// The same whitened by this noise, per stretch and joint.
    white: OnceLock<Vec<Vec<Block>>>,
    /// Columns of candidates along the undistorted motion.
    pub columns: Arc<ColumnStore>,
    /// The model to start from with smooth functions beside it and no effects; they are asked for again and again. For noise that is measured.
    pub alone: Arc<OnceLock<Option<AugmentedModel>>>,
}

/// The whitened rows of one joint over one stretch.
pub(crate) struct Block {
    /// M × parameters.
    pub jacobian: DMatrix<f64>,
    /// J'J.
    normal: DMatrix<f64>,
    /// M; measured minus predicted.
    pub residual: DVector<f64>,
    /// Rows that count.
    pub rows: Vec<bool>,
}

/// A model linearised at its parameters.
pub(crate) struct System {
    pub model: AugmentedModel,
    /// Per stretch.
    pub evaluated: Vec<Evaluated>,
    /// Per stretch, per joint.
    pub blocks: Vec<Vec<Block>>,
    /// Pseudo-inverse of the normal matrix: the covariance of the parameters.
    pub covariance: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Whether the noise comes from the scatter of periods, and not from the residual itself.
    pub noise_is_measured: bool,
    /// Motion and torques thinned out, per stretch: enough to find what is worth fitting.
    coarse: OnceLock<Vec<Thinned>>,
}

/// Motion of a stretch and torques along it, on the samples of its coarse form.
pub(crate) struct Thinned {
    pub motion: Motion,
    /// Whether a distortion has moved it from what was measured.
    pub moved: bool,
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
}

/// A hundredth of the standard deviations, squared: what is reported is known so much better than the noise allows.
const TO_REPORT: f64 = 1e-4;

/// Effects are told apart by evidences that differ by several units: a hundredth of one is nothing beside them.
const TO_COMPARE: f64 = 1e-2;

/// A scaled normal matrix loses 16 digits at a condition number of 1e8 of the rows; eigenvalues below 1e-13 of the largest are rounding.
pub(crate) const RANK: f64 = 1e-13;

impl<'a> Data<'a> {
    pub fn new(stretches: &'a [Stretch], noise: Vec<NoiseModel>, prior: Option<&'a Prior>) -> Self {
        Self {
            stretches,
            noise,
            prior,
            settled: TO_REPORT,
            base: Arc::default(),
            white: OnceLock::new(),
            columns: Arc::default(),
            alone: Arc::default(),
        }
    }

    /// The same data for fits that are only compared with each other.
    pub fn for_comparison(self) -> Self {
        Self {
            settled: TO_COMPARE,
            ..self
        }
    }

    /// The same data with other noise.
    pub fn with_noise(&self, noise: Vec<NoiseModel>) -> Self {
        Self {
            stretches: self.stretches,
            noise,
            prior: self.prior,
            settled: self.settled,
            base: self.base.clone(),
            white: OnceLock::new(),
            columns: self.columns.clone(),
            alone: self.alone.clone(),
        }
    }

    pub fn linearise(&self, model: AugmentedModel) -> System {
        let base = self
            .base
            .get_or_init(|| self.stretches.par_iter().map(|s| model.base_rows(s)).collect());
        // As long as nothing bends the motion, only the columns of the effects are new.
        let bent = model.terms.iter().any(Term::is_distortion);
        let none = vec![Vec::new(); model.robot.joint_count()];
        let evaluated: Vec<Evaluated> = self
            .stretches
            .par_iter()
            .zip(base)
            .map(|(s, rows)| model.evaluate(s, Some(if bent { rows } else { &none })))
            .collect();
        let p = model.parameters();
        let white = (!bent).then(|| self.white.get_or_init(|| self.whitened_base(base, model.values.len())));
        let blocks: Vec<Vec<Block>> = self
            .stretches
            .iter()
            .zip(&evaluated)
            .enumerate()
            .map(|(i, (stretch, e))| {
                (0..stretch.joints())
                    .into_par_iter()
                    .map(|j| self.block(stretch, e, j, p, white.map(|w| &w[i][j])))
                    .collect()
            })
            .collect();
        let (mut normal, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let parts: Vec<_> = blocks
            .par_iter()
            .flatten()
            .map(|b| (&b.normal, b.jacobian.tr_mul(&b.residual)))
            .collect();
        for (g, r) in parts {
            normal += g;
            gradient += r;
        }
        if let Some(prior) = self.prior {
            let k = prior.mean.len();
            let off = &prior.mean - model.vector().rows(0, k);
            let mut corner = normal.view_mut((0, 0), (k, k));
            corner += &prior.information;
            let pull = &prior.information * off;
            let mut head = gradient.rows_mut(0, k);
            head += pull;
        }
        let covariance = pseudo_inverse(&normal, RANK);
        let noise_is_measured = self.noise.iter().all(|n| n.source == NoiseSource::Periods);
        System {
            model,
            evaluated,
            blocks,
            covariance,
            gradient,
            noise_is_measured,
            coarse: OnceLock::new(),
        }
    }

    /// White noise of the size of what a fit leaves on every joint. How far the rows go together is weighed effect by effect, or slow
    /// effects would pass for noise.
    pub fn left_as_noise(&self, system: &System) -> Vec<NoiseModel> {
        let of = |(j, noise): (usize, &NoiseModel)| {
            let freedom = (system.rows(j) as f64 - system.spent(j)).max(1.0);
            // A fit without residual is one of simulated data: rounding of the torque is all the noise there is.
            let std_dev = (noise.innovation * (system.joint_chi_square(j) / freedom).sqrt()).max(f64::MIN_POSITIVE.sqrt());
            NoiseModel {
                source: NoiseSource::Residual,
                std_dev,
                autoregression: Vec::new(),
                innovation: std_dev,
                degrees_of_freedom: freedom,
            }
        };
        self.noise.iter().enumerate().map(of).collect()
    }

    /// The base parameters' rows of every joint, whitened, along the motion as measured.
    fn whitened_base(&self, base: &[ShapedRows], parameters: usize) -> Vec<Vec<Block>> {
        let of = |(stretch, shaped): (&Stretch, &ShapedRows)| {
            let joint = |j: usize| {
                let noise = &self.noise[j];
                let rows = noise.whitened_rows(&stretch.kept(&stretch.motion, j), stretch.periodic);
                let mut jacobian = DMatrix::zeros(stretch.rows(), parameters);
                whiten_into(&mut jacobian, &shaped[j], noise, &rows, stretch.repetitions());
                Block {
                    normal: transposed_product(&jacobian, &jacobian),
                    jacobian,
                    residual: DVector::zeros(0),
                    rows,
                }
            };
            (0..stretch.joints()).into_par_iter().map(joint).collect()
        };
        self.stretches.iter().zip(base).map(of).collect()
    }

    fn block(&self, stretch: &Stretch, e: &Evaluated, joint: usize, parameters: usize, base: Option<&Block>) -> Block {
        let noise = &self.noise[joint];
        let rows = match base {
            Some(base) => base.rows.clone(),
            None => noise.whitened_rows(&stretch.kept(&e.motion, joint), stretch.periodic),
        };
        let mut jacobian = DMatrix::zeros(stretch.rows(), parameters);
        if let Some(base) = base {
            jacobian.columns_mut(0, base.jacobian.ncols()).copy_from(&base.jacobian);
        }
        whiten_into(&mut jacobian, &e.jacobian[joint], noise, &rows, stretch.repetitions());
        let difference: Vec<f64> = stretch.torque[joint]
            .iter()
            .zip(&e.torque[joint])
            .map(|(y, f)| y - f)
            .collect();
        let residual = DVector::from_vec(noise.whiten(&difference, &rows, stretch.repetitions()));
        let normal = match base {
            Some(base) => bordered(&base.normal, &jacobian),
            None => transposed_product(&jacobian, &jacobian),
        };
        Block {
            jacobian,
            normal,
            residual,
            rows,
        }
    }

    /// Gauss-Newton from `model` until a step takes less than [`TO_REPORT`] (or [`TO_COMPARE`]) off the sum of squares. A step that makes the fit
    /// worse is halved.
    pub fn fit(&self, model: AugmentedModel) -> System {
        let mut here = self.linearise(model);
        let mut cost = self.cost(&here);
        let rows = self.all_rows(&here) as f64;
        for _ in 0..MOST_STEPS {
            let step = &here.covariance * &here.gradient;
            let decrease = here.gradient.dot(&step);
            let mut factor = 1.0;
            let (there, lower) = loop {
                let there = self.linearise(here.model.moved(&(&step * factor)));
                let lower = self.cost(&there);
                // Rows at reversals come and go with a distortion; their share of the sum is not a worse fit.
                if lower <= cost * (1.0 + 1e-9) || factor < 0.1 || here.model.terms.is_empty() {
                    break (there, lower);
                }
                factor *= 0.5;
            };
            let settled = decrease < self.settled || (cost - lower).abs() < (1e-7 * cost).max(self.settled / rows);
            if lower > cost * 1.001 && !here.model.terms.is_empty() {
                break;
            }
            (here, cost) = (there, lower);
            if settled || here.model.terms.is_empty() && decrease < 1.0 {
                break;
            }
        }
        here
    }

    /// What a fit knows of its parameters, as an inverse covariance: the normal matrix with the prior's part, the rows of a joint that keeps more
    /// than noise counted for as much less as they leave and go together.
    pub fn known(&self, system: &System) -> DMatrix<f64> {
        let p = system.covariance.nrows();
        let doubts = self.doubts(system);
        let blocks = system.blocks.iter().flat_map(|b| b.iter().zip(&doubts));
        let mut normal = blocks
            .map(|(block, doubt)| &block.normal / *doubt)
            .fold(DMatrix::zeros(p, p), |a, b| a + b);
        if let Some(prior) = self.prior {
            let k = prior.mean.len();
            let mut corner = normal.view_mut((0, 0), (k, k));
            corner += &prior.information;
        }
        normal
    }

    /// By how much less the rows of every joint count: as much as they keep more than noise and go together.
    pub fn doubts(&self, system: &System) -> Vec<f64> {
        let doubt = |j: usize| match system.has_misfit(&[j]) {
            true => system.mean_square(&[j]) * system.persistence(&[j]),
            false => 1.0,
        };
        (0..self.noise.len()).map(doubt).collect()
    }

    /// Mean square of the whitened residuals plus the prior's share.
    fn cost(&self, system: &System) -> f64 {
        self.chi_square(system) / self.all_rows(system) as f64
    }

    /// Rows of all joints; 1 where there are none.
    fn all_rows(&self, system: &System) -> usize {
        (0..self.noise.len()).map(|j| system.rows(j)).sum::<usize>().max(1)
    }

    /// Sum of squares of the whitened residuals, and of the distance to the prior.
    pub fn chi_square(&self, system: &System) -> f64 {
        let joints: f64 = (0..self.noise.len()).map(|j| system.joint_chi_square(j)).sum();
        joints + self.distance(system)
    }

    /// Squared distance to the prior.
    fn distance(&self, system: &System) -> f64 {
        self.prior.map_or(0.0, |prior| {
            let off = &prior.mean - system.model.vector().rows(0, prior.mean.len());
            (off.transpose() * &prior.information * off)[0]
        })
    }

    /// How much less `after` leaves than `before`, on the rows that both have: a distortion moves reversals, and the rows left out
    /// there are no gain.
    pub fn gain(&self, before: &System, after: &System) -> f64 {
        let pairs = before.blocks.iter().flatten().zip(after.blocks.iter().flatten());
        let rows: f64 = pairs
            .map(|(b, a)| {
                let both = b.rows.iter().zip(&a.rows).map(|(x, y)| *x && *y);
                let values = b.residual.iter().zip(&a.residual);
                values
                    .zip(both)
                    .filter(|(_, both)| *both)
                    .map(|((b, a), _)| b * b - a * a)
                    .sum::<f64>()
            })
            .sum();
        rows + self.distance(before) - self.distance(after)
    }
}

/// Runs per stretch when the persistence of a residual is measured: a fiftieth of a motion is short beside its course.
const RUNS: usize = 50;

/// Reweighted linear columns settle in 3 to 5 steps, distortions of any sensible size in fewer than 10.
const MOST_STEPS: usize = 15;

fn whiten_into(
    jacobian: &mut DMatrix<f64>,
    columns: &[(usize, Vec<f64>)],
    noise: &NoiseModel,
    rows: &[bool],
    repetitions: usize,
) {
    for (at, values) in columns {
        let white = noise.whiten(values, rows, repetitions);
        jacobian.column_mut(*at).iter_mut().zip(white).for_each(|(m, v)| *m += v);
    }
}

/// `J'J` where that of the first columns is known.
fn bordered(known: &DMatrix<f64>, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let (base, all) = (known.nrows(), jacobian.ncols());
    let mut normal = DMatrix::zeros(all, all);
    normal.view_mut((0, 0), (base, base)).copy_from(known);
    if all > base {
        let cross = transposed_product(jacobian, &jacobian.columns(base, all - base).into_owned());
        normal.columns_mut(base, all - base).copy_from(&cross);
        normal
            .view_mut((base, 0), (all - base, base))
            .copy_from(&cross.rows(0, base).transpose());
    }
    normal
}

impl System {
    /// Sum of squares of the whitened residuals of one joint.
    pub fn joint_chi_square(&self, joint: usize) -> f64 {
        self.blocks.iter().map(|b| b[joint].residual.norm_squared()).sum()
    }

    /// Rows of one joint.
    pub fn rows(&self, joint: usize) -> usize {
        self.blocks.iter().map(|b| b[joint].rows.iter().filter(|r| **r).count()).sum()
    }

    /// Rows over which the residual of these joints keeps its sign: mean square of sums over runs of rows, relative to white noise.
    pub fn persistence(&self, joints: &[usize]) -> f64 {
        let (mut together, mut alone) = (0.0, 0.0);
        for blocks in &self.blocks {
            for &j in joints {
                let r = blocks[j].residual.as_slice();
                for run in r.chunks((r.len() / RUNS).max(1)) {
                    together += run.iter().sum::<f64>().powi(2);
                    alone += run.iter().map(|v| v * v).sum::<f64>();
                }
            }
        }
        if alone > 0.0 { (together / alone).max(1.0) } else { 1.0 }
    }

    /// Degrees of freedom that the fit has spent on the rows of one joint: the trace of its part of the hat matrix.
    pub fn spent(&self, joint: usize) -> f64 {
        let trace = |b: &Block| (&b.jacobian * &self.covariance).component_mul(&b.jacobian).sum();
        self.blocks.iter().map(|b| trace(&b[joint])).sum()
    }

    /// Covariance of term `at`.
    pub fn term_covariance(&self, at: usize) -> DMatrix<f64> {
        let (from, k) = (self.model.offset_of(at), self.model.terms[at].parameters());
        self.covariance.view((from, from), (k, k)).into_owned()
    }
}

/// Pseudo-inverse of a positive semidefinite matrix, scaled to a unit diagonal first; eigenvalues below `relative` of the largest count as zero.
pub(crate) fn pseudo_inverse(normal: &DMatrix<f64>, relative: f64) -> DMatrix<f64> {
    let half = pseudo_root(normal, relative);
    &half * half.transpose()
}

/// H with `H Hᵀ` the pseudo-inverse of [`pseudo_inverse`], and `Hᵀ G H = 1`.
pub(crate) fn pseudo_root(normal: &DMatrix<f64>, relative: f64) -> DMatrix<f64> {
    let p = normal.nrows();
    // A column that is zero but for rounding (gravity along an axis that is not quite a coordinate axis) is 1e-16 of the others.
    let least = 1e-24 * normal.diagonal().amax();
    let scale = DVector::from_fn(p, |i, _| {
        if normal[(i, i)] > least {
            normal[(i, i)].sqrt().recip()
        } else {
            0.0
        }
    });
    let scaled = DMatrix::from_fn(p, p, |r, c| normal[(r, c)] * scale[r] * scale[c]);
    let eigen = scaled.symmetric_eigen();
    let least = relative * eigen.eigenvalues.amax();
    let kept: Vec<usize> = (0..p).filter(|&i| eigen.eigenvalues[i] > least).collect();
    let mut half = eigen.eigenvectors.select_columns(&kept);
    for (c, &i) in kept.iter().enumerate() {
        half.column_mut(c).scale_mut(eigen.eigenvalues[i].sqrt().recip());
    }
    (0..p).for_each(|r| half.row_mut(r).scale_mut(scale[r]));
    half
}

/// A block of columns after the model's own columns are projected out.
#[derive(Debug, Clone)]
pub(crate) struct Reduced {
    /// Sum of squares that it takes off the residual.
    pub gain: f64,
    /// Rank of what is left of the columns.
    pub rank: usize,
    pub coefficients: DVector<f64>,
}

/// Below this share of its square a column is a combination of the model's columns: its coefficient would be a thousand times less certain
/// than the column alone would allow.
const HIDDEN: f64 = 1e-6;

/// Whitened columns: per stretch, `(joint, M × k)` for every joint where they are not zero.
pub(crate) type Whitened = Vec<Vec<(usize, DMatrix<f64>)>>;

impl System {
    /// Motion and torques on the samples of the coarse forms of the stretches.
    pub fn thinned(&self, data: &Data) -> &[Thinned] {
        self.coarse.get_or_init(|| {
            let thin = |(stretch, e): (&Stretch, &Evaluated)| {
                let picked = stretch.coarse_samples();
                let pick = |rows: &[Vec<f64>]| rows.iter().map(|r| picked.iter().map(|&s| r[s]).collect()).collect();
                Thinned {
                    motion: Motion::from_fn(stretch.joints(), picked.len(), |j, s| e.motion.get(j, picked[s])),
                    moved: e.motion != stretch.motion,
                    rigid: pick(&e.rigid),
                    declared: pick(&e.declared),
                }
            };
            data.stretches.iter().zip(&self.evaluated).map(thin).collect()
        })
    }

    /// Whitens columns over the motion of `stretches` (not shaped yet), one list per stretch.
    pub fn whitened(&self, data: &Data, stretches: &[&Stretch], columns: Vec<Vec<Column>>) -> Whitened {
        let shaped = |(stretch, columns): (&&Stretch, Vec<Column>)| {
            let of = |c| stretch.shaped_column(c);
            columns.into_iter().map(of).collect()
        };
        let shaped: Vec<Vec<Column>> = stretches.iter().zip(columns).map(shaped).collect();
        let borrowed: Vec<Vec<&Column>> = shaped.iter().map(|c| c.iter().collect()).collect();
        self.whitened_shaped(data, stretches, &borrowed)
    }

    /// Whitens columns that are as they enter the rows, one list per stretch.
    pub fn whitened_shaped(&self, data: &Data, stretches: &[&Stretch], columns: &[Vec<&Column>]) -> Whitened {
        let per_stretch = stretches.iter().zip(&self.blocks).zip(&self.evaluated).zip(columns);
        per_stretch
            .map(|(((stretch, blocks), e), columns)| {
                let mut joints: Vec<usize> = columns.iter().flat_map(|c| c.rows.iter().map(|r| r.0)).collect();
                joints.sort_unstable();
                joints.dedup();
                let dense = |j: usize| {
                    let mut m = DMatrix::zeros(stretch.rows(), columns.len());
                    for (k, column) in columns.iter().enumerate() {
                        for (_, values) in column.rows.iter().filter(|r| r.0 == j) {
                            let white = data.noise[j].whiten(values, &blocks[j].rows, stretch.repetitions());
                            m.column_mut(k).iter_mut().zip(white).for_each(|(m, v)| *m = v * e.gain[j]);
                        }
                    }
                    (j, m)
                };
                joints.into_iter().map(dense).collect()
            })
            .collect()
    }

    /// `(C'C − A' G⁺ A, C'r)` with A = J'C.
    pub fn projected(&self, columns: &Whitened) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let k = columns.iter().flatten().map(|(_, m)| m.ncols()).next().unwrap_or(0);
        let p = self.covariance.nrows();
        let (mut own, mut cross, mut right) = (DMatrix::zeros(k, k), DMatrix::zeros(p, k), DVector::zeros(k));
        for (blocks, parts) in self.blocks.iter().zip(columns) {
            for (j, m) in parts {
                let block = &blocks[*j];
                own += transposed_product(m, m);
                cross += transposed_product(&block.jacobian, m);
                right += m.tr_mul(&block.residual);
            }
        }
        let rest = &own - cross.tr_mul(&(&self.covariance * &cross));
        (own, rest, right)
    }

    /// J'C.
    pub fn cross(&self, columns: &Whitened) -> DMatrix<f64> {
        let k = columns.iter().flatten().map(|(_, m)| m.ncols()).next().unwrap_or(0);
        let mut cross = DMatrix::zeros(self.covariance.nrows(), k);
        for (blocks, parts) in self.blocks.iter().zip(columns) {
            for (j, m) in parts {
                cross += transposed_product(&blocks[*j].jacobian, m);
            }
        }
        cross
    }

    /// What the columns would gain.
    pub fn reduced(&self, columns: &Whitened) -> Reduced {
        let (own, rest, right) = self.projected(columns);
        reduce(&own, &rest, &right)
    }
}

pub(crate) fn reduce(own: &DMatrix<f64>, rest: &DMatrix<f64>, right: &DVector<f64>) -> Reduced {
    let base = directions(own, rest);
    let along = base.tr_mul(right);
    Reduced {
        gain: along.norm_squared(),
        rank: base.ncols(),
        coefficients: base * along,
    }
}

/// Combinations D of columns that the model does not hide, of unit information each: `Dᵀ rest D = 1`.
pub(crate) fn directions(own: &DMatrix<f64>, rest: &DMatrix<f64>) -> DMatrix<f64> {
    let k = own.nrows();
    let scale = DVector::from_fn(k, |i, _| if own[(i, i)] > 0.0 { own[(i, i)].sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(k, k, |r, c| 0.5 * (rest[(r, c)] + rest[(c, r)]) * scale[r] * scale[c]);
    let eigen = scaled.symmetric_eigen();
    let seen: Vec<usize> = (0..k).filter(|&i| eigen.eigenvalues[i] > HIDDEN).collect();
    DMatrix::from_fn(k, seen.len(), |r, c| {
        scale[r] * eigen.eigenvectors[(r, seen[c])] / eigen.eigenvalues[seen[c]].sqrt()
    })
}
