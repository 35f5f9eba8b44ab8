//! A robot's file with its meshes in one ZIP archive: a description package as people have it.

use super::RobotArchive;
use super::file::robot_file;
use super::meshes::add_shapes;
use crate::formats::json::Malformed;
use std::cell::RefCell;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Files of one archive; a description package with everything has some hundreds.
const MOST_ENTRIES: usize = 10_000;
/// Bytes of one file that are unpacked: a million triangles.
const LARGEST_FILE: u64 = 64 << 20;
/// Bytes of all files that are unpacked, one after the other.
const LARGEST_IN_ALL: u64 = 512 << 20;
/// Names that an error lists.
const MOST_NAMES: usize = 8;

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// The one URDF (or else MJCF) file of an archive; the meshes that it names become capsules of its links.
///
/// Meshes are found by `package://` names and by paths relative to the file, whether the archive begins at the package, above or
/// within it.
///
/// # Errors
/// No archive, no robot in it or several, more than is unpacked.
pub fn robot_archive(bytes: &[u8]) -> Result<RobotArchive, Malformed> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| {
        refuse(
            format!("the file is no ZIP archive that can be read: {e}"),
            "pack the folder again",
        )
    })?;
    if archive.len() > MOST_ENTRIES {
        let detail = format!("the archive has more than {MOST_ENTRIES} files");
        return Err(refuse(detail, "pack the robot's file and its meshes alone"));
    }
    let names: Vec<String> = archive
        .file_names()
        .filter_map(|n| Some(n.ok()?.to_string()))
        .filter(|n| !n.starts_with("__MACOSX/") && !n.ends_with('/'))
        .collect();
    let robot = robot_of(&names)?;
    let mut left = LARGEST_IN_ALL;
    let too_large = || {
        refuse(
            format!("`{robot}` unpacks to more than {} MiB", LARGEST_FILE >> 20),
            "give the file of one robot",
        )
    };
    let text = unpacked(&mut archive, robot, &mut left).ok_or_else(too_large)?;
    let mut document = robot_file(&text)?.value;
    let source = RefCell::new((archive, left));
    let missing = RefCell::new(Vec::new());
    let mut notes = add_shapes(&mut document, |mesh| {
        let (archive, left) = &mut *source.borrow_mut();
        let found = entry_of(&names, robot, mesh).and_then(|entry| unpacked(archive, entry, left));
        if found.is_none() {
            missing.borrow_mut().push(mesh.to_string());
        }
        found
    });
    notes.extend(left_out(missing.into_inner()));
    Ok(RobotArchive { document, notes })
}

fn refuse(detail: String, hint: &str) -> Malformed {
    Malformed {
        detail,
        hint: Some(hint.to_string()),
    }
}

/// The name of the robot's file: the only `.urdf`, or else the only `.xml` or `.mjcf`.
fn robot_of(names: &[String]) -> Result<&str, Malformed> {
    let ending = |wanted: &[&str]| -> Vec<&str> {
        let is = |n: &&String| wanted.iter().any(|e| n.to_ascii_lowercase().ends_with(e));
        names.iter().filter(is).map(String::as_str).collect()
    };
    // Every package of ROS has a `package.xml`, which is no robot.
    let of_mujoco = || {
        ending(&[".mjcf", ".xml"])
            .into_iter()
            .filter(|n| !is_at_end(n, "package.xml"))
            .collect()
    };
    let found: Vec<&str> = Some(ending(&[".urdf"])).filter(|f| !f.is_empty()).unwrap_or_else(of_mujoco);
    match found[..] {
        [one] => Ok(one),
        [] if !ending(&[".xacro"]).is_empty() => Err(refuse(
            "the archive has xacro files alone, which are still to be expanded".into(),
            "expand the robot first, with ROS: `xacro robot.urdf.xacro > robot.urdf`, and pack that file with the meshes",
        )),
        [] => Err(refuse(
            "the archive has no robot: no file ends in .urdf, .mjcf or .xml".into(),
            "pack the URDF or MJCF file with the folder of its meshes",
        )),
        _ => {
            let named = listed(found.iter().map(ToString::to_string).collect());
            Err(refuse(
                format!("the archive has {} robots: {named}", found.len()),
                "pack the file of one robot with its meshes",
            ))
        }
    }
}

/// Whether a path ends with another, at a border of folders.
fn is_at_end(path: &str, end: &str) -> bool {
    path.strip_suffix(end)
        .is_some_and(|before| before.is_empty() || before.ends_with('/'))
}

/// The entry that a robot's file means by the name of a mesh; of several the one in the fewest folders.
fn entry_of<'a>(names: &'a [String], robot: &str, mesh: &str) -> Option<&'a str> {
    let at_end = |end: &str| {
        let ends = names.iter().filter(|n| is_at_end(n, end));
        ends.min_by_key(|n| n.len()).map(String::as_str)
    };
    if let Some(path) = mesh.strip_prefix("package://") {
        // An archive of the package itself does not have its name.
        let within = path.split_once('/').map(|(_, rest)| rest);
        return at_end(path).or_else(|| at_end(within?));
    }
    let plain = mesh.strip_prefix("file://").unwrap_or(mesh);
    let folder = robot.rsplit_once('/').map_or("", |(folder, _)| folder);
    let beside = resolved(folder, plain);
    names
        .iter()
        .find(|n| Some(n.as_str()) == beside.as_deref())
        .map(String::as_str)
}

/// A path relative to a folder, both within the archive.
fn resolved(folder: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    Some(parts.join("/"))
}

/// The content of an entry; `None` where it cannot be read or is beyond the limits.
fn unpacked(archive: &mut Archive, name: &str, left: &mut u64) -> Option<Vec<u8>> {
    let most = LARGEST_FILE.min(*left);
    let mut content = Vec::new();
    let read = archive.by_name(name).ok()?.take(most + 1).read_to_end(&mut content);
    *left = left.saturating_sub(content.len() as u64);
    (read.is_ok() && content.len() as u64 <= most).then_some(content)
}

/// What is said of meshes that are not there.
fn left_out(mut missing: Vec<String>) -> Option<String> {
    missing.sort_unstable();
    missing.dedup();
    (!missing.is_empty()).then(|| {
        format!(
            "meshes that are not in the archive, or larger than {} MiB, are left out: {}",
            LARGEST_FILE >> 20,
            listed(missing)
        )
    })
}

/// Names in quotes, no more than anybody reads.
fn listed(names: Vec<String>) -> String {
    let further = names.len().saturating_sub(MOST_NAMES);
    let shown = names
        .iter()
        .take(MOST_NAMES)
        .map(|n| format!("`{}`", n.chars().take(200).collect::<String>()));
    let mut shown: Vec<String> = shown.collect();
    if further > 0 {
        shown.push(format!("and {further} more"));
    }
    shown.join(", ")
}
