//! The model as MJCF (MuJoCo).
//!
//! Damping, Coulomb friction, rotor inertia and springs stand on the joints; a coupling of two joints is a tendon. Every joint
//! has an actuator whose control is the torque as it was measured: constant torques and gains are its bias and gain. Inverse
//! dynamics then are `ctrl = (qfrc_inverse − bias)/gain`.

use super::effects_held::{IMPEDANCE, SOLREF, coupling_ratio};
use super::frames::{Described, described, number, triple};
use super::xml::Xml;
use super::{FinalModel, ModelFormat};
use crate::model::{Joint, Robot};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

impl FinalModel {
    pub(super) fn mjcf(&self, remarks: &[String]) -> String {
        let robot = self.absorbed();
        let mut xml = Xml::new();
        xml.open("mujoco", &[("model", robot.name())]);
        xml.comment(remarks);
        xml.empty("compiler", &[("angle", "radian")]);
        xml.empty("option", &[("gravity", &triple(robot.gravity().as_slice()))]);
        xml.open("worldbody", &[]);
        let frames = described(&robot);
        for (j, (joint, frame)) in robot.joints().iter().zip(&frames).enumerate() {
            self.body(&mut xml, j, joint, frame);
        }
        frames.iter().for_each(|_| xml.close("body"));
        xml.close("worldbody");
        self.tendons(&mut xml, &robot);
        self.actuators(&mut xml, &robot);
        xml.close("mujoco");
        xml.finish()
    }

    fn body(&self, xml: &mut Xml, j: usize, joint: &Joint, frame: &Described) {
        let position = triple(frame.pose.translation.as_slice());
        let turn = quaternion(&frame.pose.rotation);
        xml.open("body", &[("name", &joint.link_name), ("pos", &position), ("quat", &turn)]);
        if let Some(prior) = &joint.prior {
            let center = frame.turn * prior.inertia.center_of_mass;
            let i = frame.turn * prior.inertia.inertia * frame.turn.transpose();
            let entries = [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]];
            let (mass, center, inertia) = (number(prior.inertia.mass), triple(center.as_slice()), triple(&entries));
            xml.empty("inertial", &[("pos", &center), ("mass", &mass), ("fullinertia", &inertia)]);
        }
        let attributes = self.joint(j, joint, frame);
        let attributes: Vec<(&str, &str)> = attributes.iter().map(|(n, v)| (*n, v.as_str())).collect();
        xml.empty("joint", &attributes);
        for capsule in &joint.geometry {
            let ends = capsule.ends.map(|end| frame.turn * end);
            let ends = triple(&[ends[0].as_slice(), ends[1].as_slice()].concat());
            // The shape is to be seen, and neither collides nor weighs.
            let shown = [
                ("contype", "0"),
                ("conaffinity", "0"),
                ("mass", "0"),
                ("rgba", "0.7 0.7 0.7 1"),
            ];
            let size = number(capsule.radius);
            xml.empty(
                "geom",
                &[&[("type", "capsule"), ("fromto", &*ends), ("size", &*size)], &shown[..]].concat(),
            );
        }
    }

    fn joint(&self, j: usize, joint: &Joint, frame: &Described) -> Vec<(&'static str, String)> {
        let kind = if joint.is_revolute() { "hinge" } else { "slide" };
        let mut list = vec![
            ("name", joint.name.clone()),
            ("type", kind.into()),
            ("axis", triple(frame.axis.as_slice())),
        ];
        if let Some(ends) = joint.limits.position {
            list.extend([("limited", "true".into()), ("range", triple(&ends))]);
        }
        if let Some(prior) = &joint.prior {
            list.push(("damping", number(prior.viscous)));
            list.extend(friction(prior.coulomb));
        }
        let armature = self.sum("rotor_inertia", j, 0);
        if armature > 0.0 {
            list.push(("armature", number(armature)));
        }
        let [stiffness, constant] = self.spring(j);
        if stiffness > 0.0 {
            list.extend([("stiffness", number(stiffness)), ("springref", number(-constant / stiffness))]);
        }
        list
    }

    /// Couplings: friction and inertia of the speed `qd_i + k qd_j`.
    fn tendons(&self, xml: &mut Xml, robot: &Robot) {
        let couplings: Vec<_> = self
            .with_code("transmission_coupling")
            .filter(|t| ModelFormat::Mjcf.holds(t))
            .collect();
        if couplings.is_empty() {
            return;
        }
        xml.open("tendon", &[]);
        for (at, term) in couplings.into_iter().enumerate() {
            let [viscous, coulomb, inertia] = [0, 1, 2].map(|c| term.coefficients[c]);
            let mut list = vec![
                ("name", format!("coupling{}", at + 1)),
                ("damping", number(viscous)),
                ("armature", number(inertia)),
            ];
            list.extend(friction(coulomb));
            let list: Vec<(&str, &str)> = list.iter().map(|(n, v)| (*n, v.as_str())).collect();
            xml.open("fixed", &list);
            for (&joint, ratio) in term.joints.iter().zip([1.0, coupling_ratio(term)]) {
                xml.empty("joint", &[("joint", &robot.joints()[joint].name), ("coef", &number(ratio))]);
            }
            xml.close("fixed");
        }
        xml.close("tendon");
    }

    /// Controls are torques as they were measured: `(1 + γ)(tau + o)` of what acts on the joint.
    fn actuators(&self, xml: &mut Xml, robot: &Robot) {
        xml.open("actuator", &[]);
        for (j, joint) in robot.joints().iter().enumerate() {
            let [gain, offset] = [
                number(1.0 / Some(self.gain(j)).filter(|g| *g > 0.0).unwrap_or(1.0)),
                triple(&[-self.sum("torque_offset", j, 0), 0.0, 0.0]),
            ];
            let mut list = vec![
                ("name", joint.name.as_str()),
                ("joint", joint.name.as_str()),
                ("gaintype", "fixed"),
                ("gainprm", &gain),
            ];
            list.extend([("biastype", "affine"), ("biasprm", offset.as_str())]);
            let range = joint.limits.effort.map(|most| triple(&[-most, most]));
            if let Some(range) = &range {
                list.extend([("ctrllimited", "true"), ("ctrlrange", range)]);
            }
            xml.empty("general", &list);
        }
        xml.close("actuator");
    }
}

/// Coulomb friction, as close to it as a soft constraint comes.
fn friction(force: f64) -> Vec<(&'static str, String)> {
    if force <= 0.0 {
        return Vec::new();
    }
    vec![
        ("frictionloss", number(force)),
        ("solreffriction", triple(&SOLREF)),
        ("solimpfriction", triple(&[IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0])),
    ]
}

/// `w x y z`.
fn quaternion(rotation: &Matrix3<f64>) -> String {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    triple(&[q.w, q.i, q.j, q.k])
}
