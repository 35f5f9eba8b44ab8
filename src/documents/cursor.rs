//! Walking a JSON document while collecting all that is wrong with it.

use crate::formats::json::{MOST_FINDINGS, escaped, shortened};
use crate::model::{FieldProblem, counted};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};
use serde_aux::serde_introspection::serde_introspect;
use serde_json::{Map, Value};
use std::cell::{Cell, RefCell};

/// What is wrong with a document, in the order in which it was found.
#[derive(Debug, Default)]
pub struct Findings {
    list: RefCell<Vec<FieldProblem>>,
    /// Those that were not kept.
    further: Cell<usize>,
}

impl Findings {
    /// Starts a list with the problems that are known before the document is walked.
    pub fn new(known: Vec<FieldProblem>) -> Self {
        let findings = Self::default();
        known.into_iter().for_each(|p| findings.push(p));
        findings
    }

    /// Keeps the first of many: a document of a million mistakes costs no more than one of a hundred.
    pub fn push(&self, problem: FieldProblem) {
        if self.is_full() {
            self.further.set(self.further.get() + 1);
        } else {
            self.list.borrow_mut().push(problem);
        }
    }

    fn is_full(&self) -> bool {
        self.list.borrow().len() >= MOST_FINDINGS
    }

    /// Whether no problem has been found so far.
    pub fn is_empty(&self) -> bool {
        self.list.borrow().is_empty()
    }

    /// Adds findings of the core, made on stand-ins where fields were unreadable: whatever lies at, below or above a place that
    /// is already complained about is a consequence, not a finding.
    pub fn merge(&self, problems: impl IntoIterator<Item = FieldProblem>) {
        let before: Vec<String> = self.list.borrow().iter().map(|p| p.pointer.clone()).collect();
        for problem in problems {
            if !before.iter().any(|known| related(known, &problem.pointer)) {
                self.push(problem);
            }
        }
    }

    /// Whether something at `pointer` or below it is wrong; true also where so much is wrong that nobody knows.
    pub fn within(&self, pointer: &str) -> bool {
        self.further.get() > 0 || self.list.borrow().iter().any(|p| starts_with_pointer(&p.pointer, pointer))
    }

    /// The list, cut at 100 entries with a word about the rest.
    pub fn into_list(self) -> Vec<FieldProblem> {
        let (mut list, more) = (self.list.into_inner(), self.further.get());
        if more > 0 {
            list.push(FieldProblem::new("", format!("has {more} further problems of these kinds")));
        }
        list
    }
}

fn starts_with_pointer(longer: &str, shorter: &str) -> bool {
    longer
        .strip_prefix(shorter)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

fn related(one: &str, other: &str) -> bool {
    starts_with_pointer(one, other) || starts_with_pointer(other, one)
}

/// A value in a document and the place it stands in.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    value: &'a Value,
    pointer: String,
    findings: &'a Findings,
}

/// The fields of an object whose names have been checked.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    map: &'a Map<String, Value>,
    pointer: String,
    findings: &'a Findings,
    /// The names that it may have, where a type says so.
    known: Option<&'static [&'static str]>,
}

impl<'a> Cursor<'a> {
    /// A cursor at the top of a document; its pointer is the empty string.
    pub fn root(value: &'a Value, findings: &'a Findings) -> Self {
        Self {
            value,
            pointer: String::new(),
            findings,
        }
    }

