//! COLLADA 1.4 and 1.5: positions of the geometries, where the nodes of the scene put them.
//!
//! Lengths are scaled by `<unit>`. `<up_axis>` is left out, as RViz, MoveIt and Gazebo do: a mesh of a robot description lies in
//! the frame of its link as it is written.

use super::MOST_POINTS;
use crate::model::{Notes, XmlText};
use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, NodeId};
use std::collections::HashMap;

/// Nodes of a scene that are visited, instances of instances included: a mesh of a link has a handful, and small files could ask
/// for millions.
const MOST_NODES: usize = 10_000;
/// Levels of nodes, of instances too: those that call each other have no end.
const DEEPEST: usize = 50;

/// All positions of the scene in metres; `None` where it is no COLLADA file, or one whose scene cannot be followed.
pub(super) fn points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let text = String::from_utf8_lossy(bytes);
    let xml = XmlText::new(&text, "/mesh", &mut Notes::default()).ok()?;
    let document = xml.parse().ok()?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return None;
    }
    let mut scene = Scene::new(&document);
    let scale = Matrix4::new_scaling(unit(root)?);
    match scene.shown(root) {
        Some(shown) => scene.children(shown, scale, 0)?,
        // Files of some converters have geometries and no scene.
        None => {
            let geometries: Vec<Node> = root.descendants().filter(|n| n.is_called("geometry")).collect();
            geometries.into_iter().try_for_each(|g| scene.geometry(g, &scale))?;
        }
    }
    Some(scene.points)
}

/// Names of elements, whatever the namespace of the version.
trait Named {
    fn is_called(&self, name: &str) -> bool;
}

impl Named for Node<'_, '_> {
    fn is_called(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.is_called(name))
}

/// Metres of one unit of the file.
fn unit(root: Node) -> Option<f64> {
    let stated = root.children().find(|c| c.is_called("asset"));
    let stated = stated.and_then(|asset| asset.children().find(|c| c.is_called("unit")));
    let metres = match stated.and_then(|u| u.attribute("meter")) {
        Some(text) => text.trim().parse().ok()?,
        None => 1.0,
    };
    (f64::is_finite(metres) && metres > 0.0).then_some(metres)
}

/// The numbers of an element; `None` where one of them is none.
fn numbers(node: Node, most: usize) -> Option<Vec<f64>> {
    let text = node.text().unwrap_or_default();
    let words = text.split_ascii_whitespace().take(most + 1);
    let values: Vec<f64> = words.map(|w| w.parse().ok()).collect::<Option<_>>()?;
    (values.len() <= most).then_some(values)
}

struct Scene<'a> {
    by_id: HashMap<&'a str, Node<'a, 'a>>,
    /// Positions of geometries that have been read: a scene may show one often.
    known: HashMap<NodeId, Vec<Vector3<f64>>>,
    visited: usize,
    points: Vec<Vector3<f64>>,
}

impl<'a> Scene<'a> {
    fn new(document: &'a Document<'a>) -> Self {
        let named = document.descendants().filter_map(|n| Some((n.attribute("id")?, n)));
        Self {
            by_id: named.collect(),
            known: HashMap::new(),
            visited: 0,
            points: Vec::new(),
        }
    }

    /// The element that an attribute of another calls by `#id`.
    fn called(&self, node: Node<'a, 'a>, attribute: &str) -> Option<Node<'a, 'a>> {
        self.by_id.get(node.attribute(attribute)?.strip_prefix('#')?).copied()
    }

    /// The scene that is shown, or the first one that there is.
    fn shown(&self, root: Node<'a, 'a>) -> Option<Node<'a, 'a>> {
        let instance = child(root, "scene").and_then(|s| child(s, "instance_visual_scene"));
        let called = instance.and_then(|i| self.called(i, "url"));
        called.or_else(|| root.descendants().find(|n| n.is_called("visual_scene")))
    }

    /// What a node or a scene holds: its transformations, in their order, and what they move.
    fn children(&mut self, node: Node<'a, 'a>, mut pose: Matrix4<f64>, depth: usize) -> Option<()> {
        self.visited += 1;
        if self.visited > MOST_NODES || depth > DEEPEST {
            return None;
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "instance_geometry" => {
                    let geometry = self.called(part, "url")?;
                    self.geometry(geometry, &pose)?;
                }
                "node" => self.children(part, pose, depth + 1)?,
                "instance_node" => {
                    let other = self.called(part, "url")?;
                    self.children(other, pose, depth + 1)?;
                }
                // A camera's transformation, and one that links do not have.
                "lookat" | "skew" => return None,
                _ => pose *= moved(part)?,
            }
        }
        Some(())
    }

    fn geometry(&mut self, geometry: Node<'a, 'a>, pose: &Matrix4<f64>) -> Option<()> {
        if !self.known.contains_key(&geometry.id()) {
            let read = self.positions(geometry)?;
            self.known.insert(geometry.id(), read);
        }
        let own = &self.known[&geometry.id()];
        if self.points.len() + own.len() > MOST_POINTS {
            return None;
        }
        self.points
            .extend(own.iter().map(|p| pose.transform_point(&(*p).into()).coords));
        Some(())
    }

    /// Positions of a mesh; none of a geometry of curves.
    fn positions(&self, geometry: Node<'a, 'a>) -> Option<Vec<Vector3<f64>>> {
        let Some(vertices) = child(geometry, "mesh").and_then(|m| child(m, "vertices")) else {
            return Some(Vec::new());
        };
        let is_position = |n: &Node| n.is_called("input") && n.attribute("semantic") == Some("POSITION");
        let source = self.called(vertices.children().find(is_position)?, "source")?;
        let accessor = child(source, "technique_common").and_then(|t| child(t, "accessor"));
        let whole = |name: &str, otherwise: usize| match accessor.and_then(|a| a.attribute(name)) {
            Some(text) => text.trim().parse().ok(),
            None => Some(otherwise),
        };
        let (stride, offset): (usize, usize) = (whole("stride", 3)?, whole("offset", 0)?);
        if !(3..=64).contains(&stride) {
            return None;
        }
        let values = numbers(child(source, "float_array")?, 3 * MOST_POINTS)?;
        let rows = values.get(offset..)?.chunks(stride).filter(|row| row.len() >= 3);
        Some(rows.map(|row| Vector3::new(row[0], row[1], row[2])).collect())
    }
}

/// The transformation that an element of a node states; the identity of any other.
fn moved(part: Node) -> Option<Matrix4<f64>> {
    let exactly = |count: usize| numbers(part, count).filter(|v| v.len() == count);
    Some(match part.tag_name().name() {
        "matrix" => Matrix4::from_row_slice(&exactly(16)?),
        "translate" => Matrix4::new_translation(&Vector3::from_row_slice(&exactly(3)?)),
        "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from_row_slice(&exactly(3)?)),
        "rotate" => {
            let v = exactly(4)?;
            let axis = Unit::try_new(Vector3::new(v[0], v[1], v[2]), 0.0)?;
            Rotation3::from_axis_angle(&axis, v[3].to_radians()).to_homogeneous()
        }
        _ => Matrix4::identity(),
    })
}
