//! A box as a mesh, for the tests of shapes.

/// Twelve triangles of a box around its centre, with these half widths (m).
pub fn box_of(half: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] }) };
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

/// A binary STL file.
pub fn binary_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b's'; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0u8; 12]);
        triangle
            .iter()
            .flatten()
            .for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    bytes
}
