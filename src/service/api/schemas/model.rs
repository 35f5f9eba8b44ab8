//! An identified model, with what tracing has added to it.

use super::robot::RobotOrName;
use serde::Serialize;
use utoipa::ToSchema;

/// The JSON model of an identification; a robot with parameters for every link does as well.
#[derive(Serialize, ToSchema)]
#[schema(as = Model)]
#[serde(deny_unknown_fields)]
pub struct ModelSchema {
    robot: RobotOrName,
    /// Constant torque of every joint (N·m or N).
    offsets: Option<Vec<f64>>,
    #[schema(value_type = Option<Vec<Object>>)]
    base_parameters: Option<Vec<String>>,
    /// What tracing has added; needed to tell what has changed since.
    augmented: Option<AugmentedModelSchema>,
    /// In words, what a URDF of this model does not hold.
    not_in_urdf: Option<Vec<String>>,
    /// By format, what it does not hold, in torque along the identification logs (N·m or N).
    #[schema(value_type = Option<Vec<Object>>)]
    formats: Option<Vec<String>>,
    /// Cut-off of the filter that the rows went through that it was identified from [Hz]; logs that it is held against go through none that is higher.
    band_hz: Option<f64>,
}

/// Effects with the base parameters they were fitted with, and how well all are known.
#[derive(Serialize, ToSchema)]
#[schema(as = AugmentedModel)]
pub struct AugmentedModelSchema {
    effects: Vec<AddedEffectSchema>,
    base_values: Vec<f64>,
    /// Inverse covariance of the base values, then of coefficients and free shapes effect by effect.
    information: Vec<Vec<f64>>,
    noise: Option<ModelNoiseSchema>,
}

/// Torque noise of the data, as white noise that hides slow signals as much.
#[derive(Serialize, ToSchema)]
#[schema(as = ModelNoise)]
#[serde(deny_unknown_fields)]
pub struct ModelNoiseSchema {
    /// Of every joint [N·m or N].
    std_dev: Vec<f64>,
    /// Rows per second that it is of.
    rate_hz: f64,
}

/// An effect with its values.
#[derive(Serialize, ToSchema)]
#[schema(as = AddedEffect)]
pub struct AddedEffectSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Vec<String>,
    /// Variant of the effect, from 0.
    form: u32,
    coefficients: Vec<f64>,
    shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[schema(value_type = Option<Vec<Object>>)]
    parameters: Option<Vec<String>>,
    /// Formula of a law, for people: what a reader takes is `form`.
    law: Option<crate::io::LawDocument>,
    /// Effects that the data do not exclude in its place.
    rivals: Option<Vec<RivalEffectSchema>>,
}

/// A rival of an effect, as it was fitted in its place.
#[derive(Serialize, ToSchema)]
#[schema(as = RivalEffect)]
pub struct RivalEffectSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Vec<String>,
    /// Variant of the effect, from 0.
    form: u32,
    coefficients: Vec<f64>,
    shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[schema(value_type = Option<Vec<Object>>)]
    parameters: Option<Vec<String>>,
    /// Formula of a law, for people: what a reader takes is `form`.
    law: Option<crate::io::LawDocument>,
    /// Twice the log of the evidence ratio in favour of the finding.
    evidence: f64,
    /// Base parameters of that fit.
    base_values: Vec<f64>,
    /// Information that its columns have in common with those of the model.
    cross: Vec<Vec<f64>>,
    /// Information of its own columns.
    own: Vec<Vec<f64>>,
}

/// How an identified model is handed out.
#[derive(Serialize, ToSchema)]
#[schema(rename_all = "lowercase")]
pub enum ModelFormat {
    Json,
    Urdf,
    Mjcf,
    Sdf,
    Csv,
    C,
    Python,
}
