//! In the place of ZIP archives, where the package is built without `formats`.

use super::RobotArchive;
use crate::formats::json::Malformed;

/// # Errors
/// Always: this build reads no archives.
pub fn robot_archive(_bytes: &[u8]) -> Result<RobotArchive, Malformed> {
    Err(Malformed {
        detail: "the file is a ZIP archive, which this build of the program does not read".into(),
        hint: Some("give the URDF file itself, or build with the feature `formats`".into()),
    })
}
