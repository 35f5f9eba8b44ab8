//! A parameter of a finding with its unit and standard deviation.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::ParameterInfo;
use crate::model::Robot;

/// A parameter of an effect with one standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedParameter {
    /// Name of the parameter.
    pub name: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// Unit of the value; empty for pure numbers.
    pub unit: String,
    /// Not finite, or beyond any size, where the data do not determine the value.
    pub std_dev: f64,
}

/// Whether a deviation is one: the data say something of its value.
pub fn is_determined(std_dev: f64) -> bool {
    std_dev.abs() < SETTINGS.selection.undetermined
}

impl ReportedParameter {
    /// Values and their standard deviations under the names of an effect's parameters.
    pub(crate) fn of(infos: Vec<ParameterInfo>, values: impl IntoIterator<Item = (f64, f64)>) -> Vec<Self> {
        let reported = |(info, (value, std_dev)): (ParameterInfo, (f64, f64))| Self {
            name: info.name,
            value,
            unit: info.unit,
            std_dev,
        };
        infos.into_iter().zip(values).map(reported).collect()
    }
}

/// Names of the joints; all of them for an effect of the whole robot.
pub(crate) fn joint_names(robot: &Robot, joints: &[usize]) -> Vec<String> {
    let name = |j: usize| robot.joints()[j].name.clone();
    if joints.is_empty() {
        (0..robot.joint_count()).map(name).collect()
    } else {
        joints.iter().map(|&j| name(j)).collect()
    }
}
