//! Reading and writing files, with errors that name them.

use crate::app::{Code, Error};
use crate::io::shipped::Shipped;
use crate::io::{NamedRobots, Parsed, parse, robot_file};
use serde::Serialize;
use serde_json::Value;
use std::io::Write;
use std::path::Path;

pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(|e| Error::new(Code::FileUnreadable, format!("cannot read {}: {e}", path.display())))
}

/// Writes to a file beside the target and renames it: whoever looks finds the old content or the new, never half of it.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let unwritable = |e: std::io::Error| Error::new(Code::FileUnwritable, format!("cannot write {}: {e}", path.display()));
    // Pipes and devices (`/dev/stdout`) cannot be replaced.
    if path.exists() && !path.is_file() {
        return std::fs::write(path, content.as_ref()).map_err(unwritable);
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = std::fs::write(&part, content.as_ref()).and_then(|()| std::fs::rename(&part, path));
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

/// A robot by the name of one that comes with the program, or from a file (JSON or URDF).
pub fn robot(name_or_file: &str) -> Result<Parsed, Error> {
    let path = Path::new(name_or_file);
    let names = Shipped.names();
    if !path.exists() && names.iter().any(|n| n == name_or_file) {
        return Ok(Parsed {
            value: Value::String(name_or_file.to_string()),
            problems: Vec::new(),
        });
    }
    let bytes = read(path).map_err(|e| e.with_hint(format!("give a file, or one of: {}", names.join(", "))))?;
    robot_file(&bytes).map_err(|e| in_file(path, e.into()))
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
