//! Effects of the catalogue, used by their names.

use super::cursor::{Cursor, Fields, Findings};
use super::identify_request::boolean;
use super::own_effects::read_kept;
use super::requests;
use super::robot::NamedRobots;
use crate::effects::{Definition, OwnEffect};
use crate::model::{FieldProblem, Robot};
use serde_json::Value;

/// Whether an element of `effects` names an effect of the catalogue.
pub(super) fn is_reference(value: &Value) -> bool {
    value.is_string() || value.get("use").is_some()
}

/// `"hose"`, or `{"use": "hose", "joint": "A4"}`, with the definition that `known` has.
pub(super) fn read_used(cursor: &Cursor, robot: Option<&Robot>, known: &dyn NamedRobots) -> Option<OwnEffect> {
    let fields = match cursor.value().is_string() {
        true => None,
        false => Some(cursor.fields_of::<requests::UsedEffect>()?),
    };
    let named = match &fields {
        None => cursor.clone(),
        Some(fields) => fields.required("use")?,
    };
    let of_use = fields.as_ref().map(read_parts).unwrap_or_default();
    let (definition, own_joint) = definition(&named, known)?;
    let called = definition.name.clone();
    let has_joint = of_use.joint.is_some();
    let Some(joint) = of_use.joint.or(own_joint) else {
        let hint = format!("state the joint: {{\"use\": \"{called}\", \"joint\": …}}");
        cursor.complain_with(format!("is `{called}` of the catalogue, which has no joint of its own"), hint);
        return None;
    };
    let definition = Definition {
        joint,
        name: of_use.name.unwrap_or(definition.name),
        declared: of_use.declared.unwrap_or(definition.declared),
        ..definition
    };
    let place = |p: FieldProblem| placed(p, cursor.pointer(), &called, has_joint);
    OwnEffect::new(definition, robot?)
        .map_err(|problems| cursor.findings().merge(problems.into_iter().map(place)))
        .ok()
}

/// What a use says itself.
#[derive(Default)]
struct OfUse {
    joint: Option<String>,
    name: Option<String>,
    declared: Option<bool>,
}

fn read_parts(fields: &Fields) -> OfUse {
    let text = |name: &str| fields.nullable(name).and_then(|c| c.string()).map(str::to_string);
    OfUse {
        joint: text("joint"),
        name: text("name"),
        declared: fields.nullable("declared").and_then(|c| boolean(&c)),
    }
}

/// What is wrong with a definition of the catalogue on this robot: where the use says it, at its field, else at the use.
fn placed(problem: FieldProblem, at: &str, called: &str, has_joint: bool) -> FieldProblem {
    match problem.pointer.as_str() {
        "/joint" if has_joint => FieldProblem {
            pointer: format!("{at}/joint"),
            ..problem
        },
        // That of the catalogue is one, and no other field has another.
        "/name" => FieldProblem {
            pointer: format!("{at}/name"),
            ..problem
        },
        within => FieldProblem {
            pointer: at.to_string(),
            detail: format!("is `{called}` of the catalogue, {within}: {}", problem.detail),
            ..problem
        },
    }
}

/// The definition that a name stands for, and its joint where it has one.
fn definition(cursor: &Cursor, known: &dyn NamedRobots) -> Option<(Definition, Option<String>)> {
    let name = cursor.string()?;
    let Some(document) = known.effect(name) else {
        unknown(cursor, name, &known.effect_names());
        return None;
    };
    // It was checked when it was kept: what is wrong with it is not the client's.
    let own = Findings::default();
    let read = read_kept(&Cursor::root(&document, &own)).filter(|_| own.is_empty());
    if read.is_none() {
        unreadable(cursor, name);
    }
    read
}

fn unknown(cursor: &Cursor, name: &str, names: &[String]) {
    if names.iter().any(|n| n == name) {
        unreadable(cursor, name);
    } else if names.is_empty() {
        cursor.complain_with(
            format!("is `{}`, and there is no catalogue of effects here", crate::formats::json::shortened(name)),
            "write the definition in its place; a server keeps a catalogue at /effects, the command line takes one with --effects FILE",
        );
    } else {
        let names: Vec<(&str, ())> = names.iter().map(|n| (n.as_str(), ())).collect();
        cursor.choice(&names);
    }
}

fn unreadable(cursor: &Cursor, name: &str) {
    cursor.complain_with(
        format!("is `{name}`, an effect of the catalogue whose stored document cannot be read"),
        "keep it anew under its name, or write the definition in its place",
    );
}
