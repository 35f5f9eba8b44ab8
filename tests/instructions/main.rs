//! What the kernels cost in instructions, held against locked counts: a slower kernel is noticed on a machine that is busy with
//! other work too, where times say nothing. Valgrind counts; it shows programs the same instruction set (AVX2 and FMA, no wider
//! one) on every x86-64 machine of the last ten years.
//!
//! The count of a kernel is the difference between runs of more and of fewer units, so that start and input cancel.
//! `cargo test --release --test instructions -- --nocapture` prints all counts.

extern crate dynident_io as dynident;

mod kernels;
mod problem;

use kernels::KERNELS;
use libtest_mimic::{Arguments, Failed, Trial};
use std::process::{Command, ExitCode};

/// How far a count may exceed the locked one. Runs of one build agree to 0.1 % (hash maps have seeds). Builds of the same sources
/// do not: an incremental one and one from clean cut the crates into other units and inline differently, and so does the next
/// compiler. A kernel that has lost its vectors or takes a step twice exceeds this.
const MARGIN: f64 = 0.2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, name, rounds] = arguments.as_slice()
        && first == "kernel"
    {
        let kernel = KERNELS.iter().find(|k| k.name == name).expect("a kernel");
        println!("{}", (kernel.run)(rounds.parse().expect("a number")));
        return ExitCode::SUCCESS;
    }
    let missing = why_not();
    let trials = KERNELS.iter().map(|kernel| {
        let name = match &missing {
            Some(reason) => format!("{} (skipped: {reason})", kernel.name),
            None => kernel.name.to_string(),
        };
        Trial::test(name, move || holds(kernel)).with_ignored_flag(missing.is_some())
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit_code()
}

/// Why nothing can be counted here.
fn why_not() -> Option<String> {
    let wide = |flags: &str| [" avx2", " fma"].iter().all(|flag| flags.contains(flag));
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    if !cfg!(target_arch = "x86_64") || !wide(&processor) {
        return Some("counts are locked for x86-64 with AVX2 and FMA".into());
    }
    let answer = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "true"])
        .output();
    match answer {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(format!(
            "valgrind fails here: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        )),
        Err(error) => Some(format!("valgrind: {error}")),
    }
}

fn holds(kernel: &kernels::Kernel) -> Result<(), Failed> {
    let (few, many) = (
        counted(kernel.name, kernel.rounds[0])?,
        counted(kernel.name, kernel.rounds[1])?,
    );
    let each = (many.instructions - few.instructions) / (many.units - few.units);
    let change = 100.0 * (each / kernel.instructions - 1.0);
    println!(
        "{:20} {each:12.1} instructions per {}, locked {:.1}: {change:+.1} %",
        kernel.name, kernel.unit, kernel.instructions
    );
    if each > kernel.instructions * (1.0 + MARGIN) {
        return Err(format!(
            "{each:.1} instructions per {} are {change:.1} % more than the locked {:.1}. If that is meant, lock the new count in tests/instructions/kernels.rs \
             and say why in the commit.",
            kernel.unit, kernel.instructions
        )
        .into());
    }
    Ok(())
}

struct Counted {
    instructions: f64,
    units: f64,
}

/// One run of this program under callgrind.
fn counted(name: &str, rounds: usize) -> Result<Counted, Failed> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe()?)
        .args(["kernel", name, &rounds.to_string()])
        .env("RAYON_NUM_THREADS", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    let after = |text: &str| {
        said.lines()
            .find_map(|l| l.split_once(text))
            .map(|(_, rest)| rest.trim().to_string())
    };
    let instructions = after("Collected :").and_then(|n| n.parse().ok());
    let units = String::from_utf8_lossy(&output.stdout).trim().parse().ok();
    match (instructions, units) {
        (Some(instructions), Some(units)) => Ok(Counted { instructions, units }),
        _ => Err(format!("no counts: {said}").into()),
    }
}
