//! The field `effects` of requests and robots: definitions, and names of the catalogue.

use super::cursor::{Cursor, Fields};
use super::own_effects::{read_effect, written};
use super::robot::NamedRobots;
use super::used_effects::{is_reference, read_used};
use crate::effects::OwnEffect;
use crate::model::{FieldProblem, INPUT_LIMITS, Robot};
use serde_json::{Value, json};
use std::sync::Arc;

/// The effects of the field `effects`, against `robot` where there is one; their names are none of those of `others`. Those that
/// are named are of the catalogue that `known` has.
pub(super) fn read_effects(
    fields: &Fields,
    robot: Option<&Robot>,
    others: &[Arc<OwnEffect>],
    known: &dyn NamedRobots,
) -> Vec<Arc<OwnEffect>> {
    let Some(list) = fields.nullable("effects") else {
        return Vec::new();
    };
    let items = list.items_up_to(INPUT_LIMITS.own_effects, "effects").unwrap_or_default();
    let mut names: Vec<String> = others.iter().map(|e| e.definition().name.clone()).collect();
    let mut effects = Vec::new();
    for item in &items {
        check_name_is_new(item, &mut names);
        let read = match is_reference(item.value()) {
            true => read_used(item, robot, known),
            false => read_effect(item, robot),
        };
        effects.extend(read.map(Arc::new));
    }
    effects
}

fn check_name_is_new(item: &Cursor, names: &mut Vec<String>) {
    let (name, pointer) = name_of(item);
    if names.contains(&name) {
        let detail = format!("`{name}` is the name of another own effect of the request or the robot");
        let problem = FieldProblem::new(pointer, detail);
        let remedy = match is_reference(item.value()) {
            true => format!("give this use a name of its own: {{\"use\": …, \"name\": \"{name}_2\"}}"),
            false => "give every effect a name of its own".to_string(),
        };
        item.findings().push(problem.with_hint(remedy));
    }
    if !name.is_empty() {
        names.push(name);
    }
}

/// What an element of `effects` is called, and where that stands.
fn name_of(item: &Cursor) -> (String, String) {
    let below = |field: &str| {
        let name = item.value().get(field)?.as_str()?;
        Some((name.to_string(), format!("{}/{field}", item.pointer())))
    };
    let whole = item
        .value()
        .as_str()
        .map(|name| (name.to_string(), item.pointer().to_string()));
    whole.or_else(|| below("name")).or_else(|| below("use")).unwrap_or_default()
}

/// Names of the catalogue that the field `effects` of a document has; of a list that is refused as too long, none.
pub fn effects_named(document: &Value) -> impl Iterator<Item = &str> {
    let list = document["effects"]
        .as_array()
        .filter(|list| list.len() <= INPUT_LIMITS.own_effects);
    list.into_iter()
        .flatten()
        .filter_map(|item| item.as_str().or_else(|| item["use"].as_str()))
}

/// Writes `effects`, as they were read, in the place of names in the field `effects`: what becomes of the catalogue does not
/// matter any more.
fn put_definitions(document: &mut Value, effects: &[Arc<OwnEffect>]) {
    let Some(list) = document.get_mut("effects").and_then(Value::as_array_mut) else {
        return;
    };
    for (item, effect) in list.iter_mut().zip(effects).filter(|(item, _)| is_reference(item)) {
        *item = json!(written(effect.definition()));
    }
}

/// The request with definitions in the place of names of effects, so that it means the same elsewhere and later.
pub(super) fn with_definitions(request: &Value, effects: &[Arc<OwnEffect>], of_robot: &[Arc<OwnEffect>]) -> Value {
    let mut request = request.clone();
    put_definitions(&mut request, effects);
    if let Some(robot) = request.get_mut("robot") {
        put_definitions(robot, of_robot);
    }
    request
}
