//! An identified model, with what tracing has added to it.

use super::own_effect::OwnEffect;
use super::robot::RobotOrName;
use crate::formats::Missing;
use crate::formats::models::BaseRow;
use serde::{Deserialize, Serialize};

/// The JSON model of an identification; a robot with parameters for every link does as well.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// The robot, in full or by name.
    pub robot: RobotOrName,
    /// Constant torque of every joint (N·m or N).
    pub offsets: Option<Vec<f64>>,
    /// Base parameters by name with value and unit, as an identification reports them; left out if physical parameters are the
    /// model.
    #[cfg_attr(feature = "service", schema(value_type = Option<Vec<Object>>))]
    pub base_parameters: Option<Vec<BaseRow>>,
    /// What tracing has added; needed to tell what has changed since.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub augmented: Option<AugmentedModel>,
    /// In words, what a URDF of this model does not hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_in_urdf: Option<Vec<String>>,
    /// By format, what it does not hold, in torque along the identification logs (N·m or N).
    #[cfg_attr(feature = "service", schema(value_type = Option<Vec<Object>>))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub formats: Option<Vec<Missing>>,
    /// Cut-off of the filter that the rows went through that it was identified from (Hz); logs that it is held against go through
    /// none that is higher.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band_hz: Option<f64>,
}

/// Effects with the base parameters they were fitted with, and how well all are known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct AugmentedModel {
    /// The effects of the model; empty for the declared model.
    pub effects: Vec<AddedEffect>,
    /// Values of the base parameters beside the effects, in the order of the columns of `Y_b`, in SI units.
    pub base_values: Vec<f64>,
    /// Inverse covariance of the base values, then of coefficients and free shapes effect by effect.
    pub information: Vec<Vec<f64>>,
    /// Noise and covariance of the estimates; without it the model is used without standard deviations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<ModelNoise>,
}

/// Torque noise of the data, as white noise that hides slow signals as much.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ModelNoise {
    /// Of every joint [N·m or N].
    pub std_dev: Vec<f64>,
    /// Rows per second that it is of.
    pub rate_hz: f64,
}

/// A value of an effect as it is reported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelParameter {
    /// Name within the effect, such as `stiffness`.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// SI; `1` for pure numbers.
    pub unit: String,
    /// In `unit`; null where the data do not determine it, absent of rivals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_dev: Option<Option<f64>>,
}

/// An effect with its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct AddedEffect {
    /// Code of the effect, or the name of an own one.
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// Variant of the effect, from 0.
    pub form: u32,
    /// Linear parameters of the effect, in SI units, in its own order.
    pub coefficients: Vec<f64>,
    /// Nonlinear parameters of the effect, in SI units, in its own order.
    pub shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    pub free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    pub bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[cfg_attr(feature = "service", schema(value_type = Option<Vec<Object>>))]
    pub parameters: Option<Vec<ModelParameter>>,
    /// Formula of a law or own effect, for people: what a reader takes is `form`, or `definition`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<crate::documents::LawDocument>,
    /// Definition of an own effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub definition: Option<OwnEffect>,
    /// Effects that the data do not exclude in its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rivals: Option<Vec<RivalEffect>>,
}

/// A rival of an effect, as it was fitted in its place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RivalEffect {
    /// Code of the effect, or the name of an own one.
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// Variant of the effect, from 0.
    pub form: u32,
    /// Linear parameters of the effect, in SI units, in its own order.
    pub coefficients: Vec<f64>,
    /// Nonlinear parameters of the effect, in SI units, in its own order.
    pub shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    pub free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    pub bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[cfg_attr(feature = "service", schema(value_type = Option<Vec<Object>>))]
    pub parameters: Option<Vec<ModelParameter>>,
    /// Formula of a law or own effect, for people: what a reader takes is `form`, or `definition`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<crate::documents::LawDocument>,
    /// Definition of an own effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub definition: Option<OwnEffect>,
    /// Twice the log of the evidence ratio in favour of the finding.
    pub evidence: f64,
    /// Base parameters of that fit.
    pub base_values: Vec<f64>,
    /// Information that its columns have in common with those of the model.
    pub cross: Vec<Vec<f64>>,
    /// Information of its own columns.
    pub own: Vec<Vec<f64>>,
}

/// How an identified model is handed out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
pub enum ModelFormat {
    /// The model with deviations, as `validate` and designs read it.
    Json,
    /// URDF: bodies, friction and limits.
    Urdf,
    /// MJCF of MuJoCo.
    Mjcf,
    /// SDF of Gazebo.
    Sdf,
    /// A table of parameters with units and deviations.
    Csv,
    /// Source in C, without dependencies.
    C,
    /// Source in Python, with NumPy.
    Python,
}
