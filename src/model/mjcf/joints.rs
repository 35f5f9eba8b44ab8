//! `<joint>` of a body.

use super::bodies::{Held, Reading};
use super::defaults::Attributes;
use super::named;
use crate::model::link_tree::{Freedom, TreeJoint};
use crate::model::xml::single;
use crate::model::{Limits, ModelError};
use crate::spatial::Transform;
use nalgebra::Vector3;
use roxmltree::Node;

impl<'a> Reading<'a> {
    /// The joint that moves `child` in `parent`, where it stands at `origin`.
    pub(super) fn joint(
        &self,
        held: &Held<'a>,
        parent: usize,
        child: usize,
        origin: Transform,
        body: &str,
    ) -> Result<TreeJoint, ModelError> {
        let node = held.node;
        let attributes = self.defaults.attributes(node, held.class);
        let name = named(node).unwrap_or_else(|| format!("{body} joint {}", self.joints.len() + 1));
        let owner = format!("joint `{name}`");
        let freedom = match (node.tag_name().name(), attributes.get("type")) {
            ("freejoint", _) | (_, Some("free")) => Freedom::Several("free"),
            (_, Some("ball")) => Freedom::Several("a ball joint"),
            (_, Some("slide")) => Freedom::Prismatic,
            _ => Freedom::Revolute,
        };
        let vector = |name: &str| -> Result<Option<Vector3<f64>>, ModelError> {
            let read = self.numbers(attributes.get(name), name, 3, node, &owner)?;
            Ok(read.map(|v| Vector3::from_column_slice(&v)))
        };
        let number = |name: &str| -> Result<f64, ModelError> {
            // Some attributes have further numbers for what a rigid model does not have.
            let first = attributes.get(name).map(|t| t.split_whitespace().next().unwrap_or_default());
            Ok(self.numbers(first, name, 1, node, &owner)?.map_or(0.0, |v| v[0]))
        };
        let axis = held.pose.rotation * vector("axis")?.unwrap_or(Vector3::z());
        if axis.norm() < 1e-6 {
            let detail = format!("{owner}, line {}: its axis has no direction", self.text.line(node));
            return Err(single(self.text.field, detail, "give a unit vector"));
        }
        let unit = if freedom == Freedom::Revolute {
            self.compiler.angle
        } else {
            1.0
        };
        let mut notes = Vec::new();
        let armature = number("armature")?;
        if armature != 0.0 {
            notes.push(format!(
                "{owner} has an armature (rotor inertia) of {armature} kg m² or kg, which is not part of the declared model: expected torques lack it"
            ));
        }
        Ok(TreeJoint {
            line: self.text.line(node),
            freedom,
            parent,
            child,
            origin,
            axis: self.compiler.rounding.axis(axis.normalize()),
            anchor: held.pose.rotation * vector("pos")?.unwrap_or_default() + held.pose.translation,
            reference: number("ref")? * unit,
            limits: self.limits(&attributes, node, &owner, unit, freedom == Freedom::Revolute, &mut notes)?,
            viscous: number("damping")?,
            coulomb: number("frictionloss")?,
            mimics: self.follows.get(name.as_str()).map(|f| f.to_string()),
            name,
            notes,
        })
    }

    fn limits(
        &self,
        attributes: &Attributes<'a>,
        node: Node<'a, 'a>,
        owner: &str,
        unit: f64,
        is_revolute: bool,
        notes: &mut Vec<String>,
    ) -> Result<Limits, ModelError> {
        let pair = |name: &str| -> Result<Option<[f64; 2]>, ModelError> {
            let read = self.numbers(attributes.get(name), name, 2, node, owner)?;
            Ok(read.map(|v| [v[0], v[1]]))
        };
        let is_limited = attributes.get("limited") != Some("false");
        let written = Limits {
            position: pair("range")?.filter(|_| is_limited).map(|ends| ends.map(|v| v * unit)),
            effort: pair("actuatorfrcrange")?.map(|[low, high]| low.abs().max(high.abs())),
            ..Limits::unlimited()
        };
        let (read, dropped) = written.without_placeholders(is_revolute, true);
        notes.extend(dropped.iter().map(|d| format!("{owner}: {d}")));
        if read.effort.is_none() {
            notes.push(format!("{owner} has no velocity, effort limit in the file"));
        } else {
            notes.push(format!("{owner} has no velocity limit in the file"));
        }
        Ok(read)
    }
}
