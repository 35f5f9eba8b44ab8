//! Definitions of own effects, as requests, robots, models and the catalogue have them.

use super::cursor::{Cursor, Fields, Findings};
use super::identify_request::boolean;
use super::requests;
use crate::effects::own::{ChannelVariable, MOST_CHARACTERS, MOST_PARAMETERS, ParameterDefinition};
use crate::effects::{Definition, OwnEffect};
use crate::formats::json::Parsed;
use crate::formats::mathml;
use crate::model::{FieldProblem, INPUT_LIMITS, Robot};

/// One effect. What the core finds wrong is placed below the cursor.
pub(super) fn read_effect(cursor: &Cursor, robot: Option<&Robot>) -> Option<OwnEffect> {
    let definition = read_definition(cursor)?;
    match OwnEffect::new(definition, robot?) {
        Ok(effect) => Some(effect),
        Err(problems) => {
            let placed = |p: FieldProblem| FieldProblem {
                pointer: format!("{}{}", cursor.pointer(), p.pointer),
                ..p
            };
            cursor.findings().merge(problems.into_iter().map(placed));
            None
        }
    }
}

fn read_definition(cursor: &Cursor) -> Option<Definition> {
    let fields = cursor.fields_of::<requests::OwnEffect>()?;
    let joint = fields.required("joint").and_then(|c| c.string()).map(str::to_string);
    let read = read_parts(&fields);
    Some(Definition { joint: joint?, ..read? })
}

/// All but the joint, which is empty.
fn read_parts(fields: &Fields) -> Option<Definition> {
    let text = |name: &str| fields.required(name).and_then(|c| c.string()).map(str::to_string);
    let (name, expression) = (text("name"), text("expression"));
    let items = fields
        .required("parameters")
        .and_then(|c| c.items_up_to(MOST_PARAMETERS, "parameters"));
    let parameters: Option<Vec<Option<ParameterDefinition>>> = items.map(|list| list.iter().map(read_parameter).collect());
    let channels = match fields.nullable("channels") {
        None => Some(Vec::new()),
        Some(list) => list
            .items_up_to(INPUT_LIMITS.channels, "channels")
            .and_then(|items| items.iter().map(read_channel).collect()),
    };
    let declared = fields.nullable("declared").and_then(|c| boolean(&c)).unwrap_or(false);
    Some(Definition {
        name: name?,
        joint: String::new(),
        expression: expression?,
        parameters: parameters?.into_iter().collect::<Option<Vec<_>>>()?,
        channels: channels?,
        declared,
    })
}

/// A definition of the catalogue, with the joint where it has one.
pub(super) fn read_kept(cursor: &Cursor) -> Option<(Definition, Option<String>)> {
    let fields = cursor.fields_of::<requests::CatalogueEffect>()?;
    let given = fields.nullable("joint");
    let joint = given.as_ref().and_then(|c| c.string()).map(str::to_string);
    let read = read_parts(&fields)?;
    (given.is_some() == joint.is_some()).then_some((read, joint))
}

/// Reads an effect that is to be kept in a catalogue, and checks what needs no robot.
///
/// # Errors
/// Everything that is wrong with it.
pub fn catalogue_effect(parsed: &Parsed) -> Result<requests::CatalogueEffect, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read_kept(&Cursor::root(&parsed.value, &findings));
    if let Some((definition, joint)) = &read {
        let joint = joint.clone().unwrap_or_default();
        findings.merge(
            Definition {
                joint,
                ..definition.clone()
            }
            .faults(),
        );
    }
    match read {
        Some((definition, joint)) if findings.is_empty() => Ok(kept(&definition, joint)),
        _ => Err(findings.into_list()),
    }
}

impl requests::CatalogueEffect {
    /// The formula as MathML; `None` where it cannot be set, or is longer than any that is accepted.
    pub fn mathml(&self) -> Option<String> {
        let short = self.expression.chars().count() <= MOST_CHARACTERS;
        short.then(|| mathml(&self.expression)).flatten()
    }
}

/// The definition as a catalogue has it.
fn kept(definition: &Definition, joint: Option<String>) -> requests::CatalogueEffect {
    let requests::OwnEffect {
        name,
        expression,
        parameters,
        channels,
        declared,
        ..
    } = written(definition);
    requests::CatalogueEffect {
        name,
        joint,
        expression,
        parameters,
        channels,
        declared,
    }
}

fn read_channel(cursor: &Cursor) -> Option<ChannelVariable> {
    let fields = cursor.fields_of::<requests::OwnChannel>()?;
    let name = fields.required("name").and_then(|c| c.string()).map(str::to_string);
    let unit = fields
        .nullable("unit")
        .and_then(|c| c.string())
        .map_or_else(|| "1".into(), str::to_string);
    let reference = fields.required("reference").and_then(|c| c.number());
    Some(ChannelVariable {
        name: name?,
        unit,
        reference: reference?,
    })
}

fn read_parameter(cursor: &Cursor) -> Option<ParameterDefinition> {
    let fields = cursor.fields_of::<requests::OwnParameter>()?;
    let text = |name: &str| fields.required(name).and_then(|c| c.string()).map(str::to_string);
    let (name, unit) = (text("name"), text("unit"));
    let number = |name: &str| fields.nullable(name).and_then(|c| c.number());
    let (low, high) = (number("low"), number("high"));
    Some(ParameterDefinition {
        name: name?,
        unit: unit?,
        low,
        high,
    })
}

/// The definition as a request has it.
pub(super) fn written(definition: &Definition) -> requests::OwnEffect {
    let parameter = |p: &ParameterDefinition| requests::OwnParameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        low: p.low,
        high: p.high,
    };
    let channel = |c: &ChannelVariable| requests::OwnChannel {
        name: c.name.clone(),
        unit: Some(c.unit.clone()),
        reference: c.reference,
    };
    let channels: Vec<requests::OwnChannel> = definition.channels.iter().map(channel).collect();
    requests::OwnEffect {
        channels: (!channels.is_empty()).then_some(channels),
        name: definition.name.clone(),
        joint: definition.joint.clone(),
        expression: definition.expression.clone(),
        parameters: definition.parameters.iter().map(parameter).collect(),
        declared: Some(definition.declared),
    }
}
