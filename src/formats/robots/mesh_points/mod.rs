//! Points of meshes in the formats that robot descriptions have: STL, Wavefront OBJ, COLLADA.
//!
//! A capsule around a link needs its points alone: triangles, normals and colours are left out.

mod collada;
mod obj;
mod stl;

use nalgebra::Vector3;

/// Triangles of one mesh that are read; a link is known well enough by fewer.
const MOST_TRIANGLES: usize = 1 << 20;
/// Points of one mesh that are read: three to a triangle.
const MOST_POINTS: usize = 3 * MOST_TRIANGLES;

/// The points of a mesh, in metres where the file states a unit and in its own numbers otherwise; `None` where it is none of the
/// formats, damaged, or larger than any link. What a file is, its first bytes say.
pub(super) fn mesh_points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    let first = bytes
        .iter()
        .find(|b| !b.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(b))?;
    let read = match first {
        b'<' => collada::points(bytes),
        _ => stl::points(bytes).or_else(|| obj::points(bytes)),
    };
    read.filter(|points| !points.is_empty() && points.len() <= MOST_POINTS)
}
