//! The base parameters of a robot as a document.

use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use serde::Serialize;

/// The smallest set of parameters that determines the torques of a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = BaseParameters))]
pub struct BaseParametersDocument {
    /// Name of the robot.
    pub robot: String,
    /// How many there are: the rank of the regressor.
    #[cfg_attr(feature = "service", schema(example = 57))]
    pub count: usize,
    /// The base parameters, in the order of the columns of the regressor `Y_b`.
    pub base_parameters: Vec<BaseParameterDocument>,
    /// Names of the standard parameters: columns of `map`.
    pub standard_parameters: Vec<String>,
    /// `map[i][j]`: how much of standard parameter j is in base parameter i.
    pub map: Vec<Vec<f64>>,
}

/// One base parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = BaseParameter))]
pub struct BaseParameterDocument {
    /// Name after the standard parameter that leads the combination, such as `ZZR1` or `FV3`.
    #[cfg_attr(feature = "service", schema(example = "MYR2"))]
    pub name: String,
    /// The linear combination of standard parameters, as text such as `MX2 + 0.42 M3`; lengths in m.
    #[cfg_attr(feature = "service", schema(example = "MY2 + MZ3 + 0.42 (M3 + M4 + M5 + M6 + M7)"))]
    pub expression: String,
    /// Unit of the value, such as `kg m^2`.
    #[cfg_attr(feature = "service", schema(example = "kg m"))]
    pub unit: &'static str,
}

impl BaseParametersDocument {
    /// Computes the base parameters of a robot in closed form, after Khalil and Dombre (2002), chapter 9.
    pub fn for_robot(robot: &Robot) -> Self {
        let base = BaseParameters::exact(robot);
        let one = |i: usize| BaseParameterDocument {
            name: base.names[i].clone(),
            expression: base.expressions[i].to_string(),
            unit: base.units[i],
        };
        Self {
            robot: robot.name().to_string(),
            count: base.len(),
            base_parameters: (0..base.len()).map(one).collect(),
            standard_parameters: Layout::standard(robot).names(),
            map: base.map.row_iter().map(|r| r.iter().copied().collect()).collect(),
        }
    }
}
