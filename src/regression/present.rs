//! The world of a model along a stretch, and the declared torque in it.

use super::dataset::Stretch;
use super::declared_torque::Torques;
use super::model::AugmentedModel;
use crate::effects::{Motions, World};

/// The world of a model, and the declared torque in it before any gain, n × N [N·m or N].
#[derive(Clone, Copy)]
pub(crate) struct KnownTorque<'a> {
    pub world: &'a World,
    pub declared: &'a [Vec<f64>],
}

/// The world of a model along a stretch, with the declared torques in it and along the motion as it was measured.
pub(crate) struct Present {
    world: World,
    declared: Vec<Vec<f64>>,
    pub undistorted: Torques,
}

impl Present {
    pub fn of(model: &AugmentedModel, stretch: &Stretch) -> Self {
        let undistorted = model.torques(Motions::stiff(&stretch.motion), &model.robot, None);
        let world = model.world(stretch, &undistorted, None);
        let declared = match (world.motions(), world.gravity) == (Motions::stiff(&stretch.motion), model.robot.gravity()) {
            true => undistorted.declared.clone(),
            false => {
                let robot = model.robot.with_gravity(world.gravity);
                model.torques(world.motions(), &robot, None).declared
            }
        };
        Self {
            world,
            declared,
            undistorted,
        }
    }

    pub fn known(&self) -> KnownTorque<'_> {
        KnownTorque {
            world: &self.world,
            declared: &self.declared,
        }
    }
}