    /// The JSON value under the cursor.
    pub fn value(&self) -> &'a Value {
        self.value
    }

    /// JSON pointer (RFC 6901) from the top of the document to this value.
    pub fn pointer(&self) -> &str {
        &self.pointer
    }

    /// The list that every cursor of this document adds its problems to.
    pub fn findings(&self) -> &'a Findings {
        self.findings
    }

    /// Adds a problem at this pointer, without a remedy.
    pub fn complain(&self, detail: impl Into<String>) {
        self.findings.push(FieldProblem::new(&self.pointer, detail));
    }

    /// Adds a problem at this pointer, with the remedy in `hint`.
    pub fn complain_with(&self, detail: impl Into<String>, hint: impl Into<String>) {
        self.findings.push(FieldProblem::new(&self.pointer, detail).with_hint(hint));
    }

    fn expected(&self, what: &str) {
        self.complain(format!("is {}, expected {what}", described(self.value)));
    }

    /// The fields of an object of type `T`; every name that is none of them is a finding.
    pub fn fields_of<T: for<'de> Deserialize<'de>>(&self) -> Option<Fields<'a>> {
        let known = serde_introspect::<T>();
        let fields = self.fields(known)?;
        Some(Fields {
            known: Some(known),
            ..fields
        })
    }

    /// The fields of an object; every name that is not `known` is a finding.
    pub fn fields(&self, known: &[&str]) -> Option<Fields<'a>> {
        let Value::Object(map) = self.value else {
            self.expected("an object");
            return None;
        };
        for name in map.keys().filter(|name| !known.contains(&name.as_str())) {
            if self.findings.is_full() {
                self.findings.push(FieldProblem::new("", ""));
                continue;
            }
            let problem = FieldProblem::new(
                format!("{}/{}", self.pointer, escaped(name)),
                "is not a field of this document",
            );
            self.findings.push(problem.with_hint(suggestion(name, known)));
        }
        Some(Fields {
            map,
            pointer: self.pointer.clone(),
            findings: self.findings,
            known: None,
        })
    }

    /// A cursor for each item of an array; a problem and nothing for any other type.
    pub fn items(&self) -> Option<Vec<Cursor<'a>>> {
        let Value::Array(items) = self.value else {
            self.expected("an array");
            return None;
        };
        let item = |(i, value)| Cursor {
            value,
            pointer: format!("{}/{i}", self.pointer),
            findings: self.findings,
        };
        Some(items.iter().enumerate().map(item).collect())
    }

    /// The items of a list that has no more than `most`; `what` names them in the error. A longer list is not looked into.
    pub fn items_up_to(&self, most: usize, what: &str) -> Option<Vec<Cursor<'a>>> {
        if let Value::Array(items) = self.value
            && items.len() > most
        {
            self.complain(format!("has {} {what}, the most accepted is {most}", items.len()));
            return None;
        }
        self.items()
    }

    /// The text of a string; a problem and nothing for any other type.
    pub fn string(&self) -> Option<&'a str> {
        let text = self.value.as_str();
        if text.is_none() {
            self.expected("a string");
        }
        text
    }

    /// A finite number; a problem and nothing for any other type.
    pub fn number(&self) -> Option<f64> {
        let number = self.value.as_f64();
        if number.is_none() {
            match self.value.as_str().is_some_and(|s| s.trim().parse::<f64>().is_ok()) {
                true => self.complain_with("is a string, expected a number", "take the quotation marks away"),
                false => self.expected("a number"),
            }
        }
        number
    }

    /// A whole number from `least` to `most`.
    pub fn whole(&self, least: u64, most: u64) -> Option<u64> {
        let number = self.number()?;
        // 2.0 is a whole number too: many programs write all their numbers that way.
        let whole = self
            .value
            .as_u64()
            .or((number.fract() == 0.0 && (0.0..9e15).contains(&number)).then_some(number as u64));
        match whole {
            Some(v) if (least..=most).contains(&v) => Some(v),
            _ => {
                self.complain(format!("is {number}, expected a whole number from {least} to {most}"));
                None
            }
        }
    }

    /// As many numbers as `length` says, any number of them for `None`.
    pub fn numbers(&self, length: Option<usize>) -> Option<Vec<f64>> {
        if let (Some(length), Value::Array(items)) = (length, self.value)
            && items.len() != length
        {
            self.complain(format!("has {}, expected {length}", counted(items.len(), "value")));
            return None;
        }
        let items = self.items()?;
        // All are read before the first failure ends it: every wrong number is a finding.
        let read: Vec<Option<f64>> = items.iter().map(Cursor::number).collect();
        read.into_iter().collect()
    }

    /// Three numbers.
    pub fn vector(&self) -> Option<nalgebra::Vector3<f64>> {
        self.numbers(Some(3)).map(|v| nalgebra::Vector3::from_column_slice(&v))
    }

    /// One of the words that the enumeration `T` is written with.
    pub fn word<T: for<'de> Deserialize<'de>>(&self) -> Option<T> {
        let word = self.string()?;
        let written: StrDeserializer<Error> = word.into_deserializer();
        let read = T::deserialize(written).ok();
        if read.is_none() {
            self.complain_with(format!("is `{}`", shortened(word)), suggestion(word, serde_introspect::<T>()));
        }
        read
    }

    /// One of a few words.
    pub fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Option<T> {
        let word = self.string()?;
        let found = choices.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
        if found.is_none() {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            self.complain_with(format!("is `{}`", shortened(word)), suggestion(word, &names));
        }
        found
    }
}

