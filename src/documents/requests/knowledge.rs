//! What a design may start from: models, rivals of a finding, data or trajectories there are already.

use super::model::Model;
use serde::{Deserialize, Serialize};

/// A model by the id of its identification, or itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum DesignModel {
    Reference(IdentificationReference),
    Model(Box<Model>),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct IdentificationReference {
    /// Id of a finished identification.
    pub identification: String,
}

/// A finding of `model`, and one of the rivals that its data do not exclude.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Rivals {
    pub finding: EffectPlaceOrNumber,
    pub rival: EffectPlaceOrNumber,
}

/// Effect and joints as in `residual.findings`, or the place in the list of the model's effects, or of that effect's rivals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum EffectPlaceOrNumber {
    Place(EffectPlace),
    Number(u32),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct EffectPlace {
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    pub joints: Option<Vec<String>>,
}

/// Data or trajectories there are already.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum Given {
    Identification(IdentificationReference),
    Design(GivenDesign),
    Trajectory(GivenTrajectory),
    Model(Box<Model>),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct GivenDesign {
    /// Id of a finished design.
    pub excitation: String,
    /// Periods recorded.
    #[cfg_attr(feature = "service", schema(default = 1, minimum = 1))]
    pub periods: Option<u32>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct GivenTrajectory {
    pub coefficients: crate::documents::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Vec<f64>,
    pub fundamental_hz: f64,
    /// Periods recorded.
    #[cfg_attr(feature = "service", schema(default = 1, minimum = 1))]
    pub periods: Option<u32>,
}
