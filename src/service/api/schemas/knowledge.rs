//! What a design may start from: models, rivals of a finding, data or trajectories there are already.

use super::model::ModelSchema;
use serde::Serialize;
use utoipa::ToSchema;

/// A model by the id of its identification, or itself.
#[derive(Serialize, ToSchema)]
#[schema(as = DesignModel)]
#[serde(untagged)]
pub enum DesignModelSchema {
    Reference(ReferenceSchema),
    Model(Box<ModelSchema>),
}

#[derive(Serialize, ToSchema)]
#[schema(as = IdentificationReference)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSchema {
    /// Id of a finished identification.
    identification: String,
}

/// A finding of `model`, and one of the rivals that its data do not exclude.
#[derive(Serialize, ToSchema)]
#[schema(as = Rivals)]
#[serde(deny_unknown_fields)]
pub struct RivalsSchema {
    finding: PlaceOrNumberSchema,
    rival: PlaceOrNumberSchema,
}

/// Effect and joints as in `residual.findings`, or the place in the list of the model's effects, or of that effect's rivals.
#[derive(Serialize, ToSchema)]
#[schema(as = EffectPlaceOrNumber)]
#[serde(untagged)]
pub enum PlaceOrNumberSchema {
    Place(PlaceSchema),
    Number(u32),
}

#[derive(Serialize, ToSchema)]
#[schema(as = EffectPlace)]
#[serde(deny_unknown_fields)]
pub struct PlaceSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Option<Vec<String>>,
}

/// Data or trajectories there are already.
#[derive(Serialize, ToSchema)]
#[schema(as = Given)]
#[serde(untagged)]
pub enum GivenSchema {
    Identification(ReferenceSchema),
    Design(GivenDesignSchema),
    Trajectory(GivenTrajectorySchema),
    Model(Box<ModelSchema>),
}

#[derive(Serialize, ToSchema)]
#[schema(as = GivenDesign)]
#[serde(deny_unknown_fields)]
pub struct GivenDesignSchema {
    /// Id of a finished design.
    excitation: String,
    /// Periods recorded.
    #[schema(default = 1, minimum = 1)]
    periods: Option<u32>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = GivenTrajectory)]
#[serde(deny_unknown_fields)]
pub struct GivenTrajectorySchema {
    coefficients: crate::io::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    offset: Vec<f64>,
    fundamental_hz: f64,
    /// Periods recorded.
    #[schema(default = 1, minimum = 1)]
    periods: Option<u32>,
}
