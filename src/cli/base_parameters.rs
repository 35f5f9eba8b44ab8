//! `dynident base-parameters`.

use super::{Ending, files};
use crate::app::{Code, Error};
use crate::io::shipped::Shipped;
use crate::io::{BaseParametersDocument, NamedRobots, RobotDocument, robot_document};
use serde_json::Value;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program.
    #[arg(long, value_name = "FILE|NAME")]
    robot: String,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let RobotDocument { robot, notes } = read(&arguments.robot)?;
    let document = BaseParametersDocument::of(&robot);
    if json {
        files::print(&files::pretty(&document))?;
        return Ok(Ending::Done);
    }
    for note in notes {
        eprintln!("note: {note}");
    }
    let of = |p: &crate::io::BaseParameterDocument| format!("{:8} [{}]  {}\n", p.name, p.unit, p.expression);
    let lines: String = document.base_parameters.iter().map(of).collect();
    files::print(&format!("{}: {} base parameters\n{lines}", document.robot, document.count))?;
    Ok(Ending::Done)
}

fn read(name_or_file: &str) -> Result<RobotDocument, Error> {
    let parsed = files::robot(name_or_file)?;
    match &parsed.value {
        Value::String(name) => Shipped
            .named(name)
            .ok_or_else(|| Error::new(Code::UnknownRobot, format!("there is no robot `{name}`"))),
        _ => robot_document(&parsed).map_err(|errors| Error::invalid(&format!("the robot in {name_or_file}"), errors)),
    }
}
