//! The family of virtual logs: the iiwa 14 with the published parameters, one, two or three effects that nobody declared, on
//! random joints, of sizes from just visible to large.

use crate::bench::*;
use crate::judge::{Mark, judge, outcome_text};
use crate::visible::Sight;
use dynident::diagnosis::{Diagnosis, DiagnosisOptions, diagnose};
use dynident::model::Robot;
use dynident::simulate::HiddenEffect;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// From just visible to large: what an effect adds beside the noise ([`Sight::at`]).
const SIGHT: [f64; 2] = [12.0, 400.0];

/// What is hidden in case `number`, with what it adds beside the noise.
pub fn hide(number: u64, only: &[String], robot: &Robot, phi: &[f64]) -> Vec<(HiddenEffect, f64)> {
    let mut rng = ChaCha8Rng::seed_from_u64(number ^ 0xfa111);
    let singles: Vec<&'static str> = codes().into_iter().chain(["payload"]).collect();
    let wanted: Vec<&'static str> = match only.is_empty() {
        true => singles.clone(),
        false => singles.iter().copied().filter(|c| only.iter().any(|o| o == c)).collect(),
    };
    // Every second log has one effect, each in turn; of the others every second has two, every second three.
    let first = wanted[(number / 2) as usize % wanted.len()];
    let mut chosen = vec![first];
    let count = if number.is_multiple_of(2) || first == "payload" {
        1
    } else {
        2 + (number / 2 % 2) as usize
    };
    while chosen.len() < count {
        let code = singles[rng.random_range(0..singles.len() - 1)];
        if !chosen.contains(&code) {
            chosen.push(code);
        }
    }
    let sight = Sight::new(robot, phi, seed(number));
    chosen.iter().map(|code| visible(code, &sight, robot, &mut rng)).collect()
}

fn seed(number: u64) -> u64 {
    40_000 + number
}

fn visible(code: &'static str, sight: &Sight, robot: &Robot, rng: &mut ChaCha8Rng) -> (HiddenEffect, f64) {
    loop {
        let hidden = Hidden::random(code, robot, rng);
        let wanted = SIGHT[0] * (SIGHT[1] / SIGHT[0]).powf(rng.random_range(0.0..1.0));
        let size = sight.size_for(&hidden, wanted);
        let seen = sight.at(&hidden, size);
        // Where even the largest size cannot be seen, it is hidden elsewhere.
        if seen > 0.9 * SIGHT[0] {
            return (hidden.at(size), seen);
        }
    }
}

/// The tracing of a log with these effects; a payload only in the second log, against the model of the first.
pub fn traced_case(robot: &Robot, phi: &[f64], effects: &[HiddenEffect], seed: u64) -> Diagnosis {
    let noise = sensor_noise(robot.joint_count());
    let loaded = effects.iter().any(|e| matches!(e, HiddenEffect::Payload { .. }));
    let first = if loaded { &[][..] } else { effects };
    let [identify, validate] = published_logs(robot, phi, [first, effects], &noise, seed);
    let (identify, validate) = ([stretch(&identify, "identify")], [stretch(&validate, "validate")]);
    if !loaded {
        return diagnose(robot, &identify, &validate, &DiagnosisOptions::default());
    }
    let options = DiagnosisOptions {
        existing: Some(diagnose(robot, &identify, &[], &DiagnosisOptions::default()).existing()),
        ..DiagnosisOptions::default()
    };
    diagnose(robot, &validate, &[], &options)
}

struct Case {
    codes: Vec<&'static str>,
    mark: Mark,
}

pub fn family(count: u64, first: u64, only: &[String]) {
    let (robot, phi) = published();
    let numbers: Vec<u64> = (first..first + count).collect();
    let cases: Vec<Case> = numbers
        .into_par_iter()
        .with_max_len(1)
        .map(|number| case(number, only, &robot, &phi))
        .collect();
    summary(&cases);
}

fn case(number: u64, only: &[String], robot: &Robot, phi: &[f64]) -> Case {
    let hidden = hide(number, only, robot, phi);
    let effects: Vec<HiddenEffect> = hidden.iter().map(|h| h.0.clone()).collect();
    let outcome = traced_case(robot, phi, &effects, seed(number));
    let (mark, reasons) = judge(&outcome, &effects, robot);
    let word = match mark {
        Mark::Right => "right",
        Mark::Half => "half ",
        Mark::Wrong => "WRONG",
    };
    let what: Vec<String> = hidden.iter().map(|(h, seen)| format!("{h:?} seen {seen:.0}")).collect();
    println!(
        "{number} {word} {} | {}{}",
        what.join(" & "),
        outcome_text(&outcome),
        if reasons.is_empty() {
            String::new()
        } else {
            format!(" | {}", reasons.join("; "))
        }
    );
    let codes = effects.iter().map(|e| crate::judge::truth(e).code).collect();
    Case { codes, mark }
}

fn summary(cases: &[Case]) {
    let mut table: BTreeMap<(usize, &str), [usize; 3]> = BTreeMap::new();
    for case in cases {
        let mark = 2 - case.mark as usize;
        table.entry((0, "all")).or_default()[mark] += 1;
        table.entry((case.codes.len(), "all")).or_default()[mark] += 1;
        for code in &case.codes {
            table.entry((case.codes.len(), code)).or_default()[mark] += 1;
        }
    }
    println!("\n| effects in the log | with | right | half | wrong |\n|---|---|---|---|---|");
    for ((count, code), [right, half, wrong]) in &table {
        println!("| {count} | `{code}` | {right} | {half} | {wrong} |");
    }
}
