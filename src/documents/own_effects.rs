//! Own effects of requests, robots and models.

use super::cursor::{Cursor, Fields};
use super::identify_request::boolean;
use super::requests;
use crate::effects::own::{ChannelVariable, MOST_PARAMETERS, ParameterDefinition};
use crate::effects::{Definition, OwnEffect};
use crate::model::{FieldProblem, INPUT_LIMITS, Robot};
use std::sync::Arc;

/// The effects of the field `effects`, against `robot` where there is one; their names are none of those of `others`.
pub(super) fn read_effects(fields: &Fields, robot: Option<&Robot>, others: &[Arc<OwnEffect>]) -> Vec<Arc<OwnEffect>> {
    let Some(list) = fields.nullable("effects") else {
        return Vec::new();
    };
    let items = list.items_up_to(INPUT_LIMITS.own_effects, "effects").unwrap_or_default();
    let mut names: Vec<String> = others.iter().map(|e| e.definition().name.clone()).collect();
    let mut effects = Vec::new();
    for item in &items {
        let name = item.value()["name"].as_str().unwrap_or_default().to_string();
        if names.contains(&name) {
            let detail = format!("`{name}` is the name of another own effect of the request or the robot");
            let problem = FieldProblem::new(format!("{}/name", item.pointer()), detail);
            item.findings().push(problem.with_hint("give every effect a name of its own"));
        }
        if !name.is_empty() {
            names.push(name);
        }
        effects.extend(read_effect(item, robot).map(Arc::new));
    }
    effects
}

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
    let text = |name: &str| fields.required(name).and_then(|c| c.string()).map(str::to_string);
    let (name, joint, expression) = (text("name"), text("joint"), text("expression"));
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
        joint: joint?,
        expression: expression?,
        parameters: parameters?.into_iter().collect::<Option<Vec<_>>>()?,
        channels: channels?,
        declared,
    })
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
