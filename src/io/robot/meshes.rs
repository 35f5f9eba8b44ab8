//! Shapes of links from the meshes that a URDF file names.

use crate::model::{Ball, Capsule, urdf_meshes};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};

/// Triangles of one mesh that are read; a link is known well enough by fewer.
const MOST_TRIANGLES: usize = 1 << 20;

/// `geometry` for a robot document with this URDF text: a capsule around each mesh of links that are described by meshes alone. `load` finds the bytes
/// of a mesh by the name that the file has for it. Second, what to know about it.
///
/// STL is read, binary and text.
pub fn shapes_of_meshes(urdf: &str, load: impl Fn(&str) -> Option<Vec<u8>>) -> (Map<String, Value>, Vec<String>) {
    let (mut shapes, mut notes) = (Map::new(), Vec::new());
    for mesh in urdf_meshes(urdf).unwrap_or_default() {
        let Some(bytes) = load(&mesh.file) else { continue };
        let placed = |p: Vector3<f64>| (mesh.pose.rotation * mesh.scale.component_mul(&p) + mesh.pose.translation, 0.0);
        let balls: Option<Vec<Ball>> = stl_points(&bytes).map(|points| points.into_iter().map(placed).collect());
        let Some(capsule) = balls.as_deref().and_then(Capsule::around) else {
            notes.push(format!(
                "the mesh `{}` of the link `{}` is no STL file of a link: it is left out",
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

/// The corners of all triangles of an STL file; `None` where it is none.
fn stl_points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    binary_points(bytes).or_else(|| text_points(bytes))
}

/// A header of 80 bytes, the number of triangles, and of each twelve floats and two bytes.
fn binary_points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?) as usize;
    let body = bytes.get(84..)?;
    if count == 0 || count > MOST_TRIANGLES || body.len() != count * 50 {
        return None;
    }
    let float = |b: &[u8]| f64::from(f32::from_le_bytes(b.try_into().expect("four bytes")));
    // The normal comes before the corners.
    let corners = body.chunks_exact(50).flat_map(|triangle| triangle[12..48].chunks_exact(12));
    let points = corners.map(|c| Vector3::new(float(&c[..4]), float(&c[4..8]), float(&c[8..])));
    Some(points.collect())
}

fn text_points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let text = std::str::from_utf8(bytes).ok()?;
    if !text.trim_start().starts_with("solid") {
        return None;
    }
    let mut words = text.split_whitespace();
    let mut points = Vec::new();
    while let Some(word) = words.next() {
        if word == "vertex" {
            let mut next = || words.next()?.parse::<f64>().ok();
            points.push(Vector3::new(next()?, next()?, next()?));
        }
        if points.len() > 3 * MOST_TRIANGLES {
            return None;
        }
    }
    (!points.is_empty()).then_some(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 0.1 × 0.2 × 0.6 m as twelve triangles, around its centre.
    fn triangles() -> Vec<[[f64; 3]; 3]> {
        let corner = |k: usize| {
            [0.05, 0.1, 0.3]
                .into_iter()
                .enumerate()
                .map(move |(i, h)| if k >> i & 1 == 1 { h } else { -h })
        };
        let corner = |k: usize| -> [f64; 3] { corner(k).collect::<Vec<_>>().try_into().unwrap() };
        let faces = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .map(|t| t.map(corner))
            .collect()
    }

    fn binary() -> Vec<u8> {
        let mut bytes = vec![b's'; 80];
        bytes.extend((triangles().len() as u32).to_le_bytes());
        for triangle in triangles() {
            bytes.extend([0u8; 12]);
            triangle
                .iter()
                .flatten()
                .for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
            bytes.extend([0u8; 2]);
        }
        bytes
    }

    fn text() -> Vec<u8> {
        let facet = |t: &[[f64; 3]; 3]| {
            let lines: Vec<String> = t.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}")).collect();
            format!("facet normal 0 0 0\nouter loop\n{}\nendloop\nendfacet\n", lines.join("\n"))
        };
        let facets: String = triangles().iter().map(facet).collect();
        format!("solid box\n{facets}endsolid box\n").into_bytes()
    }

    #[test]
    fn meshes_become_capsules_in_the_frame_of_their_link() {
        let urdf = r#"<robot name="r"><link name="a"/><link name="b">
            <collision><origin xyz="0 0 1" rpy="0 1.5707963267948966 0"/><geometry><mesh filename="package://p/box.stl" scale="2 2 2"/></geometry></collision>
            </link><link name="c"><visual><geometry><mesh filename="no.dae"/></geometry></visual></link></robot>"#;
        for bytes in [binary(), text()] {
            let load = |name: &str| {
                Some(if name.ends_with("stl") {
                    bytes.clone()
                } else {
                    b"<COLLADA/>".to_vec()
                })
            };
            let (shapes, notes) = shapes_of_meshes(urdf, load);
            assert_eq!(notes.len(), 1, "{notes:?}");
            let capsule = &shapes["b"][0];
            // Corners are sqrt(0.1² + 0.2²) from the long axis.
            let radius = capsule["radius"].as_f64().unwrap();
            assert!((radius - 0.05f64.sqrt()).abs() < 1e-6, "{capsule}");
            let x = capsule["from"][0].as_f64().unwrap().abs();
            assert!((x - 0.6).abs() < 1e-6, "{capsule}");
            assert!((capsule["from"][2].as_f64().unwrap() - 1.0).abs() < 1e-6, "{capsule}");
        }
        let (shapes, notes) = shapes_of_meshes(urdf, |_| Some(vec![0; 200]));
        assert!(shapes.is_empty() && notes.len() == 2, "what is no mesh is said to be none");
    }
    #[test]
    fn damaged_meshes_are_read_or_refused() {
        let urdf = r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="a.stl"/></geometry></collision></link></robot>"#;
        for whole in [binary(), text()] {
            let mut state = 1u64;
            for _ in 0..400 {
                let mut bytes = whole.clone();
                for _ in 0..3 {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    let at = (state >> 33) as usize % bytes.len();
                    match state >> 62 {
                        0 => bytes.truncate(at.max(1)),
                        1 => bytes[at] = (state >> 20) as u8,
                        _ => bytes[at] ^= 1 << (state >> 59 & 7),
                    }
                }
                let (shapes, notes) = shapes_of_meshes(urdf, |_| Some(bytes.clone()));
                assert_eq!(shapes.len() + notes.len(), 1);
                let numbers = shapes
                    .values()
                    .flat_map(|list| list[0]["from"].as_array().into_iter().flatten());
                assert!(numbers.into_iter().all(serde_json::Value::is_number));
            }
        }
    }
}
