//! STL, binary and text.

use super::{MOST_POINTS, MOST_TRIANGLES};
use nalgebra::Vector3;

/// The corners of all triangles of an STL file; `None` where it is none.
pub(super) fn points(bytes: &[u8]) -> Option<Vec<Vector3<f64>>> {
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
        if points.len() > MOST_POINTS {
            return None;
        }
    }
    Some(points)
}
