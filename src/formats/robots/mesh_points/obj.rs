//! Wavefront OBJ, by `tobj`.

use nalgebra::Vector3;
use tobj::{LoadError, LoadOptions};

/// Largest OBJ file (bytes): half a million triangles. A face of a few characters takes ten times as many bytes in memory.
const LARGEST: usize = 16 << 20;

/// The points that the faces of an OBJ file use; `None` where it is none. Materials are left out.
pub(super) fn points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
    if bytes.len() > LARGEST {
        return None;
    }
    let options = LoadOptions {
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let (parts, _) = tobj::load_obj_buf(&mut &*bytes, &options, |_| Err(LoadError::OpenFileFailed)).ok()?;
    let positions = parts.iter().flat_map(|part| part.mesh.positions.chunks_exact(3));
    let points = positions.map(|p| Vector3::new(p[0], p[1], p[2]).map(f64::from));
    Some(points.collect())
}
