//! A parameter of a finding with its unit and standard deviation.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::ParameterInfo;
use crate::model::Robot;
use serde::{Serialize, Serializer};

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReportedParameter {
    pub name: String,
    pub value: f64,
    pub unit: String,
    /// Written as null where it is not known.
    #[serde(serialize_with = "of_deviation")]
    pub std_dev: f64,
}

/// Whether a deviation is one: the data say something of its value.
pub(crate) fn is_determined(std_dev: f64) -> bool {
    std_dev.abs() < SETTINGS.selection.undetermined
}

/// A standard deviation, or null where the data do not determine the value.
pub(crate) fn of_deviation<S: Serializer>(std_dev: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    is_determined(*std_dev).then_some(*std_dev).serialize(serializer)
}

impl ReportedParameter {
    /// Values and their standard deviations under the names of an effect's parameters.
    pub(crate) fn of(infos: Vec<ParameterInfo>, values: impl IntoIterator<Item = (f64, f64)>) -> Vec<Self> {
        let told = |(info, (value, std_dev)): (ParameterInfo, (f64, f64))| Self {
            name: info.name,
            value,
            unit: info.unit,
            std_dev,
        };
        infos.into_iter().zip(values).map(told).collect()
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
