//! An encoder whose zero is not where the model has it.

use super::ranges::{ENCODER_OFFSET_M, ENCODER_OFFSET_RAD, by_kind};
use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene, World};
use crate::model::Robot;

/// `q_true = q + δ_j`.
pub struct EncoderOffset;

impl Effect for EncoderOffset {
    fn code(&self) -> &'static str {
        "encoder_offset"
    }

    fn about(&self) -> About {
        About {
            name: "Encoder offset",
            phrase: "an encoder offset",
            meaning: "The zero of a position sensor differs from that of the description.",
            over: PlotVariable::Position,
            identifiable: "when gravity or coupling torques change with the joint's angle in a way that the base parameters cannot turn \
                           with; joint 1 on a vertical axis cannot be seen, nor can the last joint, whose link turns with it",
            rivals: &["base_tilt", "joint_elasticity", "joint_spring"],
            source: "Khalil & Dombre 2004, chapter 11",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Distortion
    }

    fn distort(&self, scene: &Scene, joints: &[usize], theta: &[f64], world: &mut World) {
        for s in 0..scene.samples() {
            let [q, qd, qdd] = world.motion.get(joints[0], s);
            world.motion.set(joints[0], s, [q + theta[0], qd, qdd]);
        }
    }

    fn steps(&self) -> &'static [f64] {
        &[1e-7]
    }

    fn ranges(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<[f64; 2]> {
        let most = by_kind(robot, joints[0], ENCODER_OFFSET_RAD, ENCODER_OFFSET_M);
        vec![[-most, most]]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("offset", robot.joints()[joints[0]].position_unit())]
    }
}
