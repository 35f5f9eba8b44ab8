//! The command line: the same documents as over HTTP, no server needed.
//!
//! Exit status: 0 done; 1 an error inside; 2 wrong usage or input; 3 the problem is infeasible; 4 cancelled, the best trajectory
//! found so far is written, of an identification nothing.

mod base_parameters;
#[cfg(feature = "service")]
mod child;
mod excite;
mod files;
mod identify;
mod known;
mod log;
mod model;
#[cfg(feature = "service")]
mod openapi;
mod plots;
mod render;
mod robot;
#[cfg(feature = "service")]
mod serve;
#[cfg(feature = "service")]
mod settings;
mod shell;
mod simulate;
#[cfg(feature = "service")]
mod store;
#[cfg(feature = "service")]
mod token;
mod validate;

use crate::app::Error;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// How a command ended that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    Done,
    Infeasible,
    Cancelled,
}

impl Ending {
    fn exit_status(self) -> u8 {
        match self {
            Ending::Done => 0,
            Ending::Infeasible => 3,
            Ending::Cancelled => 4,
        }
    }
}

/// Identifies the dynamics of robot arms.
#[derive(Debug, Parser)]
#[command(version, about, after_help = EXIT_STATUS)]
struct Arguments {
    /// Print results and errors as JSON.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

const EXIT_STATUS: &str = "Exit status: 0 done, 1 internal error, 2 wrong usage or input, 3 infeasible, 4 cancelled (the best trajectory found is written).";

#[derive(Debug, Subcommand)]
enum Command {
    /// Design an excitation trajectory.
    Excite(excite::Arguments),
    /// Identify the parameters of a robot from logs.
    Identify(identify::Arguments),
    /// Hold an identified model against logs.
    Validate(validate::Arguments),
    /// Write an identified model as URDF, MJCF, SDF, CSV, C or Python.
    Model(model::Arguments),
    /// Let a virtual robot write a log.
    Simulate(simulate::Arguments),
    /// Print what is understood of a robot's file: chain, limits, masses, notes.
    Robot(robot::Arguments),
    /// Print the columns of a log, and which of them are taken for what.
    Log(log::Arguments),
    /// Print the base parameters of a robot.
    BaseParameters(base_parameters::Arguments),
    /// Serve the HTTP interface.
    #[cfg(feature = "service")]
    Serve(Box<serve::Arguments>),
    /// Do jobs of a server's PostgreSQL database on this machine.
    #[cfg(feature = "service")]
    Worker(Box<serve::Arguments>),
    /// Work for a server that has started this.
    #[cfg(feature = "service")]
    #[command(hide = true)]
    Child(child::Arguments),
    /// Print the settings of serve and worker, and where they come from.
    #[cfg(feature = "service")]
    Config(Box<serve::Arguments>),
    /// Make, list and revoke bearer tokens.
    #[cfg(feature = "service")]
    Token(token::Arguments),
    /// Print who did what.
    #[cfg(feature = "service")]
    Audit(store::AuditArguments),
    /// Write all stored data to an archive; a server may go on meanwhile.
    #[cfg(feature = "service")]
    Backup(store::BackupArguments),
    /// Fill an empty data folder or database from an archive.
    #[cfg(feature = "service")]
    Restore(store::BackupArguments),
    /// Print the OpenAPI document of the HTTP interface.
    #[cfg(feature = "service")]
    Openapi,
    /// Print the completion of a shell: `source <(dynident completions bash)`.
    Completions(shell::CompletionArguments),
    /// Write the manual pages of all commands.
    Man(shell::ManArguments),
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let json = arguments.json;
    match run(arguments) {
        Ok(ending) => ExitCode::from(ending.exit_status()),
        Err(error) => {
            render::print_error(&error, json);
            ExitCode::from(error.code.exit_status())
        }
    }
}

/// Runs the program with these arguments, the first of which is its name, and returns the exit status: for whoever runs many
/// commands in one process. Ctrl-C ends all of them.
///
/// # Errors
/// What the program would print as an error; its exit status is that of the code.
pub fn run_with<I>(arguments: I) -> Result<u8, Error>
where
    I: IntoIterator,
    I::Item: Into<std::ffi::OsString> + Clone,
{
    match Arguments::try_parse_from(arguments) {
        Ok(arguments) => run(arguments).map(Ending::exit_status),
        Err(usage) => {
            let _ = usage.print();
            Ok(u8::try_from(usage.exit_code()).unwrap_or(2))
        }
    }
}

fn run(arguments: Arguments) -> Result<Ending, Error> {
    let json = arguments.json;
    match arguments.command {
        Command::Excite(arguments) => excite::run(&arguments, json),
        Command::Identify(arguments) => identify::run(&arguments, json),
        Command::Validate(arguments) => validate::run(&arguments, json),
        Command::Model(arguments) => model::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments, json),
        Command::Robot(arguments) => robot::run(&arguments, json),
        Command::Log(arguments) => log::run(&arguments, json),
        Command::BaseParameters(arguments) => base_parameters::run(&arguments, json),
        #[cfg(feature = "service")]
        Command::Serve(arguments) => serve::run(&arguments),
        #[cfg(feature = "service")]
        Command::Worker(arguments) => serve::run_worker(&arguments),
        #[cfg(feature = "service")]
        Command::Child(arguments) => child::run(&arguments),
        #[cfg(feature = "service")]
        Command::Config(arguments) => serve::run_config(&arguments),
        #[cfg(feature = "service")]
        Command::Token(arguments) => token::run(&arguments, json),
        #[cfg(feature = "service")]
        Command::Audit(arguments) => store::run_audit(&arguments, json),
        #[cfg(feature = "service")]
        Command::Backup(arguments) => store::run_backup(&arguments),
        #[cfg(feature = "service")]
        Command::Restore(arguments) => store::run_restore(&arguments),
        #[cfg(feature = "service")]
        Command::Openapi => openapi::run(),
        Command::Completions(arguments) => shell::run_completions(&arguments),
        Command::Man(arguments) => shell::run_man(&arguments),
    }
}
