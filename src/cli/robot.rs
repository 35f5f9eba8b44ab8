//! `dynident robot`: what is understood of a robot's file.

use super::known::EffectArguments;
use super::{Ending, files};
use crate::app::Error;
use crate::documents::{ReportedJoint, RobotReport};
use std::fmt::Write;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON, URDF or MJCF file, or the name of one that comes with the program.
    #[arg(value_name = "FILE|NAME")]
    robot: String,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let read = files::read_robot(&arguments.robot, &arguments.chain, &arguments.effects.read()?)?;
    let report = RobotReport::from_document(&read);
    files::print(&if json { files::pretty(&report) } else { table(&report) })?;
    Ok(Ending::Done)
}

fn table(report: &RobotReport) -> String {
    let mass = report.moving_mass_kg.map_or("unknown".to_string(), |m| format!("{m:.3} kg"));
    let mut text = format!(
        "{}: {} joints, {} base parameters, moving mass {mass}\n{:16} {:9} {:20} {:22} {:>10} {:>12} {:>10}\n",
        report.robot,
        report.joints.len(),
        report.base_parameters,
        "joint",
        "kind",
        "link",
        "position",
        "velocity",
        "effort",
        "mass"
    );
    report.joints.iter().for_each(|j| row(&mut text, j));
    report.notes.iter().for_each(|note| {
        let _ = writeln!(text, "note: {note}");
    });
    text
}

fn row(text: &mut String, joint: &ReportedJoint) {
    let number = |v: Option<f64>, unit: &str| v.map_or("-".to_string(), |v| format!("{v:.4} {unit}"));
    let unit = joint.position_unit;
    let position = joint
        .position
        .map_or("-".to_string(), |[low, high]| format!("{low:.3} … {high:.3} {unit}"));
    let _ = writeln!(
        text,
        "{:16} {:9} {:20} {position:22} {:>10} {:>12} {:>10}",
        joint.name,
        joint.kind,
        joint.link,
        joint.velocity.map_or("-".to_string(), |v| format!("{v:.3}/s")),
        number(joint.effort, joint.effort_unit),
        number(joint.mass, "kg"),
    );
}
