//! What a design may start from: models, rivals of a finding, data or trajectories there are already.

use super::model::Model;
use serde::{Deserialize, Serialize};

/// A model by the id of its identification, or itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum DesignModel {
    /// A finished identification of this server, by ID.
    Reference(IdentificationReference),
    /// The model itself.
    Model(Box<Model>),
}

/// Reference to an identification of this server.
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
    /// The effect that a diagnosis has reported.
    pub finding: EffectPlaceOrNumber,
    /// The effect that the data do not exclude in its place.
    pub rival: EffectPlaceOrNumber,
}

/// Effect and joints as in `residual.findings`, or the place in the list of the model's effects, or of that effect's rivals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum EffectPlaceOrNumber {
    /// The effect by code and joints.
    Place(EffectPlace),
    /// Number of the effect in the list of the model, from 0.
    Number(u32),
}

/// An effect and where it acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct EffectPlace {
    /// Code of the effect.
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    /// Names of its joints; may be left out if the model has the effect once.
    pub joints: Option<Vec<String>>,
}

/// Data or trajectories there are already.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum Given {
    /// An identification of this server: its log counts as recorded.
    Identification(IdentificationReference),
    /// A design of this server.
    Design(GivenDesign),
    /// A trajectory by its coefficients.
    Trajectory(GivenTrajectory),
    /// A model with the covariance of its parameters.
    Model(Box<Model>),
}

/// Reference to a design of this server.
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

/// A trajectory that has been recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct GivenTrajectory {
    /// Fourier coefficients of the trajectory.
    pub coefficients: crate::documents::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Vec<f64>,
    /// Fundamental frequency (Hz).
    pub fundamental_hz: f64,
    /// Periods recorded.
    #[cfg_attr(feature = "service", schema(default = 1, minimum = 1))]
    pub periods: Option<u32>,
}
