//! What jobs do.

use crate::app::{CancelFlag, Error, Excited, Identified, LogFile, Step, excite, identify, validate};
use crate::excitation::Progress;
use crate::io::{ExcitationRequest, IdentifyRequest, ValidateDocument, ValidateRequest};
use tempfile::TempDir;

/// Uploaded logs; the files live as long as this.
pub struct Uploads {
    pub logs: Vec<LogFile>,
    pub validation: Vec<LogFile>,
    pub folder: TempDir,
}

/// A checked request with all it needs.
pub enum Work {
    Excite(Box<ExcitationRequest>),
    Identify(Box<IdentifyRequest>, Uploads),
    Validate(Box<ValidateRequest>, Uploads),
}

/// What came out.
pub enum Outcome {
    Excited(Box<Excited>),
    Identified(Box<Identified>),
    Validated(Box<ValidateDocument>),
}

/// What is told while it goes on.
#[derive(Debug, Clone)]
pub enum Told {
    Search(Progress),
    Step(Step),
}

impl Work {
    /// `excitation`, `identification` or `validation`.
    pub fn kind(&self) -> &'static str {
        match self {
            Work::Excite(_) => "excitation",
            Work::Identify(..) => "identification",
            Work::Validate(..) => "validation",
        }
    }

    /// Where the result of a job is.
    pub fn result_address(&self, id: &str) -> String {
        match self {
            Work::Excite(_) => format!("/excitation/{id}"),
            Work::Identify(..) => format!("/identify/{id}"),
            Work::Validate(..) => format!("/validate/{id}"),
        }
    }

    /// Does it on the calling thread.
    pub fn run(&self, cancel: &CancelFlag, tell: &(dyn Fn(Told) + Sync)) -> Result<Outcome, Error> {
        match self {
            Work::Excite(request) => {
                let excited = excite(request, cancel, &|p| tell(Told::Search(*p)));
                Ok(Outcome::Excited(Box::new(excited)))
            }
            Work::Identify(request, files) => {
                let found = identify(request, &files.logs, &files.validation, cancel, &|s| {
                    tell(Told::Step(s.clone()))
                })?;
                Ok(Outcome::Identified(Box::new(found)))
            }
            Work::Validate(request, files) => Ok(Outcome::Validated(Box::new(validate(request, &files.logs, cancel)?))),
        }
    }
}

impl Outcome {
    /// How a search ended; an identification that has a result has converged.
    pub fn status(&self) -> &'static str {
        match self {
            Outcome::Excited(excited) => excited.document.status,
            _ => "Converged",
        }
    }
}

impl From<ExcitationRequest> for Work {
    fn from(request: ExcitationRequest) -> Self {
        Work::Excite(Box::new(request))
    }
}
