//! `<link>` and `<joint>` of a URDF file as a tree of links.

use super::collision::read_collisions;
use super::inertial::read_inertial;
use super::numbers::Element;
use super::shortened;
use crate::model::link_tree::{Freedom, LinkTree, TreeJoint, TreeLink};
use crate::model::notes::Notes;
use crate::model::xml::{XmlText, single};
use crate::model::{Limits, ModelError, Rounding};
use crate::spatial::Transform;
use nalgebra::Vector3;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// # Errors
/// Links and joints that cannot be read, each with its line.
pub(super) fn read_tree(
    text: &XmlText,
    document: &Document,
    rounding: Rounding,
    notes: &mut Notes,
) -> Result<LinkTree, ModelError> {
    let root = document.root_element();
    let name = root.attribute("name").unwrap_or_else(|| {
        notes.push("the file does not name its robot: it is called `robot`");
        "robot"
    });
    let elements = |tag: &'static str| root.children().filter(move |c| c.has_tag_name(tag));
    let links: Vec<TreeLink> = elements("link").map(|l| read_link(text, l)).collect::<Result<_, _>>()?;
    let mut places = HashMap::with_capacity(links.len());
    for (at, link) in links.iter().enumerate() {
        places.entry(link.name.clone()).or_insert(at);
    }
    let joints = elements("joint")
        .map(|j| read_joint(text, j, &places, rounding))
        .collect::<Result<_, _>>()?;
    LinkTree::new(name.to_string(), text.field, rounding, links, joints)
}

fn name_of<'a>(text: &XmlText, node: Node<'a, 'a>) -> Result<&'a str, ModelError> {
    let named = node.attribute("name").filter(|n| !n.trim().is_empty());
    named.ok_or_else(|| {
        let detail = format!(
            "has a <{}> without a name in line {}",
            node.tag_name().name(),
            text.line(node)
        );
        single(text.field, detail, "give it a name")
    })
}

/// The first child of that name; of several the first counts, as in ROS's own parser (urdfdom).
fn first<'a>(node: Node<'a, 'a>, tag: &str, owner: &str, notes: &mut Vec<String>) -> Option<Node<'a, 'a>> {
    let mut found = node.children().filter(|c| c.has_tag_name(tag));
    let first = found.next();
    if found.next().is_some() {
        notes.push(format!("{owner} has more than one <{tag}>: the first is used"));
    }
    first
}

fn read_link(text: &XmlText, node: Node) -> Result<TreeLink, ModelError> {
    let name = name_of(text, node)?;
    let owner = format!("link `{}`", shortened(name));
    let mut notes = Vec::new();
    let inertia = match first(node, "inertial", &owner, &mut notes) {
        Some(inertial) => {
            for tag in ["origin", "mass", "inertia"] {
                first(inertial, tag, &format!("the inertial of {owner}"), &mut notes);
            }
            let element = Element {
                text,
                node: inertial,
                owner: &owner,
            };
            let (body, more) = read_inertial(&element)?;
            notes.extend(more);
            body
        }
        None => None,
    };
    Ok(TreeLink {
        capsules: read_collisions(node, &owner, &mut notes),
        name: name.to_string(),
        line: text.line(node),
        inertia,
        notes,
    })
}

fn read_joint(text: &XmlText, node: Node, links: &HashMap<String, usize>, rounding: Rounding) -> Result<TreeJoint, ModelError> {
    let name = name_of(text, node)?;
    let (owner, line) = (format!("joint `{}`", shortened(name)), text.line(node));
    let mut notes = Vec::new();
    let mut child = |tag: &'static str| {
        let node = first(node, tag, &owner, &mut notes)?;
        Some(Element {
            text,
            node,
            owner: &owner,
        })
    };
    let (parent, below) = (child("parent"), child("child"));
    let end = |element: Option<Element>, tag: &str| {
        let named = element.and_then(|e| e.node.attribute("link"));
        let known = named.and_then(|name| links.get(name));
        known.copied().ok_or_else(|| {
            let detail = match named {
                Some(link) => format!(
                    "{owner}, line {line}: names the link `{}`, which the file does not have",
                    shortened(link)
                ),
                None => format!("{owner}, line {line}: has no <{tag} link=\"…\">"),
            };
            single(text.field, detail, "check that the file is complete")
        })
    };
    let (parent, below) = (end(parent, "parent")?, end(below, "child")?);
    let (origin, axis, limit) = (child("origin"), child("axis"), child("limit"));
    let (dynamics, mimic) = (child("dynamics"), child("mimic"));
    let kind = node.attribute("type").unwrap_or_default();
    let freedom = freedom(kind).ok_or_else(|| {
        let detail = format!("{owner}, line {line}: is of the type `{}`", shortened(kind));
        let hint = "types of joints are revolute, continuous, prismatic, fixed, floating and planar";
        single(text.field, detail, hint)
    })?;
    let moves = matches!(freedom, Freedom::Revolute | Freedom::Prismatic);
    let axis = if moves {
        rounding.axis(read_axis(axis)?)
    } else {
        Vector3::z()
    };
    let limits = if moves {
        read_limits(kind, limit, &owner, &mut notes)?
    } else {
        Limits::unlimited()
    };
    let of_friction = |attribute: &str| -> Result<f64, ModelError> {
        Ok(dynamics
            .as_ref()
            .map(|d| d.finite(attribute))
            .transpose()?
            .flatten()
            .unwrap_or(0.0))
    };
    let (viscous, coulomb) = (of_friction("damping")?, of_friction("friction")?);
    Ok(TreeJoint {
        origin: read_origin(origin, rounding, &format!("{owner} (line {line})"), &mut notes)?,
        name: name.to_string(),
        line,
        freedom,
        parent,
        child: below,
        axis,
        anchor: Vector3::zeros(),
        reference: 0.0,
        limits,
        viscous,
        coulomb,
        mimics: mimic
            .filter(|_| moves)
            .map(|m| m.node.attribute("joint").unwrap_or_default().to_string()),
        notes,
    })
}

