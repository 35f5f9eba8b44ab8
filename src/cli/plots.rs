//! Pictures as files.

use super::files;
use crate::app::{Code, Error};
use crate::documents::IdentifyDocument;
use crate::web::figures::{Figure, before_after_figure, error_figure, finding_figure, parameter_figures, torque_figure};
use std::path::Path;

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PictureKind {
    Svg,
    Png,
}

impl PictureKind {
    /// By the ending of a file's name: PNG if it says so, else SVG.
    pub fn from_path(path: &Path) -> Self {
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
pub fn pictures(document: &IdentifyDocument) -> Vec<(String, Figure)> {
    let mut all = vec![("errors".to_string(), error_figure(document))];
    all.extend(before_after_figure(document).map(|f| ("before_after".to_string(), f)));
    let findings = document.residual.iter().flat_map(|r| r.findings.iter().enumerate());
    all.extend(findings.filter_map(|(i, f)| Some((format!("finding_{}", i + 1), finding_figure(document, f)?))));
    let parameters = parameter_figures(document).into_iter().enumerate();
    all.extend(parameters.map(|(i, f)| (format!("parameters_{}", i + 1), f)));
    for prediction in &document.predictions {
        let joint = document.joints.iter().position(|j| *j == prediction.joint).unwrap_or(0);
        // Logs by number: their names may hold what file systems do not take.
        let log = document.log_report.iter().position(|l| l.file == prediction.log);
        let name = format!("torque_log{}_joint{}", log.map_or(0, |at| at + 1), joint + 1);
        let unit = if document.is_sliding(joint) { "N" } else { "N m" };
        all.push((name, torque_figure(prediction, unit)));
    }
    all
}
