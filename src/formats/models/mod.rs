//! The identified model in the formats of simulators and controllers: bodies and the effects that were found, as far as a format
//! holds them.
//!
//! Every format is made from the JSON model, so that a stored model leaves in any of them. What a format cannot hold is reported
//! by the torque that is missing in it along the identification logs ([`Missing`]), in the JSON model and at the top of the file.

mod effects_held;
pub(crate) mod frames;
mod missing;
mod mjcf;
mod python;
mod sdf;
mod source;
mod source_c;
mod source_channels;
mod source_effects;
mod source_memory;
mod table;
mod urdf;
mod urdf_patch;
mod xml;

pub use missing::{Missing, MissingEffect};
pub use urdf_patch::Patched;
use xml::comment;

use crate::model::Robot;
use crate::regression::Term;
pub use frames::urdf_gravity;
use std::path::Path;
pub use urdf::urdf;
use urdf::with_comment;

/// How an identified model is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelFormat {
    /// All of it, as `validate` takes it.
    Json,
    /// Robot description of ROS.
    Urdf,
    /// MuJoCo.
    Mjcf,
    /// Gazebo.
    Sdf,
    /// Base parameters, bodies and effects as one table.
    Csv,
    /// Inverse dynamics, gravity torques and mass matrix as C99.
    C,
    /// The same as Python, without NumPy.
    Python,
}

impl ModelFormat {
    /// Names of the formats, as requests have them.
    pub const ALL: [(&'static str, Self); 7] = [
        ("json", Self::Json),
        ("urdf", Self::Urdf),
        ("mjcf", Self::Mjcf),
        ("sdf", Self::Sdf),
        ("csv", Self::Csv),
        ("c", Self::C),
        ("python", Self::Python),
    ];

    /// Name of the format, as requests have it.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, f)| *f == self).expect("is in the list").0
    }

    /// By the ending of a file's name; JSON where it is none of those known.
    pub fn of_file(path: &Path) -> Self {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("urdf") => Self::Urdf,
            Some("xml" | "mjcf") => Self::Mjcf,
            Some("sdf" | "world") => Self::Sdf,
            Some("csv") => Self::Csv,
            Some("c" | "h") => Self::C,
            Some("py") => Self::Python,
            _ => Self::Json,
        }
    }

    /// Type of the content, and ending of a file.
    pub fn kind(self) -> (&'static str, &'static str) {
        match self {
            Self::Json => ("application/json", "json"),
            Self::Urdf => ("application/xml", "urdf"),
            Self::Mjcf => ("application/xml", "xml"),
            Self::Sdf => ("application/xml", "sdf"),
            Self::Csv => ("text/csv; charset=utf-8", "csv"),
            Self::C => ("text/x-c; charset=utf-8", "c"),
            Self::Python => ("text/x-python; charset=utf-8", "py"),
        }
    }
}

/// A base parameter as the JSON model states it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BaseRow {
    /// Name after the standard parameter that leads the combination, such as `ZZR1`.
    pub name: String,
    /// Linear combination of standard parameters that it stands for; lengths in m.
    pub expression: String,
    /// Estimate, in `unit`; nothing where the log does not determine it.
    pub value: Option<f64>,
    /// Standard deviation of the estimate, in `unit`; nothing where the log does not determine it.
    pub std_dev: Option<f64>,
    /// Unit of the value, such as `kg m^2`.
    pub unit: String,
}

/// An identified model: every link a body, and the effects found.
#[derive(Debug, Clone)]
pub struct FinalModel {
    /// Every joint has a prior: what was identified.
    pub robot: Robot,
    /// The effects of the model with their values.
    pub terms: Vec<Term>,
    /// Of every term, the standard deviations of its reported parameters; empty where they are not known.
    pub(crate) deviations: Vec<Vec<Option<f64>>>,
    pub(crate) base_parameters: Vec<BaseRow>,
    /// By format, what it does not hold; empty where the model does not say so.
    pub missing: Vec<Missing>,
}

impl FinalModel {
    /// A model that no identification has described further.
    pub fn new(robot: Robot, terms: Vec<Term>) -> Self {
        Self {
            deviations: vec![Vec::new(); terms.len()],
            robot,
            terms,
            base_parameters: Vec::new(),
            missing: Vec::new(),
        }
    }

    /// The file in a format other than JSON, which is the model itself. What is not in it stands at its top.
    pub fn text(&self, format: ModelFormat) -> String {
        let remarks = self.remarks(format.name());
        match format {
            ModelFormat::Json => String::new(),
            ModelFormat::Urdf => with_comment(urdf(&self.absorbed()), &remarks),
            ModelFormat::Mjcf => self.mjcf(&remarks),
            ModelFormat::Sdf => self.sdf(&remarks),
            ModelFormat::Csv => self.csv(),
            ModelFormat::C => self.source().c(&remarks),
            ModelFormat::Python => self.source().python(&remarks),
        }
    }
}
