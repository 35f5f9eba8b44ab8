//! Pictures as files.

use super::files;
use crate::app::{Code, Error};
use crate::web::figures::{Figure, before_after_figure, error_figure, finding_figure, parameter_figures, torque_figure};
use serde_json::Value;
use std::path::Path;

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PictureKind {
    Svg,
    Png,
}

impl PictureKind {
    /// By the ending of a file's name: PNG if it says so, else SVG.
    pub fn of(path: &Path) -> Self {
        match path.extension().and_then(|e| e.to_str()) {
            Some(ending) if ending.eq_ignore_ascii_case("png") => Self::Png,
            _ => Self::Svg,
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
        }
    }
}

/// Writes `figure` to `path`, which gets the ending of its kind if it has none.
pub fn write_picture(path: &Path, kind: PictureKind, figure: &Figure) -> Result<(), Error> {
    let internal = |e: crate::web::figures::FigureError| Error::new(Code::Internal, e.to_string());
    let path = if path.extension().is_some() {
        path.to_path_buf()
    } else {
        path.with_extension(kind.ending())
    };
    match kind {
        PictureKind::Svg => files::write(&path, figure.svg().map_err(internal)?),
        PictureKind::Png => files::write(&path, figure.png().map_err(internal)?),
    }
}

/// All pictures of an identification, with the names of their files without ending.
pub fn pictures(document: &Value) -> Vec<(String, Figure)> {
    let mut all = vec![("errors".to_string(), error_figure(document))];
    all.extend(before_after_figure(document).map(|f| ("before_after".to_string(), f)));
    let findings = document["residual"]["findings"].as_array().into_iter().flatten();
    all.extend(
        findings
            .enumerate()
            .filter_map(|(i, f)| Some((format!("finding_{}", i + 1), finding_figure(document, f)?))),
    );
    all.extend(
        parameter_figures(document)
            .into_iter()
            .enumerate()
            .map(|(i, f)| (format!("parameters_{}", i + 1), f)),
    );
    let predictions = document["predictions"].as_array().into_iter().flatten();
    all.extend(predictions.map(|p| (torque_name(document, p), torque_figure(p, effort_unit(document, p)))));
    all
}

/// Logs by number: their names may hold what file systems do not take.
fn torque_name(document: &Value, prediction: &Value) -> String {
    let logs = document["log_report"].as_array().map(Vec::as_slice).unwrap_or_default();
    let log = logs
        .iter()
        .position(|l| l["file"] == prediction["log"])
        .map_or(0, |at| at + 1);
    format!("torque_log{log}_joint{}", joint(document, prediction) + 1)
}

fn joint(document: &Value, prediction: &Value) -> usize {
    let joints = document["joints"].as_array().map(Vec::as_slice).unwrap_or_default();
    joints.iter().position(|j| *j == prediction["joint"]).unwrap_or(0)
}

fn effort_unit(document: &Value, prediction: &Value) -> &'static str {
    let sliding = document["provenance"]["robot"]["joints"][joint(document, prediction)]["kind"] == "prismatic";
    if sliding { "N" } else { "N m" }
}
