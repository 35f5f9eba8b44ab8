//! Weighted least squares of an augmented model: data, noise, and the normal equations at a model.

use super::ar_noise::{NoiseModel, NoiseSource};
use super::column_cache::ColumnStore;
use super::dataset::{ShapedRows, Stretch};
use super::jacobian::Evaluated;
use super::kept::Kept;
use super::model::{AugmentedModel, Term};
use super::present::Present;
use super::product::transposed_product;
use super::rank::pseudo_inverse;
use crate::cancel::CancelFlag;
use crate::dynamics::Motion;
use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;

/// What an earlier identification knows about the first parameters of a model (its base parameters, then its own effects).
#[derive(Debug, Clone)]
pub struct Prior {
    /// Values.
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
    /// Whether fits are only compared with each other: they stop earlier.
    pub(crate) compared: bool,
    /// Rows of the base parameters along the undistorted motion, per stretch: they are the same in every fit.
    base: Arc<Kept<Vec<ShapedRows>>>,
    /// The same whitened by this noise, per stretch and joint.
    white: Kept<Vec<Vec<Block>>>,
    /// Columns of candidates along the undistorted motion.
    pub columns: Arc<ColumnStore>,
    /// The model to start from with smooth functions beside it and no effects; they are asked for again and again. For noise that
    /// is measured.
    pub alone: Arc<Kept<Option<AugmentedModel>>>,
    /// Square roots of further weights of the rows, per stretch and joint; `None` where every row counts by its noise alone.
    pub(crate) row_weights: Option<RowWeights>,
    /// Ends fits and searches: they look at it with every linearisation and every set of columns.
    pub(crate) cancel: CancelFlag,
}

/// Per stretch and joint, one number for every row.
pub(crate) type RowWeights = Vec<Vec<Vec<f64>>>;

/// The whitened rows of one joint over one stretch.
pub(crate) struct Block {
    /// M × parameters.
    pub jacobian: DMatrix<f64>,
    /// J'J.
    pub(crate) normal: DMatrix<f64>,
    /// M; measured minus predicted.
    pub residual: DVector<f64>,
    /// Rows that count.
    pub rows: Vec<bool>,
}

/// What a block of rows contributes to the normal equations.
pub(crate) struct Part {
    pub normal: DMatrix<f64>,
    pub gradient: DVector<f64>,
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
    pub(crate) gradient: DVector<f64>,
    /// Whether the noise comes from the scatter of periods, and not from the residual itself.
    pub noise_is_measured: bool,
    /// Motion and torques thinned out, per stretch: enough to find what is worth fitting.
    pub(crate) coarse: Kept<Vec<Thinned>>,
    /// The world along the coarse forms, per stretch.
    pub(crate) present: Kept<Vec<Present>>,
    /// Normal matrices and gradients of the jackknife's blocks of time.
    pub(crate) parts: Kept<Vec<Part>>,
    /// Of every joint: the independent values that its rows are worth.
    pub(crate) effective_rows: Kept<Vec<f64>>,
}

impl<'a> Data<'a> {
    pub fn new(stretches: &'a [Stretch], noise: Vec<NoiseModel>, prior: Option<&'a Prior>) -> Self {
        Self {
            stretches,
            noise,
            prior,
            compared: false,
            base: Arc::default(),
            white: Kept::default(),
            columns: Arc::default(),
            alone: Arc::default(),
            row_weights: None,
            cancel: CancelFlag::default(),
        }
    }

    /// The same data for fits that are only compared with each other.
    pub fn for_comparison(self) -> Self {
        Self { compared: true, ..self }
    }

    /// The same data, whose fits and searches end with `cancel`.
    pub fn until(self, cancel: &CancelFlag) -> Self {
        Self {
            cancel: cancel.clone(),
            ..self
        }
    }

    /// The same data with other noise.
    pub fn with_noise(&self, noise: Vec<NoiseModel>) -> Self {
        Self {
            stretches: self.stretches,
            noise,
            prior: self.prior,
            compared: self.compared,
            base: self.base.clone(),
            white: Kept::default(),
            columns: self.columns.clone(),
            alone: self.alone.clone(),
            row_weights: None,
            cancel: self.cancel.clone(),
        }
    }

    /// The same data with further weights of the rows, given by their square roots.
    pub(crate) fn with_row_weights(&self, weights: RowWeights) -> Self {
        Self {
            row_weights: Some(weights),
            ..self.with_noise(self.noise.clone())
        }
    }

    /// Rows of the base parameters along the undistorted motion, per stretch.
    pub(crate) fn base_rows(&self, model: &AugmentedModel) -> &[ShapedRows] {
        self.base
            .get(|| self.stretches.par_iter().map(|s| model.base_rows(s)).collect())
    }

    /// The normal matrix of a system, with the prior's part.
    pub(crate) fn normal(&self, system: &System) -> DMatrix<f64> {
        let p = system.covariance.nrows();
        let mut normal = system
            .blocks
            .iter()
            .flatten()
            .fold(DMatrix::zeros(p, p), |sum, block| sum + &block.normal);
        if let Some(prior) = self.prior {
            let k = prior.mean.len();
            let mut corner = normal.view_mut((0, 0), (k, k));
            corner += &prior.information;
        }
        normal
    }

