//! `dynident completions` and `dynident man`: what shells and `man` know of the program, made from its arguments.

use super::{Arguments as Program, Ending, files};
use crate::app::{Code, Error};
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct CompletionArguments {
    /// Shell that the completion is for.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completion: `source <(dynident completions bash)`.
pub fn run_completions(arguments: &CompletionArguments) -> Result<Ending, Error> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Program::command(), "dynident", &mut text);
    files::print(&String::from_utf8_lossy(&text))?;
    Ok(Ending::Done)
}

#[derive(Debug, clap::Args)]
pub struct ManArguments {
    /// Folder for the pages, one for every command.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

pub fn run_man(arguments: &ManArguments) -> Result<Ending, Error> {
    let folder = &arguments.out;
    let unwritable = |e: std::io::Error| Error::new(Code::FileUnwritable, format!("{}: {e}", folder.display()));
    std::fs::create_dir_all(folder).map_err(unwritable)?;
    clap_mangen::generate_to(Program::command(), folder).map_err(unwritable)?;
    Ok(Ending::Done)
}
