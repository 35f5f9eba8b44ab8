//! What people and programs see.

use crate::app::{Error, ProblemDetails};
use crate::documents::{
    DesignDocument, DetectableEffectDocument, IdentifyDocument, JointErrors, ResidualDocument, ValidateDocument,
};
use crate::formats::significant;
use std::fmt::Write;

/// To standard error: a problem document with `--json`, else lines for people.
pub fn print_error(error: &Error, json: bool) {
    if json {
        eprintln!(
            "{}",
            serde_json::to_string(&ProblemDetails::from(error)).expect("a problem is plain data")
        );
        return;
    }
    eprintln!("error[{}]: {}", error.code.name(), error.detail);
    for problem in &error.errors {
        eprintln!("  {problem}");
    }
    if let Some(hint) = &error.hint {
        eprintln!("hint: {hint}");
    }
}

/// A design in a few lines.
pub fn summary(design: &DesignDocument) -> String {
    let mut text = String::new();
    let search = &design.search;
    let _ = writeln!(text, "{}: {}", design.robot, design.status);
    if let Some(reason) = &design.reason {
        let _ = writeln!(text, "  {reason}");
    }
    if let Some(c) = &design.criteria {
        let _ = writeln!(text, "  condition number  {:.3}", c.condition_number);
        let _ = writeln!(text, "  D-optimality      {:.4e}", c.d_optimality);
        let _ = writeln!(text, "  A-optimality      {:.4e}", c.a_optimality);
        let _ = writeln!(text, "  I-optimality      {:.4e}", c.i_optimality);
    }
    if let Some(rivals) = &design.rivals {
        let e = &rivals.expected_evidence;
        let of_data = e
            .recorded
            .as_ref()
            .map_or(String::new(), |r| format!(" (the data so far: {:.1})", r.least));
        let _ = writeln!(
            text,
            "  {} or {}: expected evidence {:.1}{of_data}; {}",
            rivals.finding.effect,
            rivals.rival.effect,
            e.together.least,
            if rivals.decides {
                "decides"
            } else {
                "does not decide: record more periods, or move more freely"
            }
        );
    }
    if design.first_run.is_none() && design.request.get("backoff").is_some_and(|b| b.is_number()) && design.coefficients.is_some()
    {
        let _ = writeln!(
            text,
            "  no first run: no part of this motion keeps every limit along the path"
        );
    }
    let tightest = design.margins.iter().min_by(|a, b| a.margin.total_cmp(&b.margin));
    if let Some(m) = tightest {
        let percent = 100.0 * m.margin;
        let _ = writeln!(
            text,
            "  tightest limit    {} {} ({}), {percent:.2} % left",
            m.joint, m.quantity, m.side
        );
    }
    let _ = writeln!(
        text,
        "  {} evaluations in {:.1} s, seed {}",
        search.evaluations, search.elapsed_s, search.seed
    );
    limits_used(&mut text, design);
    would_reveal(&mut text, design);
    for note in &design.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}

/// Percent of every kind of limit that each joint uses.
fn limits_used(text: &mut String, design: &DesignDocument) {
    let kinds = ["position", "velocity", "acceleration", "jerk", "torque"];
    let kinds: Vec<&str> = kinds
        .into_iter()
        .filter(|k| design.margins.iter().any(|m| m.quantity == *k))
        .collect();
    if kinds.is_empty() {
        return;
    }
    let head: String = kinds.iter().map(|k| format!(" {k:>13}")).collect();
    let _ = writeln!(text, "  used of the limit (%){head}");
    for joint in &design.joints {
        let used = |kind: &&str| {
            let own = design.margins.iter().filter(|m| m.joint == *joint && m.quantity == *kind);
            own.map(|m| 100.0 * (1.0 - m.margin)).reduce(f64::max)
        };
        let row: String = kinds
            .iter()
            .map(|k| used(k).map_or(format!(" {:>13}", "-"), |v| format!(" {v:13.2}")))
            .collect();
        let _ = writeln!(text, "    {joint:18}{row}");
    }
}

