//! `<mesh>` of the assets: which file, and how it is meant.

use super::bodies::Reading;
use crate::spatial::Transform;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// A mesh that geoms may name.
pub(super) struct MeshAsset {
    /// Relative to the robot's file, or absolute.
    pub file: String,
    /// Pose in the file of the frame that the mesh is meant in.
    pub reference: Transform,
    pub scale: Vector3<f64>,
}

/// Folders of meshes, as `compiler` names them.
#[derive(Default)]
pub(super) struct MeshFolder {
    /// From the folder of the robot's file; empty where it is that.
    folder: String,
    /// Whether folders in the names of files are left out.
    is_stripped: bool,
}

impl MeshFolder {
    pub fn read(&mut self, compiler: Node) {
        // The folder of all assets, or that of meshes alone.
        for name in ["assetdir", "meshdir"] {
            if let Some(folder) = compiler.attribute(name) {
                self.folder = folder.to_string();
            }
        }
        if let Some(strip) = compiler.attribute("strippath") {
            self.is_stripped = strip == "true";
        }
    }

    /// The path of a file from the folder of the robot's file, whatever system it was written on.
    fn path(&self, file: &str) -> String {
        let (file, folder) = (file.replace('\\', "/"), self.folder.replace('\\', "/"));
        let name = match self.is_stripped {
            true => file.rsplit('/').next().unwrap_or(&file),
            false => &file,
        };
        match folder.is_empty() || is_absolute(name) {
            true => name.to_string(),
            false => format!("{}/{name}", folder.trim_end_matches('/')),
        }
    }
}

/// On the systems that such files come from.
fn is_absolute(path: &str) -> bool {
    path.starts_with('/') || path.get(1..3) == Some(":/")
}

/// Meshes by their names. Those without a file, or with numbers that are none, are left out.
pub(super) fn mesh_assets<'a>(reading: &Reading<'a>, document: &'a Document<'a>) -> HashMap<String, MeshAsset> {
    let sections = document.root_element().children().filter(|c| c.has_tag_name("asset"));
    let meshes = sections.flat_map(|s| s.children().filter(|c| c.has_tag_name("mesh")));
    meshes.filter_map(|node| Some((name(node)?, asset(reading, node)?))).collect()
}

/// Without a name, that of the file without folder and ending.
fn name(node: Node) -> Option<String> {
    if let Some(name) = node.attribute("name").filter(|n| !n.is_empty()) {
        return Some(name.to_string());
    }
    let file = node.attribute("file")?.rsplit(['/', '\\']).next()?;
    Some(file.rsplit_once('.').map_or(file, |(stem, _)| stem).to_string())
}

fn asset<'a>(reading: &Reading<'a>, node: Node<'a, 'a>) -> Option<MeshAsset> {
    let attributes = reading.defaults.attributes(node, None);
    let several = |written: Option<&str>, name: &str, count: usize| reading.numbers(written, name, count, node, "<mesh>").ok();
    let three = |name: &str| Some(several(attributes.get(name), name, 3)?.map(|v| Vector3::from_column_slice(&v)));
    let rotation = match several(attributes.get("refquat"), "refquat", 4)? {
        Some(q) => UnitQuaternion::try_new(Quaternion::new(q[0], q[1], q[2], q[3]), 1e-9)?,
        None => UnitQuaternion::identity(),
    };
    Some(MeshAsset {
        file: reading.compiler.meshes.path(node.attribute("file")?),
        reference: Transform {
            rotation: rotation.to_rotation_matrix().into_inner(),
            translation: three("refpos")?.unwrap_or_default(),
        },
        scale: three("scale")?.unwrap_or(Vector3::repeat(1.0)),
    })
}