fn freedom(kind: &str) -> Option<Freedom> {
    Some(match kind {
        "fixed" => Freedom::Fixed,
        "revolute" | "continuous" => Freedom::Revolute,
        "prismatic" => Freedom::Prismatic,
        "floating" => Freedom::Several("floating"),
        "planar" => Freedom::Several("planar"),
        "spherical" | "ball" => Freedom::Several("spherical"),
        _ => return None,
    })
}

fn read_origin(
    origin: Option<Element>,
    rounding: Rounding,
    owner: &str,
    notes: &mut Vec<String>,
) -> Result<Transform, ModelError> {
    let Some(origin) = origin else {
        return Ok(Transform::identity());
    };
    let (xyz, of_lengths) = rounding.lengths("xyz", origin.vector("xyz")?.unwrap_or_default());
    let (rpy, of_angles) = rounding.angles("rpy", origin.vector("rpy")?.unwrap_or_default());
    notes.extend(of_lengths.iter().chain(&of_angles).map(|n| format!("{owner}: {n}")));
    Ok(Transform::from_xyz_rpy(xyz, rpy))
}

/// The axis as a unit vector, x where the file has none.
fn read_axis(element: Option<Element>) -> Result<Vector3<f64>, ModelError> {
    let Some(element) = element else { return Ok(Vector3::x()) };
    let axis = element.vector("xyz")?.unwrap_or(Vector3::x());
    let length = axis.norm();
    // Shorter than 1e-6 is no direction anybody wrote down.
    if length.is_finite() && length > 1e-6 {
        return Ok(axis / length);
    }
    let detail = format!(
        "{}, line {}: its axis [{}, {}, {}] has no direction",
        element.owner,
        element.text.line(element.node),
        axis.x,
        axis.y,
        axis.z
    );
    Err(single(element.text.field, detail, "give a unit vector"))
}

fn read_limits(kind: &str, limit: Option<Element>, owner: &str, notes: &mut Vec<String>) -> Result<Limits, ModelError> {
    let number =
        |name: &str| -> Result<Option<f64>, ModelError> { Ok(limit.as_ref().map(|l| l.number(name)).transpose()?.flatten()) };
    let (low, high) = (number("lower")?, number("upper")?);
    let stated = kind != "continuous" && (low.is_some() || high.is_some());
    let mut written = Limits {
        position: stated.then(|| [low.unwrap_or(0.0), high.unwrap_or(0.0)]),
        velocity: number("velocity")?,
        effort: number("effort")?,
        acceleration: None,
        jerk: None,
    };
    // Drake's extension, by its prefix or without.
    let extended = |name: &str| {
        let node = limit.as_ref()?.node;
        let found = node.attributes().find(|a| a.name() == name)?;
        found.value().trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0)
    };
    (written.acceleration, written.jerk) = (extended("acceleration"), extended("jerk"));
    let (read, dropped) = written.without_placeholders(kind != "prismatic", true);
    notes.extend(dropped.iter().map(|d| format!("{owner}: {d}")));
    let missing: Vec<&str> = [
        ("position", written.position.is_none() && kind != "continuous"),
        ("velocity", written.velocity.is_none()),
        ("effort", written.effort.is_none()),
    ]
    .iter()
    .filter(|(_, absent)| *absent)
    .map(|(name, _)| *name)
    .collect();
    if !missing.is_empty() {
        notes.push(format!("{owner} has no {} limit in the file", missing.join(", ")));
    }
    Ok(read)
}
