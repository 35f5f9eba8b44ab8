//! From which size an effect is found, and what is found instead.

use crate::bench::*;
use crate::family::traced_case;
use crate::judge::{Truth, outcome_text, truth};
use crate::visible::Sight;
use dynident::diagnosis::Diagnosis;
use dynident::model::Robot;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;

fn wanted(only: &[String]) -> Vec<&'static str> {
    let all = codes().into_iter().chain(["payload"]);
    all.filter(|c| only.is_empty() || only.iter().any(|o| o == c)).collect()
}

/// Whether the effect is named on its joint, first or as a rival of what is.
fn found(outcome: &Diagnosis, truth: &Truth, robot: &Robot) -> bool {
    let names: Vec<&str> = truth.joints.iter().map(|&j| robot.joints()[j].name.as_str()).collect();
    let there = |joints: &[String]| names.is_empty() || names.iter().all(|n| joints.iter().any(|j| j == n));
    let report = &outcome.report;
    if truth.code == "unexplained" {
        return report
            .remainder
            .as_ref()
            .is_some_and(|r| r.joints.iter().any(|j| j == names[0]));
    }
    report.findings.iter().any(|f| {
        f.effect == truth.code && there(&f.joints) || f.rivals.iter().any(|r| r.effect == truth.code && there(&r.joints))
    })
}

struct Limit {
    code: &'static str,
    joint: usize,
    seen: f64,
    /// First value of the effect at the limit.
    value: f64,
}

/// Between these an effect begins to be found ([`Sight::at`]); seven halvings of the ratio leave 4 %.
const RANGE: [f64; 2] = [3.0, 300.0];
const HALVINGS: usize = 7;
/// Times the least: what is not found there is printed with what was named in its place.
const CLEAR: f64 = 5.0;

/// Per effect, bisection on `repeats` random joints and motions, the noise the same at every size.
pub fn detect(repeats: u64, only: &[String]) {
    let (robot, phi) = published();
    let tasks: Vec<(&'static str, u64)> = wanted(only)
        .into_iter()
        .flat_map(|c| (0..repeats).map(move |r| (c, r)))
        .collect();
    let limits: Vec<Option<Limit>> = tasks
        .into_par_iter()
        .with_max_len(1)
        .map(|(code, repeat)| limit(code, repeat, &robot, &phi))
        .collect();
    println!("\n| effect | found from | smallest on | largest on | seen at |\n|---|---|---|---|---|");
    for code in wanted(only) {
        let mut own: Vec<&Limit> = limits.iter().flatten().filter(|l| l.code == code).collect();
        if own.is_empty() {
            println!("| `{code}` | never | | | |");
            continue;
        }
        own.sort_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        let middle = |values: Vec<f64>| (values[(values.len() - 1) / 2] + values[values.len() / 2]) / 2.0;
        let mut seen: Vec<f64> = own.iter().map(|l| l.seen).collect();
        seen.sort_by(f64::total_cmp);
        let at = |l: &Limit| format!("{:.2e} ({})", l.value.abs(), robot.joints()[l.joint].name);
        println!(
            "| `{code}` | {:.2e} | {} | {} | {:.0} ({} of {repeats}) |",
            middle(own.iter().map(|l| l.value.abs()).collect()),
            at(own[0]),
            at(own[own.len() - 1]),
            middle(seen),
            own.len()
        );
    }
}

fn limit(code: &'static str, repeat: u64, robot: &Robot, phi: &[f64]) -> Option<Limit> {
    let seed = 70_000 + repeat;
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ code.len() as u64);
    let sight = Sight::new(robot, phi, seed);
    // What is well visible at a sensible size, else what is most visible of all.
    let mut most: Option<(f64, Hidden)> = None;
    for _ in 0..100 {
        let hidden = Hidden::random(code, robot, &mut rng);
        let seen = sight.at(&hidden, sight.size_for(&hidden, RANGE[1]));
        if most.as_ref().is_none_or(|m| seen > m.0) {
            most = Some((seen, hidden));
        }
        if seen > 0.5 * RANGE[1] {
            break;
        }
    }
    let (seen, hidden) = most?;
    let range = [RANGE[0], seen.min(RANGE[1])];
    if range[1] <= range[0] {
        return None;
    }
    let traced = |seen: f64| {
        let effect = hidden.at(sight.size_for(&hidden, seen));
        let outcome = traced_case(robot, phi, std::slice::from_ref(&effect), seed);
        (found(&outcome, &truth(&effect), robot), outcome)
    };
    let is_found = |seen: f64| {
        let (found, outcome) = traced(seen);
        if !found && seen > RANGE[0] * CLEAR {
            println!("{code} {repeat} not found at {seen:.0}: {}", outcome_text(&outcome));
        }
        found
    };
    if let (false, outcome) = traced(range[1]) {
        println!(
            "{code} {repeat} {hidden:?}: not found at {}, {}",
            range[1],
            outcome_text(&outcome)
        );
        return None;
    }
    let [mut low, mut high] = range;
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if is_found(middle) { high = middle } else { low = middle }
    }
    let seen = (low * high).sqrt();
    let at = hidden.at(sight.size_for(&hidden, seen));
    println!("{code} {repeat} found from {at:?} seen {seen:.1}");
    Some(Limit {
        code,
        joint: hidden.joint,
        seen,
        value: truth(&at).values.first().map_or(sight.size_for(&hidden, seen), |v| v.1),
    })
}