impl<'a> Fields<'a> {
    /// JSON pointer to the field `name` of this object, whether it is there or not.
    pub fn pointer_to(&self, name: &str) -> String {
        format!("{}/{}", self.pointer, escaped(name))
    }

    /// Complains about something within.
    pub fn complain_at(&self, pointer: &str, detail: impl Into<String>) {
        self.findings.push(FieldProblem::new(pointer, detail));
    }

    /// Whether the object has a field `name`; null counts.
    pub fn has(&self, name: &str) -> bool {
        self.map.contains_key(name)
    }

    fn cursor(&self, name: &str) -> Option<Cursor<'a>> {
        // A reader that asks for what its type does not have would refuse the field and read it as well.
        assert!(
            self.known.is_none_or(|known| known.contains(&name)),
            "`{name}` is no field of this type"
        );
        let value = self.map.get(name)?;
        Some(Cursor {
            value,
            pointer: self.pointer_to(name),
            findings: self.findings,
        })
    }

    /// A field that must be there; its absence is a finding.
    pub fn required(&self, name: &str) -> Option<Cursor<'a>> {
        let found = self.cursor(name);
        if found.is_none() {
            self.findings.push(FieldProblem::new(self.pointer_to(name), "is missing"));
        }
        found
    }

    /// A field that may be left out, but if it is there must not be null.
    pub fn optional(&self, name: &str) -> Option<Cursor<'a>> {
        self.cursor(name)
    }

    /// A field that may be left out or null, which mean the same.
    pub fn nullable(&self, name: &str) -> Option<Cursor<'a>> {
        self.cursor(name).filter(|c| !c.value.is_null())
    }
}

fn described(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}

/// The known word that `word` was probably meant to be, or all of them.
fn suggestion(word: &str, known: &[&str]) -> String {
    let word = shortened(word).to_lowercase();
    let nearest = known
        .iter()
        .map(|k| (strsim::jaro_winkler(&word, k), k))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        // Jaro and Winkler's similarity of misspellings (`fundemental_hz`) is above 0.9, of unrelated words below 0.7.
        Some((similarity, name)) if similarity > 0.84 => format!("did you mean `{name}`?"),
        _ => format!("one of: {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn complaints(findings: Findings) -> Vec<String> {
        findings.into_list().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn every_problem_is_collected_with_its_place_and_a_suggestion() {
        let document = json!({"oder": 5, "rate": "100", "list": [1, null, "x"], "a/b": null});
        let findings = Findings::default();
        let fields = Cursor::root(&document, &findings).fields(&["order", "rate", "list"]).unwrap();
        assert!(fields.required("order").is_none());
        assert!(fields.required("rate").unwrap().number().is_none());
        assert!(fields.required("list").unwrap().numbers(Some(3)).is_none());
        assert_eq!(
            complaints(findings),
            [
                "/a~1b: is not a field of this document (one of: order, rate, list)",
                "/oder: is not a field of this document (did you mean `order`?)",
                "/order: is missing",
                "/rate: is a string, expected a number (take the quotation marks away)",
                "/list/1: is null, expected a number",
                "/list/2: is a string, expected a number",
            ]
        );
    }

    #[test]
    fn findings_of_the_core_on_stand_ins_are_left_out() {
        let findings = Findings::new(vec![FieldProblem::new("/joints/1", "is null")]);
        let core = ["/joints/1/mdh", "/joints/10/mdh", "/joints"];
        findings.merge(core.map(|p| FieldProblem::new(p, "is wrong")));
        assert_eq!(complaints(findings), ["/joints/1: is null", "/joints/10/mdh: is wrong"]);
    }

    #[test]
    fn a_million_findings_are_cut() {
        let document = Value::Array(vec![Value::Null; 1_000]);
        let findings = Findings::default();
        assert!(Cursor::root(&document, &findings).numbers(None).is_none());
        let list = findings.into_list();
        assert_eq!(list.len(), MOST_FINDINGS + 1);
        assert!(list[MOST_FINDINGS].detail.contains("900 further"));
    }
}
