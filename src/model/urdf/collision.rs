//! `<collision>` of a link as capsules that contain it.
//!
//! Shapes of links never change the mechanics: one that cannot be read is left out with a note.

use crate::model::xml::XmlText;
use crate::model::{Ball, Capsule, INPUT_LIMITS, LinkMesh, ModelError, Notes};
use crate::spatial::Transform;
use nalgebra::Vector3;
use roxmltree::Node;

/// Meshes of the shapes for collision, of links that have those alone. Where a link has none, those that it is drawn with.
///
/// # Errors
/// No XML.
pub fn urdf_meshes(xml: &str) -> Result<Vec<LinkMesh>, ModelError> {
    let text = XmlText::new(xml, "/urdf", &mut Notes::default())?;
    let document = text.parse()?;
    let root = document.root_element();
    let mut meshes = Vec::new();
    for link in root.children().filter(|c| c.has_tag_name("link")) {
        let Some(name) = link.attribute("name") else { continue };
        if !read_collisions(link, "", &mut Vec::new()).is_empty() {
            continue;
        }
        let of = |tag: &'static str| {
            link.children()
                .filter(move |c| c.has_tag_name(tag))
                .filter_map(move |c| mesh(name, c))
        };
        let before = meshes.len();
        meshes.extend(of("collision"));
        if meshes.len() == before {
            meshes.extend(of("visual"));
        }
    }
    Ok(meshes)
}

fn mesh(link: &str, shape: Node) -> Option<LinkMesh> {
    let node = child(child(shape, "geometry")?, "mesh")?;
    Some(LinkMesh {
        link: link.to_string(),
        file: node.attribute("filename")?.to_string(),
        reference: Transform::identity(),
        scale: match node.attribute("scale") {
            Some(_) => three(node, "scale")?,
            None => Vector3::repeat(1.0),
        },
        pose: origin(shape)?,
    })
}

pub(super) fn read_collisions(link: Node, owner: &str, notes: &mut Vec<String>) -> Vec<Capsule> {
    let mut capsules = Vec::new();
    let mut unread = 0;
    for shape in link.children().filter(|c| c.has_tag_name("collision")) {
        let is_mesh = child(shape, "geometry").is_some_and(|g| child(g, "mesh").is_some());
        match capsule(shape) {
            Some(capsule) => capsules.push(capsule),
            None if is_mesh => {}
            None => unread += 1,
        }
        if capsules.len() >= INPUT_LIMITS.capsules_per_link {
            break;
        }
    }
    if unread > 0 {
        notes.push(format!(
            "{owner} has {unread} collision shapes that cannot be read: they are left out"
        ));
    }
    capsules
}

fn capsule(shape: Node) -> Option<Capsule> {
    let geometry = child(shape, "geometry")?;
    let pose = origin(shape)?;
    let along = |length: f64, radius: f64| {
        let half = Vector3::new(0.0, 0.0, 0.5 * length);
        Capsule::around(&[(-half, radius), (half, radius)])
    };
    let node = geometry.children().find(Node::is_element)?;
    let number = |name: &str| node.attribute(name)?.trim().parse::<f64>().ok();
    let capsule = match node.tag_name().name() {
        "sphere" => along(0.0, number("radius")?),
        "cylinder" | "capsule" => along(number("length")?.abs(), number("radius")?),
        "box" => {
            let half = 0.5 * three(node, "size")?;
            let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] });
            let corners: Vec<Ball> = (0..8).map(|k| (corner(k), 0.0)).collect();
            Capsule::around(&corners)
        }
        _ => None,
    }?;
    let moved = capsule.moved(&pose);
    moved
        .ends
        .iter()
        .flat_map(|e| e.iter())
        .all(|v| v.abs() <= INPUT_LIMITS.length)
        .then_some(moved)
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.has_tag_name(tag))
}

/// The pose of a shape; `None` where it cannot be read.
fn origin(shape: Node) -> Option<Transform> {
    let Some(node) = child(shape, "origin") else {
        return Some(Transform::identity());
    };
    let or_zero = |name: &str| {
        if node.has_attribute(name) {
            three(node, name)
        } else {
            Some(Vector3::zeros())
        }
    };
    Some(Transform::from_xyz_rpy(or_zero("xyz")?, or_zero("rpy")?))
}

fn three(node: Node, name: &str) -> Option<Vector3<f64>> {
    let words: Vec<f64> = node
        .attribute(name)?
        .split_whitespace()
        .take(4)
        .map_while(|w| w.parse().ok())
        .collect();
    match words[..] {
        [x, y, z] if [x, y, z].iter().all(|v: &f64| v.is_finite()) => Some(Vector3::new(x, y, z)),
        _ => None,
    }
}
