//! `dynident model`, and model files.

use super::{Ending, files};
use crate::app::{Code, Error, ModelFiles};
use crate::formats::{ModelFormat, robot_file};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// JSON model of an identification.
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Where the model goes, in the format of the file's ending: .urdf, .xml (MJCF), .sdf, .csv, .c, .py; may be given several
    /// times.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    out: Vec<PathBuf>,
    /// URDF file of your own: what is written as URDF is this file with the identified bodies put in, all else as it is.
    #[arg(long, value_name = "FILE")]
    patch_urdf: Option<PathBuf>,
    #[command(flatten)]
    chain: files::ChainArguments,
}

pub fn run(arguments: &Arguments) -> Result<Ending, Error> {
    let parsed = files::parse_json(&arguments.model)?;
    if !parsed.problems.is_empty() {
        return Err(files::in_file(&arguments.model, Error::invalid("the model", parsed.problems)));
    }
    let model = ModelFiles::of_json(parsed.value).map_err(|e| files::in_file(&arguments.model, e))?;
    let own = OwnUrdf {
        file: arguments.patch_urdf.as_deref(),
        chain: &arguments.chain,
    };
    let mut all = arguments.out.iter();
    all.try_for_each(|path| write(path, ModelFormat::of_file(path), &model, &own))?;
    Ok(Ending::Done)
}

/// The user's own file that bodies are put into, where there is one.
pub(super) struct OwnUrdf<'a> {
    pub file: Option<&'a Path>,
    pub chain: &'a files::ChainArguments,
}

/// Writes a model file; what is not in it goes to standard error.
pub(super) fn write(path: &Path, format: ModelFormat, model: &ModelFiles, own: &OwnUrdf) -> Result<(), Error> {
    let Some(file) = own.file.filter(|_| format == ModelFormat::Urdf) else {
        print_missing(path, &model.remarks(format));
        return files::write(path, model.text(format));
    };
    let parsed = robot_file(&files::read(file)?).map_err(|e| files::in_file(file, e.into()))?;
    let Some(xml) = parsed.value["urdf"].as_str() else {
        return Err(Error::new(
            Code::InvalidDocument,
            format!("{} is no URDF file", file.display()),
        ));
    };
    let patched = model.patched(xml, own.chain.base(), own.chain.tip());
    let patched = patched.map_err(|e| files::in_file(file, e))?;
    print_missing(path, &patched.notes);
    files::write(path, patched.urdf)
}

fn print_missing(path: &Path, remarks: &[String]) {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    remarks.iter().for_each(|remark| eprintln!("note: {name}: {remark}"));
}
