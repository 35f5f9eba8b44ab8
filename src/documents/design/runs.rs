//! Coefficients of a trajectory, smaller amplitudes for a first run, and the trajectories that complement each other.

use super::accuracy::{CriteriaDocument, PredictedDocument, criteria_document, predicted_document};
use super::effects::{EffectDocument, RivalsDocument, effects, rivals};
use super::margins::{ClearanceDocument, MarginDocument, clearance_documents, margin_documents};
use crate::documents::knowledge::DesignTerms;
use crate::excitation::{Design, FirstRun, Problem, margins};
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Fourier coefficients: one row per joint, in each the harmonics 1 … L.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Coefficients {
    /// `a[i][l-1]` of joint i, harmonic l [rad/s or m/s].
    pub a: Vec<Vec<f64>>,
    /// `b[i][l-1]` of joint i, harmonic l [rad/s or m/s].
    pub b: Vec<Vec<f64>>,
}

/// A smaller version of the trajectory.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = FirstRun))]
pub struct FirstRunDocument {
    /// Factor on the amplitudes around where the motion starts; smaller than asked for where a limit along the path would not
    /// hold.
    pub backoff: f64,
    /// Fourier coefficients, smaller by the factor `backoff`.
    pub coefficients: Coefficients,
    /// Constant part q0 of every joint [rad or m].
    pub offset: Vec<f64>,
    /// Fundamental frequency (Hz); lower than that of the design for a slow first run.
    pub fundamental_hz: f64,
    /// Distance to every limit of the joints.
    pub margins: Vec<MarginDocument>,
}

/// One of several trajectories.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = FurtherTrajectory))]
pub struct FurtherDocument {
    /// How the search for this trajectory ended, such as `Converged` or `Infeasible`.
    pub status: &'static str,
    /// Fourier coefficients of the trajectory.
    pub coefficients: Coefficients,
    /// Constant part q0 of every joint [rad or m].
    pub offset: Vec<f64>,
    /// Fundamental frequency (Hz).
    pub fundamental_hz: f64,
    /// Of this trajectory and all before it together.
    pub criteria: CriteriaDocument,
    /// Predicted accuracy of the base parameters from this trajectory and all before it.
    pub predicted: PredictedDocument,
    /// Predicted accuracy of the effects of the model; empty without effects.
    pub effects: Vec<EffectDocument>,
    /// Expected BIC difference between two rivals; null if none were named.
    pub rivals: Option<RivalsDocument>,
    /// Distance to every limit of the joints.
    pub margins: Vec<MarginDocument>,
    /// Smallest distances to obstacles and between links; empty without limits in space.
    pub clearances: Vec<ClearanceDocument>,
}

impl Coefficients {
    pub(super) fn from_series(series: &FourierSeries) -> Self {
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|r| r.iter().copied().collect()).collect();
        Self {
            a: rows(&series.a),
            b: rows(&series.b),
        }
    }
}

pub(super) fn first_run_document(problem: &Problem, run: &FirstRun) -> FirstRunDocument {
    FirstRunDocument {
        backoff: run.amplitude,
        coefficients: Coefficients::from_series(&run.series),
        offset: run.series.offset.clone(),
        fundamental_hz: run.series.fundamental_hz,
        margins: margin_documents(problem, &margins(problem, &run.series)),
    }
}

pub(super) fn further_document(problem: &Problem, terms: &DesignTerms, design: &Design) -> Option<FurtherDocument> {
    Some(FurtherDocument {
        status: design.status.name(),
        coefficients: Coefficients::from_series(&design.series),
        offset: design.series.offset.clone(),
        fundamental_hz: design.series.fundamental_hz,
        criteria: criteria_document(problem, design.criteria.as_ref()?),
        predicted: predicted_document(design.predicted.as_ref()?),
        effects: effects(problem, terms, design),
        rivals: rivals(problem, terms, design),
        margins: margin_documents(problem, &design.margins),
        clearances: clearance_documents(problem, design),
    })
}
