//! Numbers in attributes, with the place of what is none.

use crate::model::ModelError;
use crate::model::xml::{XmlText, single};
use nalgebra::Vector3;
use roxmltree::Node;

/// An element and whom it belongs to, as errors name it.
pub(in crate::model) struct Element<'a> {
    pub text: &'a XmlText,
    pub node: Node<'a, 'a>,
    /// `joint `j1``.
    pub owner: &'a str,
}

impl Element<'_> {
    /// A number; `None` where the attribute is missing. Infinite values are let through: as limits they mean none.
    pub fn number(&self, attribute: &str) -> Result<Option<f64>, ModelError> {
        let Some(written) = self.node.attribute(attribute) else {
            return Ok(None);
        };
        match written.trim().parse::<f64>() {
            Ok(v) if !v.is_nan() => Ok(Some(v)),
            _ => Err(self.refused(attribute, written, "a number")),
        }
    }

    /// A number that is finite.
    pub fn finite(&self, attribute: &str) -> Result<Option<f64>, ModelError> {
        match self.number(attribute)? {
            Some(v) if !v.is_finite() => {
                let written = self.node.attribute(attribute).unwrap_or_default();
                Err(self.refused(attribute, written, "a finite number"))
            }
            found => Ok(found),
        }
    }

    /// Three finite numbers.
    pub fn vector(&self, attribute: &str) -> Result<Option<Vector3<f64>>, ModelError> {
        let Some(written) = self.node.attribute(attribute) else {
            return Ok(None);
        };
        let read: Vec<f64> = written
            .split_whitespace()
            .take(4)
            .map_while(|word| word.parse::<f64>().ok().filter(|v| v.is_finite()))
            .collect();
        match read[..] {
            [x, y, z] if written.split_whitespace().nth(3).is_none() => Ok(Some(Vector3::new(x, y, z))),
            _ => Err(self.refused(attribute, written, "three numbers with spaces between them")),
        }
    }

    fn refused(&self, attribute: &str, written: &str, expected: &str) -> ModelError {
        let detail = format!(
            "{}, line {}: {attribute} of <{}> is `{}`, expected {expected}",
            self.owner,
            self.text.line(self.node),
            self.node.tag_name().name(),
            super::shortened(written)
        );
        let hint = match written {
            w if w.contains("${") || w.contains("$(") => {
                "this is xacro: expand it first, with ROS: `xacro robot.urdf.xacro > robot.urdf`"
            }
            w if w.contains(',') => "URDF has decimal points, and spaces between numbers",
            _ => "correct it in the file",
        };
        single(self.text.field, detail, hint)
    }
}