/// The smallest size of every effect that a recording is predicted to reveal, a line per effect and parameter, and what it takes
/// for what.
fn would_reveal(text: &mut String, design: &DesignDocument) {
    let Some(found) = &design.detectable else { return };
    let percent = 100.0 * found.power;
    let noise: Vec<String> = found.torque_noise.iter().map(|n| significant(*n, 3)).collect();
    let _ = writeln!(
        text,
        "  a recording of {} periods is predicted to reveal ({percent:.0} % of logs, torque noise {} from {}):",
        found.periods,
        noise.join(" "),
        found.noise_source.replace('_', " ")
    );
    let mut kinds: Vec<(&str, &str, &str)> = Vec::new();
    for e in found.effects.iter().filter(|e| e.size.is_some()) {
        let kind = (e.effect.as_str(), e.parameter.as_str(), e.unit.as_str());
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    for (effect, parameter, unit) in kinds {
        let own = |e: &&DetectableEffectDocument| {
            (e.effect.as_str(), e.parameter.as_str(), e.unit.as_str()) == (effect, parameter, unit)
        };
        let size = |e: &DetectableEffectDocument| {
            let size = e.size.map(|s| format!("{} {}", e.joints.join("/"), significant(s, 3)));
            size.map(|s| s.trim_start().to_string())
        };
        let sizes: Vec<String> = found.effects.iter().filter(own).filter_map(size).collect();
        let _ = writeln!(text, "    {effect} {parameter} [{unit}]: {}", sizes.join(", "));
    }
    let mut taken: Vec<(&str, &str)> = found.pairs.iter().map(|p| (p.effect.as_str(), p.rival.as_str())).collect();
    taken.sort_unstable();
    taken.dedup();
    let one_way = |(a, b): &(&str, &str)| a <= b || !taken.contains(&(b, a));
    let named: Vec<String> = taken
        .iter()
        .filter(|p| one_way(p))
        .map(|(a, b)| format!("{a} / {b}"))
        .collect();
    if !named.is_empty() {
        let _ = writeln!(text, "  not separated at these sizes on some joint: {}", named.join(", "));
    }
}

/// An identification in a page: verdict, parameters, errors per joint.
pub fn identification(found: &IdentifyDocument) -> String {
    let mut text = String::new();
    let q = &found.quality;
    let _ = writeln!(text, "{}: {} ({})", found.robot, q.verdict, q.reason);
    let condition = q.condition_number.map_or("infinite".to_string(), |c| figure(Some(c), 0, 1));
    let _ = writeln!(text, "  rank {} of {}, condition number {condition}", q.rank, q.columns);
    let _ = writeln!(
        text,
        "  {:10} {:>12} {:12} {:>10} {:>10}",
        "parameter", "value", "unit", "σ", "σ/|value|"
    );
    for p in found.base_parameters.iter().chain(found.offsets.iter().flatten()) {
        match (p.value, p.std_dev, p.relative_std_dev_percent) {
            (Some(value), Some(deviation), Some(percent)) => {
                let _ = writeln!(
                    text,
                    "  {:10} {} {:12} {deviation:10.2e} {} %",
                    p.name,
                    figure(Some(value), 12, 5),
                    p.unit,
                    figure(Some(percent), 8, 2)
                );
            }
            _ => {
                let _ = writeln!(text, "  {:10} not determined by the log", p.name);
            }
        }
    }
    if let Some(f) = &found.feasibility {
        let _ = writeln!(
            text,
            "  physical parameters: {}, fit {} times that of the base parameters",
            f.status,
            figure(Some(f.rms_ratio), 0, 4)
        );
    }
    error_table(&mut text, found);
    if let Some(residual) = &found.residual {
        let _ = writeln!(text, "  residual: {}", residual.verdict.code().replace('_', " "));
        residual_table(&mut text, residual);
    }
    for log in &found.log_report {
        for f in &log.findings {
            let _ = writeln!(text, "  {}: {} {}: {}", log.file, f.count, f.code, f.detail);
        }
    }
    text
}

/// A number in a table: so many decimals, a power of ten where it would be long or all zeros, a hyphen where there is none.
fn figure(value: Option<f64>, width: usize, decimals: usize) -> String {
    match value.filter(|v| v.is_finite()) {
        None => format!("{:>width$}", "-"),
        Some(v) if v != 0.0 && !(0.5 * 0.1f64.powi(decimals as i32)..1e6).contains(&v.abs()) => format!("{v:width$.2e}"),
        Some(v) => format!("{v:width$.decimals$}"),
    }
}

/// Errors per joint of every log and model, and the noise floor below them.
fn error_table(text: &mut String, found: &IdentifyDocument) {
    let head: String = found.joints.iter().map(|j| format!(" {j:>9}")).collect();
    let _ = writeln!(text, "  RMS error (N m or N){:16}{head}       sum", "");
    let logs = found
        .rms
        .identification
        .iter()
        .map(|l| ("identification", l))
        .chain(found.rms.validation.iter().map(|l| ("validation", l)));
    for (role, log) in logs {
        let _ = writeln!(text, "  {role} {}", log.name);
        for (model, e) in [("base", Some(&log.base)), ("physical", log.physical.as_ref())] {
            let Some(e) = e else { continue };
            let values: String = e.rms.iter().map(|r| format!(" {}", figure(*r, 9, 4))).collect();
            let _ = writeln!(text, "    {model:34}{values} {}", figure(Some(e.sum), 9, 4));
        }
    }
}

/// What the diagnosis found: verdict, findings with their figures, the error before and after.
fn residual_table(text: &mut String, residual: &ResidualDocument) {
    let row = |values: &[Option<f64>]| values.iter().map(|v| format!(" {}", figure(*v, 9, 4))).collect::<String>();
    let mut line = |name: &str, values: &[Option<f64>]| {
        let _ = writeln!(text, "    {name:34}{}", row(values));
    };
    let (before, after) = (&residual.rms_before, &residual.rms_after);
    let pairs = [
        ("identification", &before.identification, &after.identification),
        ("held out", &before.held_out, &after.held_out),
    ];
    line("noise floor", &residual.noise_floor);
    for (kind, before, after) in pairs.into_iter().filter(|p| !p.1.is_empty()) {
        line(&format!("{kind}, declared model"), before);
        line(&format!("{kind}, with effects found"), after);
    }
    sentences(text, residual);
}

/// What was found, in sentences.
fn sentences(text: &mut String, residual: &ResidualDocument) {
    let faults = residual.data_faults.iter().flat_map(|f| [&f.detail, &f.remedy]);
    let findings = residual.findings.iter().map(|f| &f.sentence);
    let rest = residual.remainder.iter().map(|r| &r.sentence);
    std::iter::once(&residual.summary)
        .chain(faults)
        .chain(findings)
        .chain(rest)
        .for_each(|sentence| wrapped(text, sentence));
}

/// A paragraph, indented, on lines that a terminal holds.
fn wrapped(text: &mut String, paragraph: &str) {
    const WIDTH: usize = 108;
    let mut line = String::new();
    for word in paragraph.split(' ') {
        if !line.is_empty() && line.chars().count() + word.chars().count() >= WIDTH {
            let _ = writeln!(text, "    {line}");
            line.clear();
        }
        line += if line.is_empty() { "" } else { " " };
        line += word;
    }
    let _ = writeln!(text, "    {line}");
}

/// A validation in a few lines.
pub fn validation(found: &ValidateDocument) -> String {
    let mut text = format!("{}\n", found.robot);
    for log in &found.logs {
        let _ = writeln!(text, "  {}", log.name);
        errors(&mut text, "model", &log.errors);
    }
    if let Some(residual) = &found.residual {
        changes(&mut text, residual);
    }
    text
}

/// What has changed since the model was made, finding by finding.
fn changes(text: &mut String, residual: &ResidualDocument) {
    let _ = writeln!(
        text,
        "  since the model was made: {}",
        residual.verdict.code().replace('_', " ")
    );
    sentences(text, residual);
}

fn errors(text: &mut String, what: &str, errors: &JointErrors) {
    let list: Vec<String> = errors
        .rms
        .iter()
        .zip(&errors.percent)
        .map(|(r, p)| format!("{} ({} %)", figure(*r, 0, 3), figure(*p, 0, 1)))
        .collect();
    let _ = writeln!(
        text,
        "    {what:9} {}   sum {}",
        list.join("  "),
        figure(Some(errors.sum), 0, 3)
    );
}
