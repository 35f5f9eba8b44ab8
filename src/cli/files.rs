//! Reading and writing files, with errors that name them.

use crate::app::{Code, Error, LogFile};
use crate::documents::shipped::Shipped;
use crate::documents::{NamedRobots, RobotDocument, robot_document_of};
use crate::formats::{Parsed, add_shapes, is_archive, parse, robot_archive, robot_file};
use serde::Serialize;
use serde_json::Value;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(|e| Error::new(Code::FileUnreadable, format!("cannot read {}: {e}", path.display())))
}

/// Writes to a file beside the target and renames it: whoever looks finds the old content or the new, never half of it.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    write_parts(path, std::iter::once(content))
}

/// [`write()`], of content that comes part by part: all of it need not fit into memory.
pub fn write_parts(path: &Path, mut parts: impl Iterator<Item = impl AsRef<[u8]>>) -> Result<(), Error> {
    let unwritable = |e: std::io::Error| Error::new(Code::FileUnwritable, format!("cannot write {}: {e}", path.display()));
    let mut write_to = |path: &Path| {
        let mut file = File::create(path)?;
        parts.try_for_each(|part| file.write_all(part.as_ref()))
    };
    // Pipes and devices (`/dev/stdout`) cannot be replaced.
    if path.exists() && !path.is_file() {
        return write_to(path).map_err(unwritable);
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = write_to(&part).and_then(|()| std::fs::rename(&part, path));
    written.inspect_err(|_| drop(std::fs::remove_file(&part))).map_err(unwritable)
}

/// Writes a result that is not yet all that goes into its file; not to pipes and devices, which get it once.
pub fn write_early(path: Option<&Path>, document: &impl Serialize) -> Result<(), Error> {
    match path.filter(|path| !path.exists() || path.is_file()) {
        Some(path) => write(path, pretty(document)),
        None => Ok(()),
    }
}

pub fn parse_json(path: &Path) -> Result<Parsed, Error> {
    parse(&read(path)?).map_err(|e| in_file(path, e.into()))
}

/// Which part of a robot file is the robot.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct ChainArguments {
    /// Last link of the arm, where the robot's file has more: a gripper, a second arm.
    #[arg(long, value_name = "LINK")]
    tip: Option<String>,
    /// Link that stands still, where it is not the root of the robot's file.
    #[arg(long, value_name = "LINK")]
    base: Option<String>,
}

impl ChainArguments {
    pub fn base(&self) -> Option<&str> {
        self.base.as_deref()
    }

    pub fn tip(&self) -> Option<&str> {
        self.tip.as_deref()
    }

    /// Puts the links into the document of a robot.
    pub fn put(&self, robot: &mut Value) -> Result<(), Error> {
        let stated = [("base", &self.base), ("tip", &self.tip)];
        let stated = stated.into_iter().filter_map(|(name, link)| Some((name, link.as_ref()?)));
        for (name, link) in stated {
            let of_file = ["urdf", "mjcf"].iter().any(|kind| robot.get(kind).is_some());
            match robot.as_object_mut().filter(|_| of_file) {
                Some(fields) => fields.insert(name.to_string(), link.clone().into()),
                None => {
                    let error = Error::new(
                        Code::InvalidDocument,
                        format!("--{name} goes with a robot from a URDF or MJCF file"),
                    );
                    return Err(error.with_hint("a robot with `joints` is the chain itself: leave joints out there"));
                }
            };
        }
        Ok(())
    }
}

/// A robot by the name of one that comes with the program, or from a file (JSON, URDF, MJCF, or a ZIP archive of a URDF file and
/// its meshes).
pub fn robot(name_or_file: &str, chain: &ChainArguments) -> Result<Parsed, Error> {
    let mut parsed = named_robot(name_or_file)?;
    chain.put(&mut parsed.value)?;
    Ok(parsed)
}

fn named_robot(name_or_file: &str) -> Result<Parsed, Error> {
    let path = Path::new(name_or_file);
    let names = Shipped.names();
    if !path.exists() && names.iter().any(|n| n == name_or_file) {
        return Ok(Parsed {
            value: Value::String(name_or_file.to_string()),
            problems: Vec::new(),
        });
    }
    let bytes = read(path).map_err(|e| e.with_hint(format!("give a file, or one of: {}", names.join(", "))))?;
    if is_archive(&bytes) {
        let read = robot_archive(&bytes).map_err(|e| in_file(path, e.into()))?;
        print_notes(&read.notes);
        return Ok(Parsed {
            value: read.document,
            problems: Vec::new(),
        });
    }
    let mut parsed = robot_file(&bytes).map_err(|e| in_file(path, e.into()))?;
    let notes = add_shapes(&mut parsed.value, |name| mesh_beside(path, name));
    print_notes(&notes);
    Ok(parsed)
}

