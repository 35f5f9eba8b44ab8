//! The identified model in the formats of simulators and controllers: bodies and the effects that were found, as far as a format holds them.
//!
//! Every format is made from the JSON model, so that a stored model leaves in any of them. What a format cannot hold is reported by the
//! torque that is missing in it along the identification logs ([`Missing`]), in the JSON model and at the top of the file.

mod effects_held;
mod missing;
mod mjcf;
mod python;
mod sdf;
mod source;
mod source_c;
mod source_effects;
mod source_memory;
mod table;
mod urdf_patch;
mod xml;

pub use missing::{Missing, MissingEffect};
pub use urdf_patch::Patched;
pub(super) use xml::comment;

use super::augmented_document::read_augmented;
use super::cursor::{Cursor, Findings};
use super::model_document::{urdf, with_comment};
use super::robot::read_robot_rounded;
use crate::model::{FieldProblem, INPUT_LIMITS, Robot, Rounding};
use crate::regression::Term;
use serde_json::Value;
use std::path::Path;

/// How an identified model is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelFormat {
    /// All of it, as `validate` takes it.
    Json,
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
    pub const ALL: [(&'static str, Self); 7] = [
        ("json", Self::Json),
        ("urdf", Self::Urdf),
        ("mjcf", Self::Mjcf),
        ("sdf", Self::Sdf),
        ("csv", Self::Csv),
        ("c", Self::C),
        ("python", Self::Python),
    ];

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
#[derive(Debug, Clone, PartialEq)]
struct BaseRow {
    name: String,
    expression: String,
    value: Option<f64>,
    std_dev: Option<f64>,
    unit: String,
}

/// An identified model: every link a body, and the effects found.
#[derive(Debug, Clone)]
pub struct FinalModel {
    /// Every joint has a prior: what was identified.
    pub robot: Robot,
    pub terms: Vec<Term>,
    /// Of every term, the standard deviations of its reported parameters; empty where they are not known.
    deviations: Vec<Vec<Option<f64>>>,
    base_parameters: Vec<BaseRow>,
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

    /// From the JSON model of an identification, with numbers as they are written.
    ///
    /// # Errors
    /// Everything that is wrong with it; links without mass and inertia.
    pub fn read(value: &Value) -> Result<Self, Vec<FieldProblem>> {
        let findings = Findings::new(Vec::new());
        let read = read(&Cursor::root(value, &findings));
        match read {
            Some(model) if findings.is_empty() => Ok(model),
            _ => Err(findings.into_list()),
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

const FIELDS: &[&str] = super::validate_request::MODEL_FIELDS;

fn read(cursor: &Cursor) -> Option<FinalModel> {
    let fields = cursor.fields(FIELDS)?;
    let of_robot = fields.required("robot")?;
    let robot = read_robot_rounded(&of_robot, Rounding::AsWritten)?.robot;
    for joint in robot.joints().iter().filter(|j| j.prior.is_none()) {
        of_robot.complain_with(
            format!("the link behind joint `{}` has no mass and inertia", joint.name),
            "give the JSON model of an identification that found physical parameters",
        );
    }
    let offsets = fields.nullable("offsets").and_then(|c| c.numbers(Some(robot.joint_count())));
    let augmented = fields.nullable("augmented");
    let terms = match &augmented {
        Some(c) => read_augmented(c, &robot)?.0.terms,
        None => offsets
            .iter()
            .flatten()
            .enumerate()
            .map(|(joint, &size)| Term::constant(joint, size))
            .collect(),
    };
    let deviations = match &augmented {
        Some(c) => c.value()["effects"]
            .as_array()
            .into_iter()
            .flatten()
            .map(deviations)
            .collect(),
        None => vec![Vec::new(); terms.len()],
    };
    let rows = fields.nullable("base_parameters");
    let rows = rows.and_then(|c| c.items_up_to(12 * INPUT_LIMITS.joints, "base parameters"));
    let missing = fields.nullable("formats").map_or(Some(Vec::new()), |c| {
        let read: Result<Vec<Missing>, _> = serde_json::from_value(c.value().clone());
        let list = read.ok().filter(|list| list.iter().all(|m| m.is_of(robot.joint_count())));
        if list.is_none() {
            c.complain_with(
                "is not what an identification writes",
                "leave it out: the files then have no figures",
            );
        }
        list
    })?;
    let model = FinalModel {
        base_parameters: rows.into_iter().flatten().map(|c| base_row(c.value())).collect(),
        robot,
        terms,
        deviations,
        missing,
    };
    if let Err(e) = model.try_absorbed() {
        cursor.complain(format!("has effects that make no robot of it: {e}"));
    }
    Some(model)
}

fn deviations(effect: &Value) -> Vec<Option<f64>> {
    let parameters = effect["parameters"].as_array().into_iter().flatten();
    parameters.map(|p| p["std_dev"].as_f64()).collect()
}

fn base_row(row: &Value) -> BaseRow {
    let text = |field: &str| row[field].as_str().unwrap_or_default().to_string();
    BaseRow {
        name: text("name"),
        expression: text("expression"),
        value: row["value"].as_f64(),
        std_dev: row["std_dev"].as_f64(),
        unit: text("unit"),
    }
}
