//! From a seed to the files of an input.

use super::bases;
use super::bytes;
use super::dice::Dice;
use super::json::Node;
use super::table::Table;
use super::target::Target;
use super::xml::Element;
use serde_json::{Value, json};
use std::path::Path;

#[derive(Debug, Clone, PartialEq)]
pub enum Document {
    Json(Node),
    Toml(Node),
    Xml(Element),
    Table(Table),
    Plain(Vec<u8>),
}

impl Document {
    fn mutate(&mut self, dice: &mut Dice) {
        match self {
            Self::Json(node) | Self::Toml(node) => node.mutate(dice),
            Self::Xml(element) => element.mutate(dice),
            Self::Table(table) => table.mutate(dice),
            Self::Plain(text) => bytes::mutate(text, dice),
        }
    }

    fn render(&self) -> Vec<u8> {
        match self {
            Self::Json(node) => node.render().into_bytes(),
            // Strings, numbers, booleans and lists of them are written alike in TOML and JSON.
            Self::Toml(Node::Fields(fields)) => fields
                .iter()
                .flat_map(|(n, v)| format!("{n} = {}\n", v.render()).into_bytes())
                .collect(),
            Self::Toml(node) => node.render().into_bytes(),
            Self::Xml(element) => element.render().into_bytes(),
            Self::Table(table) => table.render(),
            Self::Plain(bytes) => bytes.clone(),
        }
    }
}

/// An input before it is written out.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    parts: Vec<(&'static str, Document)>,
    /// Of the command line, beside those that name files.
    arguments: Vec<&'static str>,
    /// Changes to the bytes of parts, made last.
    last: Vec<(usize, u64)>,
}

impl Draft {
    pub fn new(parts: Vec<(&'static str, Document)>) -> Self {
        Self {
            parts,
            arguments: Vec::new(),
            last: Vec::new(),
        }
    }

    pub fn with_arguments(self, arguments: &[&'static str]) -> Self {
        Self {
            arguments: arguments.to_vec(),
            ..self
        }
    }

    /// One change: `gene` says where and which.
    fn apply(&mut self, gene: u64) {
        let mut dice = Dice::new(gene);
        let part = dice.below(self.parts.len());
        match dice.chance(0.06) {
            true => self.last.push((part, dice.bits())),
            false => self.parts[part].1.mutate(&mut dice),
        }
    }

    /// Names and contents of the files.
    pub fn render(&self) -> Vec<(&'static str, Vec<u8>)> {
        let mut files: Vec<_> = self.parts.iter().map(|(name, document)| (*name, document.render())).collect();
        for &(part, gene) in &self.last {
            bytes::mutate(&mut files[part].1, &mut Dice::new(gene));
        }
        if let Some((_, request)) = files.iter_mut().find(|(name, _)| *name == bases::REQUEST) {
            bound_search(request);
        }
        if !self.arguments.is_empty() {
            files.push(("arguments", self.arguments.join("\n").into_bytes()));
        }
        files
    }
}

/// A search may take the time that it is given, a day if so asked: nobody waits for that here.
fn bound_search(request: &mut Vec<u8>) {
    let Ok(mut document) = serde_json::from_slice::<Value>(request) else {
        return;
    };
    if document.get("fourier").is_none() {
        return;
    }
    let Some(fields) = document.as_object_mut() else { return };
    let search = fields.entry("search").or_insert_with(|| json!({}));
    let Some(search) = search.as_object_mut() else { return };
    let long = |field: &str, most: f64| search.get(field).and_then(Value::as_f64).is_none_or(|asked| asked > most);
    if long("time_limit_s", 0.5) && long("max_evaluations", 100.0) {
        // What is refused anyway, because it is text or below zero, stays.
        let accepted = |v: &Value| v.is_null() || v.as_f64().is_some_and(|v| v > 0.0);
        if search.get("time_limit_s").is_none_or(accepted) {
            search.insert("time_limit_s".into(), json!(0.3));
            *request = document.to_string().into_bytes();
        }
    }
}

/// An input as a list of changes to a base.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    pub target: Target,
    /// Any number: there are fewer bases.
    pub base: u64,
    pub genes: Vec<u64>,
}

impl Recipe {
    pub fn of_seed(target: Target, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let base = dice.bits();
        // Mostly few: what has many faults is refused for the first of them.
        let count = [1, 1, 1, 2, 2, 3, 4, 6][dice.below(8)];
        Self {
            target,
            base,
            genes: (0..count).map(|_| dice.bits()).collect(),
        }
    }

    pub fn draft(&self, bases: &[Draft]) -> Draft {
        let mut draft = bases[(self.base % bases.len() as u64) as usize].clone();
        self.genes.iter().for_each(|&gene| draft.apply(gene));
        draft
    }

    /// The same without one change.
    pub fn without(&self, index: usize) -> Self {
        let mut fewer = self.clone();
        fewer.genes.remove(index);
        fewer
    }

    pub fn to_json(&self) -> Value {
        json!({"target": self.target.name(), "base": self.base, "genes": self.genes})
    }

    pub fn from_json(value: &Value) -> Option<Self> {
        Some(Self {
            target: Target::named(value["target"].as_str()?)?,
            base: value["base"].as_u64()?,
            genes: value["genes"].as_array()?.iter().map(Value::as_u64).collect::<Option<_>>()?,
        })
    }
}

/// Writes the files of an input into an empty folder; their size in bytes.
pub fn write(files: &[(&str, Vec<u8>)], folder: &Path) -> u64 {
    for (name, content) in files {
        std::fs::write(folder.join(name), content).expect("temporary files can be written");
    }
    files.iter().map(|(_, content)| content.len() as u64).sum()
}
