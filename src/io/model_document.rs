//! A robot written out again: as a robot document and as URDF, in the frames of the description it came from.

use super::bounds_document::{axis_name, bounds_value};
use crate::model::{Capsule, INERTIA_ENTRIES, Joint, Robot};
use crate::spatial::Transform;
use nalgebra::{Matrix3, Rotation3, Vector3};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

/// Joint frames as the description has them: pose in the frame before, and the joint's axis.
pub(super) struct Described {
    pub pose: Transform,
    pub axis: Vector3<f64>,
    pub turn: Matrix3<f64>,
}

pub(super) fn described(robot: &Robot) -> Vec<Described> {
    let mut before = Matrix3::identity();
    robot
        .joints()
        .iter()
        .map(|joint| {
            let turn = joint.description_frame;
            let pose = Transform::from_rotation(before) * joint.placement * Transform::from_rotation(turn.transpose());
            before = turn;
            Described {
                pose,
                axis: turn * Vector3::z(),
                turn,
            }
        })
        .collect()
}

/// Roll, pitch, yaw with `R = Rz(yaw) Ry(pitch) Rx(roll)`.
pub(super) fn roll_pitch_yaw(r: &Matrix3<f64>) -> [f64; 3] {
    let across = r[(0, 0)].hypot(r[(1, 0)]);
    let pitch = (-r[(2, 0)]).atan2(across);
    // Straight up or down yaw and roll turn about the same line: all of it is given to yaw.
    if across < 1e-9 {
        return [0.0, pitch, (-r[(0, 1)]).atan2(r[(1, 1)])];
    }
    [r[(2, 1)].atan2(r[(2, 2)]), pitch, r[(1, 0)].atan2(r[(0, 0)])]
}

/// The robot as a document that POST /robots takes, its priors included.
pub fn robot_value(robot: &Robot) -> Value {
    let joints: Vec<Value> = robot
        .joints()
        .iter()
        .zip(described(robot))
        .map(|(joint, frame)| joint_value(joint, &frame))
        .collect();
    let friction = robot.friction();
    let declared: Vec<&str> = [(friction.viscous, "viscous"), (friction.coulomb, "coulomb")]
        .iter()
        .filter(|(on, _)| *on)
        .map(|(_, n)| *n)
        .collect();
    json!({"name": robot.name(), "gravity": robot.gravity().as_slice(), "joints": joints, "friction": declared})
}

fn joint_value(joint: &Joint, frame: &Described) -> Value {
    let mut value = Map::new();
    value.insert("name".into(), json!(joint.name));
    value.insert(
        "kind".into(),
        json!(if joint.is_revolute() { "revolute" } else { "prismatic" }),
    );
    match joint.mdh {
        Some(mdh) => value.insert("mdh".into(), json!({"alpha": mdh.alpha, "d": mdh.d, "theta": mdh.theta, "r": mdh.r})),
        None => value.insert(
            "placement".into(),
            json!({"xyz": frame.pose.translation.as_slice(), "rpy": roll_pitch_yaw(&frame.pose.rotation), "axis": frame.axis.as_slice()}),
        ),
    };
    let l = &joint.limits;
    value.insert(
        "limits".into(),
        json!({"position": l.position, "velocity": l.velocity, "acceleration": l.acceleration, "jerk": l.jerk, "effort": l.effort}),
    );
    value.insert("link".into(), json!(joint.link_name));
    if let Some(prior) = &joint.prior {
        let turn = frame.turn;
        let center = turn * prior.inertia.center_of_mass;
        let i = turn * prior.inertia.inertia * turn.transpose();
        let prior = json!({
            "mass": prior.inertia.mass,
            "center_of_mass": center.as_slice(),
            "inertia": {"xx": i[(0, 0)], "xy": i[(0, 1)], "xz": i[(0, 2)], "yy": i[(1, 1)], "yz": i[(1, 2)], "zz": i[(2, 2)]},
            "viscous": prior.viscous,
            "coulomb": prior.coulomb,
        });
        value.insert("prior".into(), prior);
    }
    if !joint.geometry.is_empty() {
        let capsules = joint.geometry.iter().map(|c| capsule_value(c, &frame.turn));
        value.insert("geometry".into(), capsules.collect());
    }
    if let Some(bounds) = bounds_value(&joint.bounds) {
        value.insert("bounds".into(), bounds);
    }
    if let Some(axis) = joint.slender_axis {
        value.insert("slender_axis".into(), json!(axis_name(axis)));
    }
    Value::Object(value)
}

/// A capsule in the link frame of the description.
fn capsule_value(capsule: &Capsule, turn: &Matrix3<f64>) -> Value {
    let [from, to] = capsule.ends.map(|end| turn * end);
    json!({"from": from.as_slice(), "to": to.as_slice(), "radius": capsule.radius})
}

/// Gravity in the root frame of the file that [`urdf`] writes [m/s²]: URDF has none of its own, and every simulator lets it point along −z.
pub fn urdf_gravity(robot: &Robot) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -robot.gravity().norm())
}

/// The turn from the base frame to one in which gravity points along −z; `None` where it does already, or there is none.
pub(super) fn mounting(robot: &Robot) -> Option<Matrix3<f64>> {
    let (gravity, down) = (robot.gravity(), urdf_gravity(robot));
    // Rounding of a vector that was normalised is no other mounting.
    if (gravity - down).norm() <= 1e-12 * gravity.norm() {
        return None;
    }
    // Straight up every half turn about a level axis is as good: about x.
    let turn = Rotation3::rotation_between(&gravity, &down);
    Some(
        turn.unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI))
            .into_inner(),
    )
}

/// The robot as URDF; links without prior parameters have no inertial. Where gravity does not point along −z of the base, the base hangs on a fixed joint that turns it as
/// it is mounted, and a comment says so.
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
        xml.insert_str(at, &format!("{before}<!--{}-->{after}", super::model_file::comment(lines)));
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

/// A name that no link has.
pub(super) fn base_name(robot: &Robot) -> String {
    free_name(robot, "base_link")
}

/// `wanted`, lengthened until no link has that name.
fn free_name(robot: &Robot, wanted: &str) -> String {
    let mut name = wanted.to_string();
    while robot.joints().iter().any(|j| j.link_name == name) {
        name.push('_');
    }
    name
}

/// Shortest text that reads back as the same number.
pub(super) fn number(v: f64) -> String {
    match v.abs() {
        // Written out, these have up to three hundred digits.
        size if size != 0.0 && !(1e-6..1e16).contains(&size) => format!("{v:e}"),
        _ => format!("{v}"),
    }
}

pub(super) fn triple(v: &[f64]) -> String {
    v.iter().map(|&x| number(x)).collect::<Vec<_>>().join(" ")
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
