//! `dynident child`: what a server starts for the work of its jobs and requests; nobody else has a use for it.

use super::Ending;
use crate::app::Error;
use crate::service::child;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Memory that the work may take.
    #[arg(long, value_name = "BYTES")]
    memory: u64,
}

pub fn run(arguments: &Arguments) -> Result<Ending, Error> {
    // Whoever stops a whole service stops its server: that tells the children, by closing their sockets.
    let _ = ctrlc::set_handler(|| {});
    child::main(arguments.memory)?;
    Ok(Ending::Done)
}
