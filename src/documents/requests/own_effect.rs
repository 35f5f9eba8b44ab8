//! Effects with formulas of their own, and those of a catalogue.

use serde::{Deserialize, Serialize};

/// An effect that a formula defines: a torque that is added to one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({"name": "counterbalance", "joint": "A2", "expression": "k*sin(q2 - q0)",
    "parameters": [{"name": "k", "unit": "N m", "low": 0}, {"name": "q0", "unit": "rad"}], "declared": false})))]
#[serde(deny_unknown_fields)]
pub struct OwnEffect {
    /// What findings call it: a letter, then letters, digits, `_` and `-`; no effect of the program.
    pub name: String,
    /// Name of the joint whose torque it adds to.
    pub joint: String,
    /// The torque that it adds [N·m or N]: `q1`, `qd1`, `qdd1` are position, speed and acceleration of the first joint (`q_A1` by
    /// its name), `q`, `qd`, `qdd` those of `joint`; `+ - * / ^`, parentheses, `sin cos tan tanh exp ln log sqrt abs sign`, `pi`.
    /// `-x^2` is `-(x^2)`; `log` is the natural logarithm. One parameter at least must be a factor.
    pub expression: String,
    /// Every other name in the expression.
    pub parameters: Vec<OwnParameter>,
    /// Further measured quantities in the expression, named as in `columns.channels`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<OwnChannel>, required = false))]
    pub channels: Option<Vec<OwnChannel>>,
    /// Whether it belongs to the model from the start; otherwise the data decide.
    #[cfg_attr(feature = "service", schema(default = false))]
    pub declared: Option<bool>,
}

/// An own effect, or one of the catalogue by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum OwnEffectOrName {
    /// Name of an effect of the catalogue, as it stands there.
    Name(String),
    /// An effect of the catalogue, on a joint or under a name of its own.
    Used(UsedEffect),
    /// The definition in full.
    Effect(OwnEffect),
}

/// An effect of the catalogue, used with a joint, a name or a part of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({"use": "hose", "joint": "A4"})))]
#[serde(deny_unknown_fields)]
pub struct UsedEffect {
    /// Its name in the catalogue.
    #[serde(rename = "use")]
    pub effect: String,
    /// Name of the joint whose torque it adds to; that of the catalogue if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub joint: Option<String>,
    /// What findings call it; its name in the catalogue if left out. Two uses need two names.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub name: Option<String>,
    /// Whether it belongs to the model from the start; as in the catalogue if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = bool, required = false))]
    pub declared: Option<bool>,
}

/// An own effect as the catalogue keeps it: as in a request, with or without a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({"name": "hose", "expression": "k*q + c",
    "parameters": [{"name": "k", "unit": "N m/rad", "low": 0}, {"name": "c", "unit": "N m"}]})))]
#[serde(deny_unknown_fields)]
pub struct CatalogueEffect {
    /// What requests and findings call it: a letter, then letters, digits, `_` and `-`; no effect of the program.
    pub name: String,
    /// Name of the joint whose torque it adds to; without one, every use states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub joint: Option<String>,
    /// The torque that it adds [N·m or N], as in `OwnEffect`; `q`, `qd`, `qdd` are position, speed and acceleration of the joint
    /// that it acts on.
    pub expression: String,
    /// Every other name in the expression.
    pub parameters: Vec<OwnParameter>,
    /// Further measured quantities in the expression, named as in `columns.channels`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<OwnChannel>, required = false))]
    pub channels: Option<Vec<OwnChannel>>,
    /// Whether it belongs to the model from the start, unless a use says otherwise.
    #[cfg_attr(feature = "service", schema(default = false))]
    pub declared: Option<bool>,
}

/// A further measured quantity in an own effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct OwnChannel {
    /// Name of the channel, in the expression and in `columns.channels`.
    pub name: String,
    /// Unit of its values; `1` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub unit: Option<String>,
    /// Value that is taken along a motion that it was not measured on: a design, a log without it, an export.
    pub reference: f64,
}

/// A parameter of an own effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct OwnParameter {
    /// Name in the expression.
    pub name: String,
    /// SI unit without prefix, factors side by side: `N m/rad`; `1` for a number.
    #[cfg_attr(feature = "service", schema(example = "N m/rad"))]
    pub unit: String,
    /// Smallest value. Needed where the expression is not linear in the parameter, unless it is an angle.
    pub low: Option<f64>,
    /// Largest value.
    pub high: Option<f64>,
}
