//! `dynident base-parameters`.

use super::known::EffectArguments;
use super::{Ending, files};
use crate::app::Error;
use crate::documents::{BaseParametersDocument, RobotDocument};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program.
    #[arg(long, value_name = "FILE|NAME")]
    robot: String,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let RobotDocument { robot, notes, .. } = files::read_robot(&arguments.robot, &arguments.chain, &arguments.effects.read()?)?;
    files::print_notes(&notes);
    let document = BaseParametersDocument::for_robot(&robot);
    if json {
        files::print(&files::pretty(&document))?;
        return Ok(Ending::Done);
    }
    let of = |p: &crate::documents::BaseParameterDocument| format!("{:8} [{}]  {}\n", p.name, p.unit, p.expression);
    let lines: String = document.base_parameters.iter().map(of).collect();
    files::print(&format!("{}: {} base parameters\n{lines}", document.robot, document.count))?;
    Ok(Ending::Done)
}
