//! Mutated documents and logs: whatever is in a file, the program answers it; it does not panic, abort, run for ever or eat the
//! machine.
//!
//! An input is a base document or log (`bases`) with a list of changes, each made by a number (`case`): JSON and XML as trees,
//! logs as columns, then bytes. The same seed is the same input. Inputs are tried in a child process (`child`, `target`), so that
//! aborts, stack overflows and endless loops are seen and counted by the parent (`runner`), with processor time and peak memory
//! of every input. A failed input is shrunk to the changes it needs, and its files are kept (`campaign`). What has failed once is
//! in `tests/data/corpus`, one folder for each input under the name of its target.
//!
//! - `cargo test --test fuzz` replays the corpus and tries a fixed number of inputs with fixed seeds;
//! - `cargo test --release --test fuzz -- campaign --help`: as many as wanted, from any seed;
//! - `cargo test --release --test fuzz -- replay TARGET FOLDER`: one input from its files.

mod bases;
mod bytes;
mod campaign;
mod case;
mod child;
mod dice;
mod http;
mod json;
#[path = "../support/process.rs"]
mod process;
mod recordings;
mod runner;
mod table;
mod tally;
mod target;
mod tokens;
mod trials;
mod words;
mod xml;

use clap::{Parser, Subcommand};
use runner::{Order, Runner};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use target::Target;

#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Takes orders; started by the others.
    Child { work: PathBuf },
    /// Tries many inputs; Ctrl-C ends it with what was found.
    Campaign(campaign::Campaign),
    /// Tries the files in a folder.
    Replay { target: String, folder: PathBuf },
}

fn main() -> ExitCode {
    let own = ["child", "campaign", "replay"];
    match std::env::args().nth(1) {
        Some(first) if own.contains(&first.as_str()) => run(Arguments::parse().command),
        _ => libtest_mimic::run(&libtest_mimic::Arguments::from_args(), trials::all()).exit_code(),
    }
}

fn run(command: Command) -> ExitCode {
    match command {
        Command::Child { work } => child::serve(&work),
        Command::Campaign(campaign) => {
            let stop = Arc::new(AtomicBool::new(false));
            let flag = Arc::clone(&stop);
            ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)).expect("Ctrl-C can be listened for");
            let tally = campaign.run(&stop);
            println!("{}", tally.describe());
            if tally.failed() > 0 {
                println!(
                    "{} inputs failed; the files of the first of each kind are in {}",
                    tally.failed(),
                    campaign.failures.display()
                );
                return ExitCode::FAILURE;
            }
        }
        Command::Replay { target, folder } => {
            let target = Target::named(&target).expect("a known target");
            let verdict = Runner::new().run(&Order::Folder(target, &folder));
            println!("{verdict:?}");
            return if verdict.failure.is_some() {
                ExitCode::FAILURE
            } else {
                ExitCode::SUCCESS
            };
        }
    }
    ExitCode::SUCCESS
}
