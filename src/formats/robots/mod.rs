//! Robots as files: URDF and MJCF text, ZIP archives with meshes.

#[cfg_attr(not(feature = "formats"), path = "no_archive.rs")]
mod archive;
mod file;
mod mesh_points;
mod meshes;

pub use archive::robot_archive;
pub use file::robot_file;
pub use meshes::shapes_of_meshes;

use serde_json::Value;

/// A robot document from an archive.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RobotArchive {
    /// As [`robot_file`] reads it, with `geometry` from the meshes.
    pub document: Value,
    /// What to know about the meshes.
    pub notes: Vec<String>,
}

/// Whether these are the bytes of a ZIP archive.
pub fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}