/// Largest mesh that is read (bytes): a million triangles.
const LARGEST_MESH: u64 = 64 << 20;

/// A mesh by its name in a robot's file: relative to the file, or of a package that one of the folders around the file is or
/// holds.
fn mesh_beside(robot: &Path, name: &str) -> Option<Vec<u8>> {
    let folder = robot.parent()?;
    let in_package = name.strip_prefix("package://");
    let plain = in_package.unwrap_or_else(|| name.strip_prefix("file://").unwrap_or(name));
    let within = in_package.and_then(|rest| rest.split_once('/')).map(|(_, rest)| rest);
    let absolute = folder.canonicalize().ok()?;
    let around = absolute
        .ancestors()
        .flat_map(|a| [Some(plain), within].into_iter().flatten().map(move |p| a.join(p)));
    let found = around
        .take(if in_package.is_some() { usize::MAX } else { 1 })
        .find(|p| p.is_file())?;
    let small = std::fs::metadata(&found).is_ok_and(|m| m.len() <= LARGEST_MESH);
    small.then(|| std::fs::read(found).ok()).flatten()
}

/// The robot itself, and what to know about how it was read; effects that it names are those of `known`.
pub fn read_robot(name_or_file: &str, chain: &ChainArguments, known: &dyn NamedRobots) -> Result<RobotDocument, Error> {
    let parsed = robot(name_or_file, chain)?;
    match &parsed.value {
        Value::String(name) => Shipped
            .named(name)
            .ok_or_else(|| Error::new(Code::UnknownRobot, format!("there is no robot `{name}`"))),
        _ => robot_document_of(&parsed, known).map_err(|errors| Error::invalid(&format!("the robot in {name_or_file}"), errors)),
    }
}

/// Logs at these paths; a folder is a rosbag2 recording, every file of which is a log.
pub fn logs(paths: &[PathBuf]) -> Result<Vec<LogFile>, Error> {
    let of = |path: &PathBuf| match path.is_dir() {
        true => bag_files(path),
        false => Ok(vec![LogFile::at(path)]),
    };
    let all: Vec<Vec<LogFile>> = paths.iter().map(of).collect::<Result<_, _>>()?;
    Ok(all.into_iter().flatten().collect())
}

/// Files of a rosbag2 folder, in the order of its `metadata.yaml`.
fn bag_files(folder: &Path) -> Result<Vec<LogFile>, Error> {
    let listed = folder.join("metadata.yaml");
    let text = std::fs::read_to_string(&listed).map_err(|e| {
        let error = Error::new(Code::FileUnreadable, format!("cannot read {}: {e}", listed.display()));
        error.with_hint("a folder is read where it is a rosbag2 recording; name the log in it otherwise")
    })?;
    let files: Vec<LogFile> = listed_files(&text)
        .iter()
        .map(|name| LogFile::at(&folder.join(name)))
        .collect();
    match files.is_empty() {
        true => Err(Error::new(
            Code::InvalidLog,
            format!("{} names no files of the recording", listed.display()),
        )),
        false => Ok(files),
    }
}

/// The list `relative_file_paths`, as rosbag2 writes it: a name per line. Only names within the folder.
fn listed_files(metadata: &str) -> Vec<String> {
    let lines = metadata
        .lines()
        .map(str::trim)
        .skip_while(|line| *line != "relative_file_paths:")
        .skip(1);
    let names = lines
        .map_while(|line| line.strip_prefix("- "))
        .map(|name| name.trim().trim_matches(['"', '\'']).to_string());
    names
        .filter(|name| {
            Path::new(name)
                .components()
                .all(|c| matches!(c, std::path::Component::Normal(_)))
        })
        .collect()
}

/// What to know about how something was read, to standard error.
pub fn print_notes(notes: &[String]) {
    notes.iter().for_each(|note| eprintln!("note: {note}"));
}

/// The same error with the file in its detail.
pub fn in_file(path: &Path, error: Error) -> Error {
    Error {
        detail: format!("{}: {}", path.display(), error.detail),
        ..error
    }
}

/// JSON with line breaks and a final one.
pub fn pretty(document: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(document).expect("documents are plain data");
    text.push('\n');
    text
}

/// To standard output; a reader that has gone away (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::new(
            Code::FileUnwritable,
            format!("cannot write to standard output: {e}"),
        )),
        _ => Ok(()),
    }
}