/// Sizes at which the confusion is printed: visible, clear, large.
const SEEN: [f64; 3] = [30.0, 100.0, 300.0];

/// Single effects on random joints, and what is named first; `+` where more is named than was hidden.
pub fn confusion(repeats: u64, only: &[String]) {
    let (robot, phi) = published();
    let tasks: Vec<(&'static str, u64, f64)> = wanted(only)
        .into_iter()
        .flat_map(|c| (0..repeats).flat_map(move |r| SEEN.map(|seen| (c, r, seen))))
        .collect();
    let named: Vec<(&'static str, String)> = tasks
        .into_par_iter()
        .with_max_len(1)
        .map(|(code, repeat, seen)| (code, name(code, repeat, seen, &robot, &phi)))
        .collect();
    let mut table: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for (code, name) in &named {
        *table.entry(code).or_default().entry(name).or_default() += 1;
    }
    println!("\n| hidden | named |\n|---|---|");
    for (code, row) in &table {
        let mut row: Vec<_> = row.iter().collect();
        row.sort_by(|a, b| b.1.cmp(a.1));
        let said: Vec<String> = row.iter().map(|(name, count)| format!("{name} {count}")).collect();
        println!("| `{code}` | {} |", said.join(", "));
    }
}

fn name(code: &'static str, repeat: u64, seen: f64, robot: &Robot, phi: &[f64]) -> String {
    let seed = 80_000 + repeat * 10 + seen as u64 % 7;
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ (code.len() as u64) << 8);
    let sight = Sight::new(robot, phi, seed);
    let hidden = std::iter::repeat_with(|| Hidden::random(code, robot, &mut rng))
        .take(50)
        .find(|h| sight.at(h, sight.size_for(h, seen)) > 0.7 * seen);
    let Some(hidden) = hidden else {
        return "not visible".into();
    };
    let effect = hidden.at(sight.size_for(&hidden, seen));
    let outcome = traced_case(robot, phi, std::slice::from_ref(&effect), seed);
    let truth = truth(&effect);
    let report = &outcome.report;
    let count = report.findings.len() + usize::from(report.remainder.is_some());
    let more = if count > 1 { " and more" } else { "" };
    let named = if found(&outcome, &truth, robot) {
        let first = report.findings.iter().any(|f| f.effect == truth.code) || truth.code == "unexplained";
        if first {
            format!("right{more}")
        } else {
            format!("as rival{more}")
        }
    } else {
        let first = report.findings.first().map(|f| match f.effect == truth.code {
            true => format!("{} elsewhere", f.effect),
            false => f.effect.clone(),
        });
        let otherwise = if report.remainder.is_some() {
            "unexplained"
        } else {
            "nothing"
        };
        format!("{}{more}", first.unwrap_or(otherwise.into()))
    };
    println!("{code} {repeat} seen {seen} {effect:?}: {named} | {}", outcome_text(&outcome));
    named
}
