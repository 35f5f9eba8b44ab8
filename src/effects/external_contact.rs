//! Something the robot touched.

use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable};
use crate::model::Robot;

/// Torque in an interval of time only, one level per joint. Found between the periods, and the interval is left out of the fit.
pub struct ExternalContact;

impl Effect for ExternalContact {
    fn code(&self) -> &'static str {
        "external_contact"
    }

    fn about(&self) -> About {
        About {
            name: "External contact",
            phrase: "an external contact",
            meaning: "A force from outside during a part of the log.",
            over: PlotVariable::Time,
            identifiable: "when it happens in some periods only: one that comes back in every period at the same place is a part of the \
                           robot's world",
            rivals: &["torque_offset", "friction_drift", "bad_samples"],
            source: "Haddadin, De Luca & Albu-Schäffer 2017",
        }
    }

    fn kind(&self) -> EffectKind {
        EffectKind::BetweenPeriods
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let mut list = vec![ParameterInfo::new("start", "s"), ParameterInfo::new("end", "s")];
        list.extend(joints.iter().map(|&j| {
            let joint = &robot.joints()[j];
            ParameterInfo::new(format!("torque_{}", joint.name), joint.effort_unit())
        }));
        list
    }
}
