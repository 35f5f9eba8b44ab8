//! What a further block of columns would gain beside a model: its own columns are projected out.

use super::dataset::Stretch;
use super::jacobian::Evaluated;
use super::normal_equations::{Data, System, Thinned};
use super::present::Present;
use super::product::transposed_product;
use super::rank::directions;
use crate::dynamics::Coulomb;
use crate::effects::{Column, Scene};
use nalgebra::{DMatrix, DVector};

/// Whitened columns: per stretch, `(joint, M × k)` for every joint where they are not zero.
pub(crate) type Whitened = Vec<Vec<(usize, DMatrix<f64>)>>;

/// Number of columns k.
pub(crate) fn width(columns: &Whitened) -> usize {
    columns.iter().flatten().map(|(_, m)| m.ncols()).next().unwrap_or(0)
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

impl Thinned {
    /// What the columns of effects are made from.
    pub fn scene<'a>(&'a self, system: &'a System, stretch: &Stretch) -> Scene<'a> {
        Scene {
            robot: &system.model.robot,
            motion: &self.motion,
            rigid: &self.rigid,
            declared: &self.declared,
            interval: stretch.interval,
            periodic: stretch.periodic,
            coulomb: Coulomb::Sign,
        }
    }
}

impl System {
    /// Motion and torques on the samples of the coarse forms of the stretches.
    pub fn thinned(&self, data: &Data) -> &[Thinned] {
        self.coarse.get(|| {
            let thin = |(stretch, e): (&Stretch, &Evaluated)| {
                let pick = |rows: &[Vec<f64>]| rows.iter().map(|r| stretch.coarse_values(r)).collect();
                Thinned {
                    motion: stretch.coarse_motion(&e.motion),
                    moved: e.motion != stretch.motion,
                    rigid: pick(&e.rigid),
                    declared: pick(&e.declared),
                }
            };
            data.stretches.iter().zip(&self.evaluated).map(thin).collect()
        })
    }

    /// The model's world along the coarse forms of the stretches: what further distortions are compared with.
    pub(crate) fn present(&self, data: &Data) -> &[Present] {
        self.present.get(|| {
            data.stretches
                .iter()
                .map(|s| Present::of(&self.model, s.coarse_form()))
                .collect()
        })
    }

    /// Whitens columns over the motion of `stretches` (not shaped yet), one list per stretch.
    pub fn whitened(&self, data: &Data, stretches: &[&Stretch], columns: Vec<Vec<Column>>) -> Whitened {
        let shaped = |(stretch, columns): (&&Stretch, Vec<Column>)| stretch.shaped_columns(columns);
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
        let k = width(columns);
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
        let k = width(columns);
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
