//! What became of many inputs.

use super::case::Recipe;
use super::runner::Verdict;
use super::target::Target;
use std::collections::BTreeMap;
use std::fmt::Write;

#[derive(Debug, Default)]
pub struct Tally {
    targets: BTreeMap<Target, Numbers>,
    /// By signature: how often, and the first.
    pub failures: BTreeMap<(Target, String), (usize, Option<Recipe>)>,
}

#[derive(Debug, Default)]
struct Numbers {
    inputs: usize,
    accepted: usize,
    failures: BTreeMap<String, usize>,
    peak: u64,
    /// Largest memory beyond ten times the input.
    peak_beyond: u64,
    longest_s: f64,
    total_s: f64,
}

/// A failure without the numbers in it, by which equal ones are known.
pub fn signature(failure: &str) -> String {
    let mut text = String::new();
    for c in failure.chars().take(220) {
        // Places in the code are what tells failures apart: their lines stay.
        let within_place = text.rsplit(' ').next().is_some_and(|word| word.contains(".rs:"));
        match c.is_ascii_digit() && !within_place {
            true if text.ends_with('#') => {}
            true => text.push('#'),
            false => text.push(c),
        }
    }
    text
}

impl Tally {
    /// Whether this failure is the first of its kind.
    pub fn add(&mut self, target: Target, verdict: &Verdict, recipe: Option<&Recipe>) -> bool {
        let numbers = self.targets.entry(target).or_default();
        numbers.inputs += 1;
        numbers.accepted += usize::from(verdict.accepted);
        numbers.peak = numbers.peak.max(verdict.peak);
        numbers.peak_beyond = numbers.peak_beyond.max(verdict.peak.saturating_sub(10 * verdict.size));
        numbers.longest_s = numbers.longest_s.max(verdict.cpu_s);
        numbers.total_s += verdict.cpu_s;
        let Some(failure) = &verdict.failure else { return false };
        let kind = failure.split(':').next().unwrap_or_default().to_string();
        *numbers.failures.entry(kind).or_default() += 1;
        let entry = self
            .failures
            .entry((target, signature(failure)))
            .or_insert((0, recipe.cloned()));
        entry.0 += 1;
        entry.0 == 1
    }

    pub fn failed(&self) -> usize {
        self.failures.values().map(|(count, _)| count).sum()
    }

    /// A table by target, and every kind of failure with its first recipe.
    pub fn describe(&self) -> String {
        let mut text =
            "target            inputs  accepted  peak MB  beyond 10 x input  longest s  total s  failures\n".to_string();
        for (target, n) in &self.targets {
            let mb = |bytes: u64| bytes as f64 / 1e6;
            let failures: Vec<String> = n.failures.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            let failures = if failures.is_empty() {
                "0".to_string()
            } else {
                failures.join(", ")
            };
            let _ = writeln!(
                text,
                "{:16} {:7}  {:8}  {:7.0}  {:17.0}  {:9.2}  {:7.0}  {failures}",
                target.name(),
                n.inputs,
                n.accepted,
                mb(n.peak),
                mb(n.peak_beyond),
                n.longest_s,
                n.total_s
            );
        }
        for ((target, signature), (count, recipe)) in &self.failures {
            let recipe = recipe.as_ref().map(|r| r.to_json().to_string()).unwrap_or_default();
            let _ = writeln!(text, "{count:5} x {}: {signature}\n        {recipe}", target.name());
        }
        text
    }
}
