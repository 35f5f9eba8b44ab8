//! Shapes of links from the meshes that a URDF file names.

use super::mesh_points::mesh_points;
use crate::model::{Ball, Capsule, urdf_meshes};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};

/// `geometry` for a robot document with this URDF text: a capsule around each mesh of links that are described by meshes alone. `load` finds the bytes
/// of a mesh by the name that the file has for it. Second, what to know about it.
///
/// STL (binary and text), Wavefront OBJ and COLLADA are read.
pub fn shapes_of_meshes(urdf: &str, load: impl Fn(&str) -> Option<Vec<u8>>) -> (Map<String, Value>, Vec<String>) {
    let (mut shapes, mut notes) = (Map::new(), Vec::new());
    for mesh in urdf_meshes(urdf).unwrap_or_default() {
        let Some(bytes) = load(&mesh.file) else { continue };
        let placed = |p: Vector3<f64>| (mesh.pose.rotation * mesh.scale.component_mul(&p) + mesh.pose.translation, 0.0);
        let balls: Option<Vec<Ball>> = mesh_points(&bytes).map(|points| points.into_iter().map(placed).collect());
        let Some(capsule) = balls.as_deref().and_then(Capsule::around) else {
            notes.push(format!(
                "the mesh `{}` of the link `{}` is no STL, OBJ or COLLADA file of the size of a link: it is left out",
                mesh.file, mesh.link
            ));
            continue;
        };
        let [from, to] = capsule.ends;
        let value = json!({"from": from.as_slice(), "to": to.as_slice(), "radius": capsule.radius, "source": format!("around {}", mesh.file)});
        let list = shapes.entry(mesh.link).or_insert_with(|| json!([]));
        if let Some(list) = list.as_array_mut() {
            list.push(value);
        }
    }
    (shapes, notes)
}
