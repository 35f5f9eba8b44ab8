//! Boxes as meshes, for the tests of shapes.

pub type Triangle = [[f64; 3]; 3];

/// Twelve triangles of a box around its centre, with these half widths (m).
pub fn box_of(half: [f64; 3]) -> Vec<Triangle> {
    hexahedron(&std::array::from_fn(|k| {
        std::array::from_fn(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] })
    }))
}

/// Twelve triangles between eight corners, which are numbered as those of a box: bits for x, y and z.
pub fn hexahedron(corners: &[[f64; 3]; 8]) -> Vec<Triangle> {
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
        .map(|t| t.map(|k| corners[k]))
        .collect()
}

/// A binary STL file.
pub fn binary_stl(triangles: &[Triangle]) -> Vec<u8> {
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
