//! The JSON model of an identification, read back.

use super::augmented::read_augmented;
use super::cursor::{Cursor, Findings};
use super::requests;
use super::robot::read_robot_rounded;
use crate::formats::models::{BaseRow, FinalModel, Missing};
use crate::model::{FieldProblem, INPUT_LIMITS, Rounding};
use crate::regression::Term;
use serde_json::Value;

impl FinalModel {
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
}

fn read(cursor: &Cursor) -> Option<FinalModel> {
    let fields = cursor.fields_of::<requests::Model>()?;
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
