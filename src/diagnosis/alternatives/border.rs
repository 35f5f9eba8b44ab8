//! What the data say of a rival beside the model that has the finding: the columns it would add to the normal matrix.
//!
//! With these a later design knows, without the data, how far they tell finding and rival apart, and what a new motion adds.

use crate::dynamics::Coulomb;
use crate::effects::{Column, Motions, Scene};
use crate::regression::{Data, Stretch, System, Term, shape_derivatives};
use nalgebra::{DMatrix, DVector};

/// A rival of a finding, fitted in its place.
#[derive(Debug, Clone)]
pub struct RivalTerm {
    /// The rival with its fitted values.
    pub term: Term,
    /// Base parameters of that fit.
    pub base_values: DVector<f64>,
    /// Twice the log of the evidence ratio in favour of the finding, by the data.
    pub evidence: f64,
    /// `J'C`: columns of the model with the finding times those of the rival, p × k.
    pub cross: DMatrix<f64>,
    /// `C'C`, k × k.
    pub own: DMatrix<f64>,
}

/// `(J'C, C'C)` of a term's columns at its values, whitened and doubted as [`Data::known`] does.
pub(crate) fn border(data: &Data, system: &System, term: &Term) -> (DMatrix<f64>, DMatrix<f64>) {
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let per_stretch: Vec<Vec<Column>> = coarse
        .iter()
        .zip(system.thinned(data))
        .map(|(stretch, thin)| {
            if term.is_distortion() {
                return distorted(system, stretch, term);
            }
            let scene = Scene {
                robot: &system.model.robot,
                motion: &thin.motion,
                rigid: &thin.rigid,
                declared: &thin.declared,
                interval: stretch.interval,
                periodic: stretch.periodic,
                coulomb: Coulomb::Sign,
            };
            let mut columns = term.effect.columns(term.form, &scene, &term.joints, &term.shape);
            columns.extend(shape_derivatives(term, &scene));
            columns
        })
        .collect();
    let (p, k) = (system.covariance.nrows(), term.parameters());
    let (mut cross, mut own) = (DMatrix::zeros(p, k), DMatrix::zeros(k, k));
    let doubts = data.doubts(system);
    for (blocks, parts) in system.blocks.iter().zip(system.whitened(data, &coarse, per_stretch)) {
        for (j, m) in parts {
            cross += blocks[j].jacobian.tr_mul(&m) / doubts[j];
            own += m.tr_mul(&m) / doubts[j];
        }
    }
    (cross, own)
}

fn distorted(system: &System, stretch: &Stretch, term: &Term) -> Vec<Column> {
    let plain = system
        .model
        .torques(Motions::stiff(&stretch.motion), &system.model.robot, None);
    let derivatives = system.model.distortion_columns(stretch, &plain, term, None, None);
    let column = |rows: Vec<Vec<f64>>| Column {
        rows: rows.into_iter().enumerate().collect(),
    };
    derivatives.into_iter().map(column).collect()
}
