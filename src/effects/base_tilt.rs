//! A base that does not stand as the model says.

use super::{About, Effect, Kind, ParameterInfo, Reads, Scene, World};
use crate::model::Robot;
use nalgebra::Rotation3;

/// The base is turned by roll about its x axis, then pitch about y: in its frame gravity is `Rᵀ g` with `R = Ry(pitch) Rx(roll)`.
pub struct BaseTilt;

impl Effect for BaseTilt {
    fn code(&self) -> &'static str {
        "base_tilt"
    }

    fn about(&self) -> About {
        About {
            meaning: "the direction of gravity is not the one of the model: a base that is not level, a table that is not flat",
            identifiable: "on robots whose gravity torques change with the first joints; a turn about gravity itself is never seen",
            rivals: &["torque_offset", "encoder_offset"],
            source: "Swevers, Verdonck & De Schutter 2007",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn kind(&self) -> Kind {
        Kind::Distortion
    }

    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        if robot.gravity().norm() > 0.0 {
            vec![Vec::new()]
        } else {
            Vec::new()
        }
    }

    fn distort(&self, scene: &Scene, _joints: &[usize], theta: &[f64], world: &mut World) {
        world.gravity = Rotation3::from_euler_angles(theta[0], theta[1], 0.0).inverse() * scene.robot.gravity();
    }

    fn steps(&self) -> &'static [f64] {
        &[1e-5, 1e-5]
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("roll", "rad"), ParameterInfo::new("pitch", "rad")]
    }
}
