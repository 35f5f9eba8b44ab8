//! The model as numbers and statements, for source code of any language: Newton-Euler over tables, then the effects.

use super::FinalModel;
use super::source_channels::SourceChannels;
use super::source_effects::Statements;
use super::source_memory::Memory;
use crate::parameters::Layout;
use crate::spatial::LinkInertia;

/// A joint and its body as constants.
pub(super) struct SourceJoint {
    pub name: String,
    pub revolute: bool,
    /// Pose of the joint's frame in the one before it at q = 0.
    pub rotation: [[f64; 3]; 3],
    pub translation: [f64; 3],
    /// Added to the position that the encoder shows.
    pub offset: f64,
    pub body: LinkInertia,
    pub viscous: f64,
    pub coulomb: f64,
    /// Factor on the torque.
    pub gain: f64,
}

pub(super) struct Source {
    pub robot: String,
    pub gravity: [f64; 3],
    pub joints: Vec<SourceJoint>,
    pub effects: Vec<Statements>,
    /// Gravity without the tilt of the base: what loads of elastic joints are first computed with.
    pub robot_gravity: [f64; 3],
    pub memory: Memory,
    pub channels: SourceChannels,
}

/// A double that reads back as the same one, in C and in Python.
pub(super) fn literal(v: f64) -> String {
    format!("{v:?}")
}

pub(super) fn literals(values: &[f64]) -> String {
    values.iter().map(|v| literal(*v)).collect::<Vec<_>>().join(", ")
}

impl FinalModel {
    pub(super) fn source(&self) -> Source {
        let robot = self.tilted();
        let layout = Layout::standard(&robot);
        let phi = layout.prior(&robot).expect("every link has a body");
        let joint = |(j, joint): (usize, &crate::model::Joint)| {
            let prior = joint.prior.as_ref().expect("every link has a body");
            let r = joint.placement.rotation;
            let declared = robot.friction();
            let payloads = self.with_code("payload").filter(|t| t.joints == [j]);
            SourceJoint {
                name: joint.name.clone(),
                revolute: joint.is_revolute(),
                rotation: std::array::from_fn(|a| std::array::from_fn(|b| r[(a, b)])),
                translation: joint.placement.translation.into(),
                offset: self.encoder_offset(j),
                body: payloads.fold(layout.link_inertia(phi.as_slice(), j), |body, t| {
                    body + LinkInertia::from_parameters(&t.coefficients)
                }),
                viscous: if declared.viscous { prior.viscous } else { 0.0 },
                coulomb: if declared.coulomb { prior.coulomb } else { 0.0 },
                gain: self.gain(j),
            }
        };
        Source {
            robot: robot.name().to_string(),
            gravity: robot.gravity().into(),
            joints: robot.joints().iter().enumerate().map(joint).collect(),
            effects: self.statements(),
            robot_gravity: self.robot.gravity().into(),
            memory: self.memory(),
            channels: SourceChannels::of(self),
        }
    }
}

impl Source {
    /// Lines for the top of a file, without signs of a comment.
    /// `how`: the way in which further quantities are handed in.
    pub fn heading(&self, remarks: &[String], how: &str) -> Vec<String> {
        let mut lines = vec![
            format!(
                "Dynamics of {}, as identified by dynident {}.",
                one_line(&self.robot),
                env!("CARGO_PKG_VERSION")
            ),
            "SI units and radians: q rad (or m), tau N m (or N). Joints in order: ".to_string()
                + &self.joints.iter().map(|j| one_line(&j.name)).collect::<Vec<_>>().join(", ")
                + ".",
            "inverse_dynamics: torque of the joints for position, velocity and acceleration, with friction and effects.".into(),
            "gravity: torque that holds the arm still, without friction: inverse dynamics at rest.".into(),
            "mass_matrix: how that torque grows with the accelerations.".into(),
        ];
        if !self.memory.is_empty() {
            lines.extend(self.memory.heading());
        }
        lines.extend(self.channels.heading(how));
        lines.extend(remarks.iter().map(|r| format!("Note: {}", one_line(r))));
        lines
    }
}

/// Names come from users: no line breaks, and nothing that ends a comment.
pub(super) fn one_line(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    plain.replace("*/", "* /").replace("\"\"\"", "'''").replace('\\', "/")
}
