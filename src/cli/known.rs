//! What requests and robots call by name on the command line: robots that come with the program, and own effects from files.

use super::files;
use crate::app::Error;
use crate::documents::shipped::Shipped;
use crate::documents::{NamedRobots, RobotDocument, catalogue_effect};
use crate::formats::Parsed;
use crate::model::FieldProblem;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where own effects come from that are called by name.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct EffectArguments {
    /// Own effects that requests and robots call by name: a JSON file with one definition or a list of them, or the answer of GET
    /// /effects; may be given several times.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    effects: Vec<PathBuf>,
}

impl EffectArguments {
    /// Reads and checks the files.
    pub fn read(&self) -> Result<Known, Error> {
        let mut known = Known::default();
        self.effects.iter().try_for_each(|path| known.add(path))?;
        Ok(known)
    }
}

/// Robots of the program, and own effects by their names.
#[derive(Debug, Default)]
pub struct Known(BTreeMap<String, Value>);

impl Known {
    fn add(&mut self, path: &Path) -> Result<(), Error> {
        let parsed = files::parse_json(path)?;
        let mut problems = parsed.problems;
        for (pointer, definition) in definitions(parsed.value) {
            match self.insert(definition) {
                Ok(()) => {}
                Err(found) => problems.extend(found.into_iter().map(|p| FieldProblem {
                    pointer: format!("{pointer}{}", p.pointer),
                    ..p
                })),
            }
        }
        match problems.is_empty() {
            true => Ok(()),
            false => Err(files::in_file(path, Error::invalid("the list of effects", problems))),
        }
    }

    fn insert(&mut self, value: Value) -> Result<(), Vec<FieldProblem>> {
        let effect = catalogue_effect(&Parsed {
            value,
            problems: Vec::new(),
        })?;
        let document = json!(effect);
        match self.0.insert(effect.name.clone(), document) {
            None => Ok(()),
            Some(_) => {
                let problem = FieldProblem::new(
                    "/name",
                    format!("`{}` is the name of another effect of the files", effect.name),
                );
                Err(vec![problem.with_hint("give every effect a name of its own")])
            }
        }
    }
}

/// Definitions of a file with their places: of one, of a list, of what a server answers.
fn definitions(file: Value) -> Vec<(String, Value)> {
    let (place, list) = match file {
        Value::Array(list) => ("", list),
        Value::Object(mut fields) => match fields.remove("effects") {
            Some(Value::Array(list)) => ("/effects", list),
            Some(other) => return vec![("/effects".into(), other)],
            None => return vec![(String::new(), Value::Object(fields))],
        },
        other => return vec![(String::new(), other)],
    };
    let one = |(i, mut item): (usize, Value)| match item.get_mut("definition").map(Value::take) {
        Some(definition) => (format!("{place}/{i}/definition"), definition),
        None => (format!("{place}/{i}"), item),
    };
    list.into_iter().enumerate().map(one).collect()
}

impl NamedRobots for Known {
    fn named(&self, name: &str) -> Option<RobotDocument> {
        Shipped.named(name)
    }

    fn names(&self) -> Vec<String> {
        Shipped.names()
    }

    fn effect(&self, name: &str) -> Option<Value> {
        self.0.get(name).cloned()
    }

    fn effect_names(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}
