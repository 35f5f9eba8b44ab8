//! The model as SDF (Gazebo), with frames relative to each other (SDF 1.7 and later).

use super::FinalModel;
use super::frames::{Described, base_name, described, mounting, number, roll_pitch_yaw, triple};
use super::xml::Xml;
use crate::model::{INERTIA_ENTRIES, Joint};
use crate::spatial::Transform;
use nalgebra::Matrix3;

impl FinalModel {
    pub(super) fn sdf(&self, remarks: &[String]) -> String {
        let robot = self.absorbed();
        let base = base_name(&robot);
        let mut xml = Xml::new();
        xml.open("sdf", &[("version", "1.7")]);
        xml.open("model", &[("name", robot.name())]);
        xml.comment(remarks);
        // Gravity is that of the world, along −z: the base stands in it as it is mounted.
        let turn = mounting(&robot).unwrap_or_else(Matrix3::identity);
        xml.open("link", &[("name", &base)]);
        xml.text("pose", &[], &pose(&Transform::from_rotation(turn)));
        xml.close("link");
        let mut foot = "mounting".to_string();
        while robot.joints().iter().any(|j| j.name == foot) {
            foot.push('_');
        }
        xml.open("joint", &[("name", &foot), ("type", "fixed")]);
        xml.text("parent", &[], "world");
        xml.text("child", &[], &base);
        xml.close("joint");
        let mut parent = base.as_str();
        for (j, (joint, frame)) in robot.joints().iter().zip(described(&robot)).enumerate() {
            write_link(&mut xml, joint, &frame);
            self.write_joint(&mut xml, j, &frame, parent);
            parent = &joint.link_name;
        }
        xml.close("model");
        xml.close("sdf");
        xml.finish()
    }

    fn write_joint(&self, xml: &mut Xml, j: usize, frame: &Described, parent: &str) {
        let joint = &self.robot.joints()[j];
        let kind = match (joint.is_revolute(), joint.limits.position) {
            (true, None) => "continuous",
            (true, Some(_)) => "revolute",
            (false, _) => "prismatic",
        };
        xml.open("joint", &[("name", &joint.name), ("type", kind)]);
        xml.text("parent", &[], parent);
        xml.text("child", &[], &joint.link_name);
        xml.text("pose", &[("relative_to", parent)], &pose(&frame.pose));
        xml.open("axis", &[]);
        xml.text("xyz", &[], &triple(frame.axis.as_slice()));
        write_limits(xml, joint);
        xml.open("dynamics", &[]);
        if let Some(prior) = &joint.prior {
            xml.text("damping", &[], &number(prior.viscous));
            xml.text("friction", &[], &number(prior.coulomb));
        }
        let [stiffness, constant] = self.spring(j);
        if stiffness > 0.0 {
            xml.text("spring_reference", &[], &number(-constant / stiffness));
            xml.text("spring_stiffness", &[], &number(stiffness));
        }
        ["dynamics", "axis", "joint"].iter().for_each(|name| xml.close(name));
    }
}

fn pose(t: &Transform) -> String {
    triple(&[t.translation.as_slice(), &roll_pitch_yaw(&t.rotation)].concat())
}

/// The frame of a link is that of its joint.
fn write_link(xml: &mut Xml, joint: &Joint, frame: &Described) {
    xml.open("link", &[("name", &joint.link_name)]);
    xml.text("pose", &[("relative_to", &joint.name)], "0 0 0 0 0 0");
    if let Some(prior) = &joint.prior {
        let center = frame.turn * prior.inertia.center_of_mass;
        let i = frame.turn * prior.inertia.inertia * frame.turn.transpose();
        xml.open("inertial", &[]);
        xml.text("pose", &[], &triple(&[center.as_slice(), &[0.0; 3]].concat()));
        xml.text("mass", &[], &number(prior.inertia.mass));
        xml.open("inertia", &[]);
        INERTIA_ENTRIES
            .iter()
            .for_each(|(name, r, c)| xml.text(name, &[], &number(i[(*r, *c)])));
        xml.close("inertia");
        xml.close("inertial");
    }
    xml.close("link");
}

fn write_limits(xml: &mut Xml, joint: &Joint) {
    let l = &joint.limits;
    let [lower, upper] = l.position.map_or([None; 2], |ends| ends.map(Some));
    let stated = [
        ("lower", lower),
        ("upper", upper),
        ("effort", l.effort),
        ("velocity", l.velocity),
    ];
    if stated.iter().all(|(_, v)| v.is_none()) {
        return;
    }
    xml.open("limit", &[]);
    stated
        .iter()
        .filter_map(|(n, v)| Some((*n, (*v)?)))
        .for_each(|(name, v)| xml.text(name, &[], &number(v)));
    xml.close("limit");
}