    pub fn linearise(&self, model: AugmentedModel) -> System {
        self.cancel.leave_if_set();
        let base = self.base_rows(&model);
        // As long as nothing bends the motion, only the columns of the effects are new.
        let bent = model.terms.iter().any(Term::is_distortion);
        // Fits that are only compared do without what base parameters change through effects.
        let through_effects = !self.compared && model.reads_own_torques();
        let plain = !bent && !through_effects && self.row_weights.is_none();
        let none = vec![Vec::new(); model.robot.joint_count()];
        let evaluated: Vec<Evaluated> = self
            .stretches
            .par_iter()
            .zip(base)
            .map(|(s, rows)| model.evaluate(s, Some(if plain { &none } else { rows })))
            .collect();
        let p = model.parameters();
        let white = plain.then(|| self.white.get(|| self.whitened_base(base, model.values.len())));
        let blocks: Vec<Vec<Block>> = self
            .stretches
            .iter()
            .zip(&evaluated)
            .enumerate()
            .map(|(i, (stretch, e))| {
                (0..stretch.joints())
                    .into_par_iter()
                    .map(|j| match white {
                        Some(white) => self.block(stretch, e, j, p, Some(&white[i][j])),
                        None => self.weighted(i, j, self.block(stretch, e, j, p, None)),
                    })
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
        let (normal, gradient) = self.with_prior(&model, (normal, gradient));
        let covariance = pseudo_inverse(&normal, SETTINGS.rank_tolerance);
        let noise_is_measured = self.noise.iter().all(|n| n.source == NoiseSource::Periods);
        System {
            model,
            evaluated,
            blocks,
            covariance,
            gradient,
            noise_is_measured,
            coarse: Kept::default(),
            present: Kept::default(),
            parts: Kept::default(),
            effective_rows: Kept::default(),
        }
    }

    /// Normal matrix and gradient with the prior's part.
    fn with_prior(
        &self,
        model: &AugmentedModel,
        (mut normal, mut gradient): (DMatrix<f64>, DVector<f64>),
    ) -> (DMatrix<f64>, DVector<f64>) {
        if let Some(prior) = self.prior {
            let k = prior.mean.len();
            let off = &prior.mean - model.vector().rows(0, k);
            let mut corner = normal.view_mut((0, 0), (k, k));
            corner += &prior.information;
            let pull = &prior.information * off;
            let mut head = gradient.rows_mut(0, k);
            head += pull;
        }
        (normal, gradient)
    }

    /// The block with its rows weighted further.
    fn weighted(&self, stretch: usize, joint: usize, mut block: Block) -> Block {
        let Some(weights) = &self.row_weights else { return block };
        let weights = DVector::from_column_slice(&weights[stretch][joint]);
        block.residual.component_mul_assign(&weights);
        block
            .jacobian
            .column_iter_mut()
            .for_each(|mut column| column.component_mul_assign(&weights));
        block.normal = transposed_product(&block.jacobian, &block.jacobian);
        block
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
}

fn whiten_into(
    jacobian: &mut DMatrix<f64>,
    columns: &[(usize, Vec<f64>)],
    noise: &NoiseModel,
    rows: &[bool],
    repetitions: usize,
) {
    for (at, values) in columns {
        let white = noise.whitened(values, rows, repetitions);
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
    /// The linear model without term `at`, fitted again. The torques that further columns are made from stay those of the model
    /// with it.
    pub(crate) fn without_term(&self, data: &Data, at: usize) -> System {
        let (from, k) = (self.model.offset_of(at), self.model.terms[at].parameters());
        let term = &self.model.terms[at];
        let linear = match term.is_distortion() {
            true => &term.shape[..term.free_shapes],
            false => &term.coefficients[..],
        };
        let gone = DVector::from_column_slice(linear);
        let keep: Vec<usize> = (0..self.covariance.nrows()).filter(|i| *i < from || *i >= from + k).collect();
        let block = |b: &Block| {
            let columns = b.jacobian.columns(from, gone.len());
            Block {
                jacobian: b.jacobian.select_columns(&keep),
                normal: b.normal.select_columns(&keep).select_rows(&keep),
                residual: &b.residual + columns * &gone,
                rows: b.rows.clone(),
            }
        };
        let blocks: Vec<Vec<Block>> = self.blocks.iter().map(|s| s.iter().map(block).collect()).collect();
        let mut model = self.model.clone();
        model.terms.remove(at);
        let size = keep.len();
        let fold = blocks
            .iter()
            .flatten()
            .fold((DMatrix::zeros(size, size), DVector::zeros(size)), |(n, g), b| {
                (n + &b.normal, g + b.jacobian.tr_mul(&b.residual))
            });
        let (normal, gradient) = data.with_prior(&model, fold);
        let covariance = pseudo_inverse(&normal, SETTINGS.rank_tolerance);
        let step = &covariance * &gradient;
        let moved = |mut b: Block| {
            b.residual -= &b.jacobian * &step;
            b
        };
        System {
            model: model.moved(&step),
            evaluated: self.evaluated.clone(),
            blocks: blocks.into_iter().map(|s| s.into_iter().map(moved).collect()).collect(),
            covariance,
            gradient: DVector::zeros(size),
            noise_is_measured: self.noise_is_measured,
            coarse: Kept::default(),
            present: Kept::default(),
            parts: Kept::default(),
            effective_rows: Kept::default(),
        }
    }
}

/// Motion of a stretch and torques along it, on the samples of its coarse form.
pub(crate) struct Thinned {
    pub motion: Motion,
    /// Whether a distortion has moved it from what was measured.
    pub moved: bool,
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
}
