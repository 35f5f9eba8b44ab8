//! A gear that winds up between the encoder and the link.

use super::interpolation::derivatives;
use super::ranges::{COMPLIANCE_M, COMPLIANCE_RAD, by_kind};
use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene, World};
use crate::model::Robot;

/// Encoder and friction on the motor side: `q_link = q − c tau_rigid(q_link)`, c = 1/K the compliance, with velocity and
/// acceleration to match. Bodies move with the link.
pub struct JointElasticity;

impl Effect for JointElasticity {
    fn code(&self) -> &'static str {
        "joint_elasticity"
    }

    fn about(&self) -> About {
        About {
            name: "Joint elasticity",
            phrase: "elasticity between motor and link",
            meaning: "Torsional compliance between motor and link, which matters where the motion is fast for the stiffness.",
            over: PlotVariable::Torque,
            identifiable: "when load and its change move the link visibly: gravity loads of tens of N m at some 10 kN m/rad",
            rivals: &["encoder_offset", "rotor_inertia", "torque_gain", "base_tilt"],
            source: "Spong 1987; De Luca & Book 2016 (quasi-static part)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Course
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Distortion
    }

    fn distort(&self, scene: &Scene, joints: &[usize], theta: &[f64], world: &mut World) {
        let j = joints[0];
        let [load, load_d, load_dd] = derivatives(&scene.rigid[j], scene.interval, scene.periodic);
        let mut links = world.motions().links.clone();
        for s in 0..scene.samples() {
            let [q, qd, qdd] = links.get(j, s);
            links.set(
                j,
                s,
                [q - theta[0] * load[s], qd - theta[0] * load_d[s], qdd - theta[0] * load_dd[s]],
            );
        }
        world.links = Some(links);
    }

    fn distorts_by_load(&self) -> bool {
        true
    }

    fn steps(&self) -> &'static [f64] {
        // 1e-9 rad/(N m) is 1 GN m/rad, 100,000 times stiffer than a robot's gear.
        &[1e-9]
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn ranges(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<[f64; 2]> {
        let most = by_kind(robot, joints[0], COMPLIANCE_RAD, COMPLIANCE_M);
        vec![[-most, most]]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        let (effort, position) = (joint.effort_unit(), joint.position_unit());
        vec![
            ParameterInfo::new("compliance", format!("{position}/({effort})")),
            ParameterInfo::new("stiffness", format!("{effort}/{position}")),
        ]
    }

    fn reported(&self, _form: usize, _coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        vec![shape[0], 1.0 / shape[0]]
    }
}
