//! Robots as files: URDF and MJCF text, ZIP archives with meshes.

#[cfg_attr(not(feature = "formats"), path = "no_archive.rs")]
mod archive;
mod file;
mod mesh_points;
mod meshes;

pub use archive::robot_archive;
pub use file::robot_file;
pub use meshes::{add_shapes, meshes_of, shapes_of_meshes};

use serde_json::Value;

/// A robot document from an archive.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RobotArchive {
    /// A robot document with the file's text as `urdf` or `mjcf`, and `geometry` from its meshes.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub document: Value,
    /// What to know about the meshes.
    pub notes: Vec<String>,
}

/// Whether these are the bytes of a ZIP archive.
pub fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}
