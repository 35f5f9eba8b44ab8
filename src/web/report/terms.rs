//! The terms of a report, from the glossary of the pages.

use super::html::Html;
use serde::Deserialize;
use std::collections::HashMap;

const GLOSSARY: &str = include_str!("../assets/glossary.json");

/// A topic of the glossary: name and explanation of every term by its key.
#[derive(Deserialize)]
struct Topic {
    terms: HashMap<String, (String, String)>,
}

/// What a reader who was not there may want to look up, in the order of the report.
const TERMS: &[&str] = &[
    "finding",
    "declared_model",
    "held_out",
    "noise_floor",
    "lack_of_fit",
    "p_value",
    "bic",
    "rival",
    "survival",
    "undetected",
    "quality",
    "decimation",
    "rms_error",
    "base_parameters",
    "std_dev",
    "scaled_condition_number",
    "physical_parameters",
    "physical_fit",
    "physical_margin",
];

pub(super) fn terms(page: &mut Html) {
    let topics: Vec<Topic> = serde_json::from_str(GLOSSARY).expect("the glossary is well-formed");
    let all: HashMap<String, (String, String)> = topics.into_iter().flat_map(|topic| topic.terms).collect();
    page.heading(2, "Terms");
    page.definitions(TERMS.iter().map(|key| {
        let (name, words) = &all[*key];
        (name.as_str(), words.as_str())
    }));
}
