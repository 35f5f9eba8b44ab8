//! What the test command tries.

use super::campaign::{Campaign, TURNS, shrunk};
use super::case::Recipe;
use super::http;
use super::recordings;
use super::runner::{Order, Runner};
use super::target::Target;
use libtest_mimic::{Failed, Trial};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Inputs per target: about a minute on two cores together.
const INPUTS: [(Target, u64); 9] = [
    (Target::BaseParameters, 600),
    (Target::Inspect, 300),
    (Target::Identify, 200),
    (Target::Validate, 100),
    (Target::Excite, 60),
    (Target::Simulate, 200),
    (Target::Motion, 300),
    (Target::Settings, 200),
    (Target::Model, 200),
];

pub fn all() -> Vec<Trial> {
    let mut trials = vec![
        Trial::test("the_harness_sees_what_it_looks_for", faults_are_seen),
        Trial::test("what_is_changed_is_accepted_unchanged", bases_are_accepted),
        Trial::test("the_same_seed_is_the_same_input", seeds_repeat),
        Trial::test("a_campaign_tries_every_target", every_target_has_a_turn),
        Trial::test("a_failed_input_shrinks_to_what_it_needs", failures_shrink),
        Trial::test("http_bodies", http::bodies),
    ];
    trials.extend(recordings::trials());
    for (target, inputs) in INPUTS {
        let trial = |kind: &str, run: Box<dyn FnOnce() -> Result<(), Failed> + Send>| {
            Trial::test(format!("{kind}::{}", target.name()), run)
        };
        trials.push(trial("mutated", Box::new(move || mutated(target, inputs))));
        trials.push(trial("corpus", Box::new(move || replayed(target))));
    }
    trials
}

fn every_target_has_a_turn() -> Result<(), Failed> {
    match Target::ALL.iter().find(|t| !TURNS.contains(t)) {
        Some(target) => Err(format!("{} has none", target.name()).into()),
        None => Ok(()),
    }
}

fn mutated(target: Target, inputs: u64) -> Result<(), Failed> {
    let campaign = Campaign {
        inputs: Some(inputs),
        seed: 0,
        target: Some(target.name().to_string()),
        processes: 1,
        failures: PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fuzz"),
    };
    let tally = campaign.run(&AtomicBool::new(false));
    match tally.failed() {
        0 => Ok(()),
        _ => Err(format!("{}\nfiles are in {}", tally.describe(), campaign.failures.display()).into()),
    }
}

fn replayed(target: Target) -> Result<(), Failed> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/corpus")
        .join(target.name());
    // Without a folder nothing of this kind has failed yet.
    if !folder.exists() {
        return Ok(());
    }
    let mut inputs: Vec<PathBuf> = std::fs::read_dir(&folder)?
        .map(|e| e.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    inputs.sort();
    let mut runner = Runner::new();
    let failed = inputs.iter().filter_map(|input| {
        let failure = runner.run(&Order::Folder(target, input)).failure?;
        Some(format!("{}: {failure}", input.display()))
    });
    let failed: Vec<String> = failed.collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n").into())
    }
}

/// Which base of [`Target::Itself`] does what.
const FAULTS: [(u64, &str); 7] = [
    (0, ""),
    (1, "panic: "),
    (2, "death: "),
    (3, "endless: "),
    (4, "death: "),
    (5, "memory: "),
    (6, "internal: "),
];

fn of_itself(base: u64, genes: Vec<u64>) -> Recipe {
    Recipe {
        target: Target::Itself,
        base,
        genes,
    }
}

fn faults_are_seen() -> Result<(), Failed> {
    let mut runner = Runner::new();
    // The last is the first again: the process is there after every death.
    for (base, kind) in FAULTS.into_iter().chain([FAULTS[0]]) {
        let failure = runner
            .run(&Order::Recipe(&of_itself(base, Vec::new())))
            .failure
            .unwrap_or_default();
        let seen = if kind.is_empty() {
            failure.is_empty()
        } else {
            failure.starts_with(kind)
        };
        if !seen {
            return Err(format!("expected {kind:?}, got {failure:?}").into());
        }
    }
    Ok(())
}

/// A base that is refused for a fault of its own would hide what its changes do.
fn bases_are_accepted() -> Result<(), Failed> {
    let mut runner = Runner::new();
    let mut refused = Vec::new();
    for target in Target::ALL {
        for base in 0..super::bases::of(target).len() as u64 {
            let recipe = Recipe {
                target,
                base,
                genes: Vec::new(),
            };
            let verdict = runner.run(&Order::Recipe(&recipe));
            if !verdict.accepted || verdict.failure.is_some() {
                refused.push(format!("{} {base}: {verdict:?}", target.name()));
            }
        }
    }
    if refused.is_empty() {
        Ok(())
    } else {
        Err(refused.join("\n").into())
    }
}

fn seeds_repeat() -> Result<(), Failed> {
    let bases = super::bases::of(Target::Motion);
    let files = |seed: u64| Recipe::of_seed(Target::Motion, seed).draft(&bases).render();
    let repeated = (0..200).all(|seed| files(seed) == files(seed));
    let distinct: std::collections::HashSet<_> = (0..200).map(files).collect();
    // Some changes change nothing, such as two equal numbers exchanged.
    if repeated && distinct.len() > 180 {
        Ok(())
    } else {
        Err(format!("{repeated} {}", distinct.len()).into())
    }
}

fn failures_shrink() -> Result<(), Failed> {
    let mut runner = Runner::new();
    // A change to the text "panic" makes something else of it: the only recipe that panics is the one without changes.
    let found = (0..50)
        .map(|gene| of_itself(1, vec![gene]))
        .find(|r| runner.run(&Order::Recipe(r)).failure.is_none());
    let harmless = found.ok_or("no change makes the panic go away")?;
    let verdict = runner
        .run(&Order::Recipe(&of_itself(1, Vec::new())))
        .failure
        .ok_or("there is a panic")?;
    let least = shrunk(&mut runner, &harmless, &verdict);
    if least == of_itself(1, Vec::new()) {
        Ok(())
    } else {
        Err(format!("{least:?}").into())
    }
}
