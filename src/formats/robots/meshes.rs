//! Shapes of links from the meshes that a robot's file names.

use super::mesh_points::mesh_points;
use crate::model::{Ball, Capsule, INPUT_LIMITS, LinkMesh, mjcf_meshes, urdf_meshes};
use serde_json::{Map, Value, json};

/// Meshes of the links of a robot document that are described by meshes alone; none of a document without `urdf` and `mjcf`.
pub fn meshes_of(robot: &Value) -> Vec<LinkMesh> {
    let text = |kind: &str| robot.get(kind).and_then(Value::as_str);
    let read = match (text("urdf"), text("mjcf")) {
        (Some(urdf), _) => urdf_meshes(urdf),
        (None, Some(mjcf)) => mjcf_meshes(mjcf),
        (None, None) => return Vec::new(),
    };
    // What is wrong with the file is said when the robot is read.
    read.unwrap_or_default()
}

/// Puts `geometry` with a capsule around each of the meshes ([`meshes_of`]) into a robot document; answers what to know about
/// them.
///
/// `load` finds the bytes of a mesh by the name that the file has for it.
pub fn add_shapes(robot: &mut Value, load: impl Fn(&str) -> Option<Vec<u8>>) -> Vec<String> {
    let (shapes, notes) = shapes_of_meshes(&meshes_of(robot), load);
    if let Some(fields) = robot.as_object_mut().filter(|_| !shapes.is_empty()) {
        fields.insert("geometry".into(), shapes.into());
    }
    notes
}

/// Capsules around meshes by the names of links, as `geometry` of a robot document has them; second, what to know about it.
///
/// STL (binary and text), Wavefront OBJ and COLLADA are read. A link with more meshes than a document takes gets one capsule
/// around them all.
pub fn shapes_of_meshes(meshes: &[LinkMesh], load: impl Fn(&str) -> Option<Vec<u8>>) -> (Map<String, Value>, Vec<String>) {
    let (mut links, mut notes) = (Vec::<(&str, Vec<(Capsule, &str)>)>::new(), Vec::new());
    for mesh in meshes {
        let Some(bytes) = load(&mesh.file) else { continue };
        let Some(capsule) = around(mesh, &bytes) else {
            notes.push(format!(
                "the mesh `{}` of the link `{}` is no STL, OBJ or COLLADA file of the size of a link: it is left out",
                mesh.file, mesh.link
            ));
            continue;
        };
        // Meshes of a link follow each other.
        match links.last_mut().filter(|(link, _)| *link == mesh.link) {
            Some((_, capsules)) => capsules.push((capsule, &mesh.file)),
            None => links.push((&mesh.link, vec![(capsule, &mesh.file)])),
        }
    }
    let shapes = links.iter().map(|(link, capsules)| (link.to_string(), values(capsules)));
    (shapes.collect(), notes)
}

fn around(mesh: &LinkMesh, bytes: &[u8]) -> Option<Capsule> {
    let balls: Vec<Ball> = mesh_points(bytes)?.iter().map(|p| (mesh.placed(p), 0.0)).collect();
    Capsule::around(&balls)
}

fn values(capsules: &[(Capsule, &str)]) -> Value {
    let one = |c: &Capsule, of: String| json!({"from": c.ends[0].as_slice(), "to": c.ends[1].as_slice(), "radius": c.radius, "source": format!("around {of}")});
    if capsules.len() > INPUT_LIMITS.capsules_per_link {
        let balls: Vec<Ball> = capsules.iter().flat_map(|(c, _)| c.balls()).collect();
        if let Some(whole) = Capsule::around(&balls) {
            return json!([one(&whole, format!("{} meshes", capsules.len()))]);
        }
    }
    capsules.iter().map(|(c, file)| one(c, file.to_string())).collect()
}
