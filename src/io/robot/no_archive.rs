//! In the place of ZIP archives, where the package is built without `formats`.

use crate::io::json::Malformed;
use serde_json::Value;

/// A robot document from an archive.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RobotArchive {
    /// The document.
    pub document: Value,
    /// What to know about the meshes.
    pub notes: Vec<String>,
}

/// Whether these are the bytes of a ZIP archive.
pub fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// # Errors
/// Always: this build reads no archives.
pub fn robot_archive(_bytes: &[u8]) -> Result<RobotArchive, Malformed> {
    Err(Malformed {
        detail: "the file is a ZIP archive, which this build of the program does not read".into(),
        hint: Some("give the URDF file itself, or build with the feature `formats`".into()),
    })
}
