//! A robot written out as URDF, in the frames of the description it came from.

use super::frames::{Described, base_name, described, free_name, mounting, number, roll_pitch_yaw, triple};
use crate::model::{INERTIA_ENTRIES, Joint, Robot};
use nalgebra::Matrix3;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

/// The robot as URDF; links without prior parameters have no inertial. Where gravity does not point along −z of the base, the
/// base hangs on a fixed joint that turns it as it is mounted, and a comment says so.
pub fn urdf(robot: &Robot) -> String {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let written = write_urdf(&mut writer, robot);
    written.expect("writing to memory does not fail");
    String::from_utf8(writer.into_inner()).expect("XML is UTF-8") + "\n"
}

/// An XML file with a comment of these lines below its declaration; unchanged without lines.
pub(super) fn with_comment(mut xml: String, lines: &[String]) -> String {
    if !lines.is_empty() {
        let at = if xml.starts_with("<?xml") {
            xml.find("?>").map_or(0, |end| end + 2)
        } else {
            0
        };
        let (before, after) = if at == 0 { ("", "\n") } else { ("\n", "") };
        xml.insert_str(at, &format!("{before}<!--{}-->{after}", super::comment(lines)));
    }
    xml
}

fn write_urdf(writer: &mut Writer<Vec<u8>>, robot: &Robot) -> std::io::Result<()> {
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)))?;
    writer
        .create_element("robot")
        .with_attribute(("name", robot.name()))
        .write_inner_content(|w| {
            let base = base_name(robot);
            if let Some(turn) = mounting(robot) {
                write_mounting(w, robot, &turn, &base)?;
            }
            w.create_element("link")
                .with_attribute(("name", base.as_str()))
                .write_empty()?;
            let mut parent = base.as_str();
            for (joint, frame) in robot.joints().iter().zip(described(robot)) {
                write_link(w, joint, &frame)?;
                write_joint(w, joint, &frame, parent)?;
                parent = &joint.link_name;
            }
            Ok(())
        })?;
    Ok(())
}

/// The world, and the fixed joint that the base hangs on.
fn write_mounting(w: &mut Writer<Vec<u8>>, robot: &Robot, turn: &Matrix3<f64>, base: &str) -> std::io::Result<()> {
    let world = free_name(robot, "world");
    let along = triple(robot.gravity().as_slice());
    let said = format!(
        " gravity is [{along}] m/s^2 in {base}: the fixed joint turns it so that gravity points along the negative z axis of {world} "
    );
    w.write_event(Event::Comment(BytesText::new(&said)))?;
    w.create_element("link")
        .with_attribute(("name", world.as_str()))
        .write_empty()?;
    let mut name = "mounting".to_string();
    while robot.joints().iter().any(|j| j.name == name) {
        name.push('_');
    }
    w.create_element("joint")
        .with_attribute(("name", name.as_str()))
        .with_attribute(("type", "fixed"))
        .write_inner_content(|w| {
            w.create_element("origin")
                .with_attribute(("xyz", "0 0 0"))
                .with_attribute(("rpy", triple(&roll_pitch_yaw(turn)).as_str()))
                .write_empty()?;
            w.create_element("parent")
                .with_attribute(("link", world.as_str()))
                .write_empty()?;
            w.create_element("child").with_attribute(("link", base)).write_empty()?;
            Ok(())
        })?;
    Ok(())
}

fn write_link(w: &mut Writer<Vec<u8>>, joint: &Joint, frame: &Described) -> std::io::Result<()> {
    let link = w.create_element("link").with_attribute(("name", joint.link_name.as_str()));
    let Some(prior) = &joint.prior else {
        return link.write_empty().map(drop);
    };
    let center = frame.turn * prior.inertia.center_of_mass;
    let i = frame.turn * prior.inertia.inertia * frame.turn.transpose();
    link.write_inner_content(|w| {
        w.create_element("inertial").write_inner_content(|w| {
            w.create_element("origin")
                .with_attribute(("xyz", triple(center.as_slice()).as_str()))
                .with_attribute(("rpy", "0 0 0"))
                .write_empty()?;
            w.create_element("mass")
                .with_attribute(("value", number(prior.inertia.mass).as_str()))
                .write_empty()?;
            let entries = INERTIA_ENTRIES.map(|(name, r, c)| (name, number(i[(r, c)])));
            w.create_element("inertia")
                .with_attributes(entries.iter().map(|(n, v)| (*n, v.as_str())))
                .write_empty()?;
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}

/// Stands for no limit where the format must have one, as in files of others.
const NO_LIMIT: f64 = 1e16;

/// Attributes of `<limit>`. ROS's parser (urdfdom) takes no joint without effort and velocity, and reads a missing position as 0.
fn limits(joint: &Joint) -> Vec<(&'static str, String)> {
    let l = &joint.limits;
    let position = l.position.or((!joint.is_revolute()).then_some([-NO_LIMIT, NO_LIMIT]));
    let ends = position.map(|[low, high]| [("lower", number(low)), ("upper", number(high))]);
    let magnitudes = [("effort", l.effort), ("velocity", l.velocity)];
    let stated = magnitudes.map(|(name, v)| (name, number(v.unwrap_or(NO_LIMIT))));
    ends.into_iter().flatten().chain(stated).collect()
}

fn write_joint(w: &mut Writer<Vec<u8>>, joint: &Joint, frame: &Described, parent: &str) -> std::io::Result<()> {
    let bounded = joint.limits.position.is_some();
    let kind = match (joint.is_revolute(), bounded) {
        (true, true) => "revolute",
        (true, false) => "continuous",
        (false, _) => "prismatic",
    };
    w.create_element("joint")
        .with_attribute(("name", joint.name.as_str()))
        .with_attribute(("type", kind))
        .write_inner_content(|w| {
            let (xyz, rpy) = (
                triple(frame.pose.translation.as_slice()),
                triple(&roll_pitch_yaw(&frame.pose.rotation)),
            );
            w.create_element("origin")
                .with_attribute(("xyz", xyz.as_str()))
                .with_attribute(("rpy", rpy.as_str()))
                .write_empty()?;
            w.create_element("parent").with_attribute(("link", parent)).write_empty()?;
            w.create_element("child")
                .with_attribute(("link", joint.link_name.as_str()))
                .write_empty()?;
            w.create_element("axis")
                .with_attribute(("xyz", triple(frame.axis.as_slice()).as_str()))
                .write_empty()?;
            let limits = limits(joint);
            w.create_element("limit")
                .with_attributes(limits.iter().map(|(n, v)| (*n, v.as_str())))
                .write_empty()?;
            if let Some(prior) = &joint.prior {
                let (damping, friction) = (number(prior.viscous), number(prior.coulomb));
                w.create_element("dynamics")
                    .with_attribute(("damping", damping.as_str()))
                    .with_attribute(("friction", friction.as_str()))
                    .write_empty()?;
            }
            Ok(())
        })?;
    Ok(())
}
