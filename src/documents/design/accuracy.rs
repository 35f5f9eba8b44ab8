//! Every criterion of a trajectory, the one that is recommended, and the accuracy to be expected.

use super::finite;
use crate::documents::excitation_request::criterion_name;
use crate::excitation::{Criteria, Predicted, Problem};
use serde::Serialize;

/// Every criterion of the trajectory, whichever was minimised.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct CriteriaDocument {
    /// The one that was minimised.
    #[cfg_attr(feature = "service", schema(example = "condition_number"))]
    pub minimised: &'static str,
    /// `σ_max/σ_min` of the stacked base regressor, at least 1. It depends on the units of the parameters.
    pub condition_number: f64,
    /// After scaling every column of Y_b to length one.
    pub scaled_condition_number: f64,
    /// `det(M)^(−1/(2b))`, M = Y_bᵀ Y_b.
    pub d_optimality: f64,
    /// `sqrt(tr(M⁻¹)/b)`
    pub a_optimality: f64,
    /// Expected torque-prediction error [N·m or N], by the torque noise assumed.
    pub i_optimality: f64,
    /// Least expected BIC difference between two rivals (twice the logarithm of the odds): the larger the better.
    pub rival_evidence: Option<f64>,
}

/// The recommended criterion.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RecommendedDocument {
    #[cfg_attr(feature = "service", schema(example = "i_optimality"))]
    pub criterion: &'static str,
    pub reason: &'static str,
}

/// Accuracy to be expected of an identification from this trajectory, as many periods as asked for, and what is given.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PredictedDocument {
    /// Torque noise assumed, one standard deviation per joint [N·m or N].
    pub torque_noise: Vec<f64>,
    /// Standard deviation of every base parameter, in its SI unit.
    pub std_dev: Vec<Option<f64>>,
    /// `100 σ/|value|`, where the robot has prior link parameters; null where the prior value is zero.
    pub relative_std_dev_percent: Option<Vec<Option<f64>>>,
}

pub(super) fn criteria_document(problem: &Problem, c: &Criteria) -> CriteriaDocument {
    CriteriaDocument {
        minimised: criterion_name(problem.spec().criterion),
        condition_number: c.condition_number,
        scaled_condition_number: c.scaled_condition_number,
        d_optimality: c.d_optimality,
        a_optimality: c.a_optimality,
        i_optimality: c.i_optimality,
        rival_evidence: c.rival_evidence,
    }
}

pub(super) const RECOMMENDATION: RecommendedDocument = RecommendedDocument {
    criterion: "i_optimality",
    reason: "it is the expected error of predicted torques over the workspace, in N m or N, for the torque noise given; it depends neither on the units of the \
             parameters nor on the choice of base parameters. Giving torque_noise, exact limits and a free start improves a design more than the choice of \
             the criterion",
};

pub(super) fn predicted_document(p: &Predicted) -> PredictedDocument {
    PredictedDocument {
        torque_noise: p.torque_noise.clone(),
        std_dev: p.std_dev.iter().copied().map(finite).collect(),
        relative_std_dev_percent: p
            .relative_std_dev_percent
            .as_ref()
            .map(|v| v.iter().copied().map(finite).collect()),
    }
}
