//! Numbers and poses as attributes state them.

use super::bodies::Reading;
use super::orientation::{ORIENTATIONS, rotation};
use crate::model::ModelError;
use crate::model::xml::single;
use crate::spatial::Transform;
use nalgebra::{Matrix3, Vector3};
use roxmltree::Node;

impl<'a> Reading<'a> {
    /// The pose that an element states itself.
    pub(super) fn pose(&self, node: Node<'a, 'a>) -> Result<Transform, ModelError> {
        self.pose_of(node, |name| node.attribute(name))
    }

    /// The pose that the attributes of an element state, its own or by default.
    pub(super) fn pose_of<'b>(
        &self,
        node: Node<'a, 'a>,
        attribute: impl Fn(&str) -> Option<&'b str>,
    ) -> Result<Transform, ModelError> {
        let owner = format!("<{}>", node.tag_name().name());
        let position = self.numbers(attribute("pos"), "pos", 3, node, &owner)?;
        let translation = position.map_or(Vector3::zeros(), |v| Vector3::from_column_slice(&v));
        let mut turn = Matrix3::identity();
        for (name, count) in ORIENTATIONS {
            if let Some(v) = self.numbers(attribute(name), name, count, node, &owner)? {
                turn = rotation(name, &v, self.compiler).ok_or_else(|| {
                    let detail = format!("{owner}, line {}: its {name} has no direction", self.text.line(node));
                    single(self.text.field, detail, "correct it in the file")
                })?;
            }
        }
        Ok(Transform {
            rotation: turn,
            translation: self.compiler.rounding.lengths("pos", translation).0,
        })
    }

    /// So many finite numbers; `None` where the attribute is missing.
    pub(super) fn numbers(
        &self,
        written: Option<&str>,
        name: &str,
        count: usize,
        node: Node,
        owner: &str,
    ) -> Result<Option<Vec<f64>>, ModelError> {
        let Some(written) = written else { return Ok(None) };
        let words = written.split_whitespace().take(count + 1);
        let read: Option<Vec<f64>> = words.map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect();
        match read.filter(|v| v.len() == count) {
            Some(v) => Ok(Some(v)),
            None => {
                let shown: String = written.chars().take(80).collect();
                let detail = format!(
                    "{owner}, line {}: {name} is `{shown}`, expected {count} finite numbers",
                    self.text.line(node)
                );
                Err(single(self.text.field, detail, "correct it in the file"))
            }
        }
    }
}
