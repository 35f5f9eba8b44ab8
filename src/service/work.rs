//! What jobs do: from the files of a job to its result.

use super::known::Known;
use crate::app::{CancelFlag, Code, Error, Exchange, Excited, LogFile, Step, excite_beside, identify, validate};
use crate::documents::{
    ExcitationRequest, IdentifyRequest, ValidateRequest, read_excitation_request, read_identify_request, read_validate_request,
};
use crate::excitation::Progress;
use crate::formats::{Parsed, parse};
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use serde_json::{Value, json};

/// The three things that jobs do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum JobKind {
    /// Search for an excitation trajectory.
    Excitation,
    /// Identification from logs, with the residual diagnosis.
    Identification,
    /// Errors of a given model on other logs.
    Validation,
}

impl JobKind {
    pub const ALL: [JobKind; 3] = [JobKind::Excitation, JobKind::Identification, JobKind::Validation];

    pub fn name(self) -> &'static str {
        match self {
            JobKind::Excitation => "excitation",
            JobKind::Identification => "identification",
            JobKind::Validation => "validation",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }

    /// Where the result of a job is.
    pub fn result_address(self, id: &str) -> String {
        match self {
            JobKind::Excitation => format!("/excitation/{id}"),
            JobKind::Identification => format!("/identify/{id}"),
            JobKind::Validation => format!("/validate/{id}"),
        }
    }

    /// What is said of an id that is none.
    pub fn unknown(self) -> Code {
        match self {
            JobKind::Excitation => Code::UnknownExcitation,
            JobKind::Identification | JobKind::Validation => Code::UnknownIdentification,
        }
    }
}

/// Each class has places of its own, so that its jobs are not stuck behind those of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// Identifications and validations.
    Short,
    /// Searches of a few seconds. They take all of their time, and many of them would hold up what takes a fraction of it.
    Brief,
    /// Searches that may take longer.
    Long,
}

impl Class {
    pub fn name(self) -> &'static str {
        match self {
            Class::Short => "short",
            Class::Brief => "brief",
            Class::Long => "long",
        }
    }
}

/// A file that came with a request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredLog {
    /// As the client calls it.
    pub name: String,
    pub hash: String,
}

/// All that a job needs: kept as a file, so that any worker can do it, at any time, whatever becomes of what it names.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Input {
    /// The request, as it was made.
    pub request: Value,
    /// What it calls by name, as it was then.
    pub known: Known,
    pub logs: Vec<StoredLog>,
    pub validation: Vec<StoredLog>,
}

/// A request that has been read.
#[derive(Debug, Clone)]
pub enum Request {
    Excite(Box<ExcitationRequest>),
    Identify(Box<IdentifyRequest>),
    Validate(Box<ValidateRequest>),
}

impl Request {
    /// Reads a request of a kind.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(kind: JobKind, parsed: &Parsed, known: &Known) -> Result<Self, Error> {
        let invalid = |errors| Error::invalid(&format!("the {} request", kind.name()), errors);
        match kind {
            JobKind::Excitation => read_excitation_request(parsed, known)
                .map(|r| Self::Excite(Box::new(r)))
                .map_err(invalid),
            JobKind::Identification => read_identify_request(parsed, known, known)
                .map(|r| Self::Identify(Box::new(r)))
                .map_err(invalid),
            JobKind::Validation => read_validate_request(parsed, known, known)
                .map(|r| Self::Validate(Box::new(r)))
                .map_err(invalid),
        }
    }

    /// Reads the request of a stored job: it was found good before.
    pub fn from_input(kind: JobKind, input: &Input) -> Result<Self, Error> {
        let parsed = parse(input.request.to_string().as_bytes()).map_err(Error::from)?;
        Self::read(kind, &parsed, &input.known)
    }

    /// How long a search may take (s); 0 for what has no limit of its own.
    pub fn search_s(&self) -> f64 {
        match self {
            Self::Excite(request) => request.search.time_limit_s,
            Self::Identify(_) | Self::Validate(_) => 0.0,
        }
    }

    /// Does it on the calling thread; a search beside others with `exchange`.
    pub fn run(
        &self,
        logs: &[LogFile],
        validation: &[LogFile],
        exchange: Option<&dyn Exchange>,
        cancel: &CancelFlag,
        tell: &(dyn Fn(Notice) + Sync),
    ) -> Result<JobOutcome, Error> {
        match self {
            Self::Excite(request) => {
                let excited = excite_beside(request, exchange, cancel, &|p| tell(Notice::Search(p.clone())));
                Ok(JobOutcome::of_search(&excited))
            }
            Self::Identify(request) => {
                let mut found = identify(request, logs, validation, cancel, &|s| tell(Notice::Step(s.clone())))?;
                let model = found.model.as_ref();
                let model = model.map(|m| json!({"json": m.json}).to_string().into_bytes());
                let result = JobOutcome::of_logs(&found.document, model);
                if request.prediction_points == 0 {
                    return Ok(result);
                }
                tell(Notice::Result(result.clone()));
                let predicted = found.predictions(request);
                found.document.predictions_error = predicted.as_ref().err().map(|e| e.detail.clone());
                found.document.predictions = predicted.unwrap_or_default();
                Ok(JobOutcome::of_logs(&found.document, result.model.map(ByteBuf::into_vec)))
            }
            Self::Validate(request) => {
                let mut found = validate(request, logs, cancel)?;
                let result = JobOutcome::of_logs(&found.document, None);
                if request.prediction_points == 0 {
                    return Ok(result);
                }
                tell(Notice::Result(result));
                let predicted = found.predictions(request);
                found.document.predictions_error = predicted.as_ref().err().map(|e| e.detail.clone());
                found.document.predictions = predicted.unwrap_or_default();
                Ok(JobOutcome::of_logs(&found.document, None))
            }
        }
    }
}

/// How large a request is, for the limits of a server.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measure {
    pub joints: usize,
    /// Time and order of a search.
    pub search: Option<(f64, usize)>,
}

impl Measure {
    pub fn for_request(request: &Request) -> Self {
        let search = |r: &ExcitationRequest| (r.search.time_limit_s, r.problem.spec().order);
        let (robot, search) = match request {
            Request::Excite(request) => (request.problem.robot(), Some(search(request))),
            Request::Identify(request) => (&request.robot, None),
            Request::Validate(request) => (&request.robot, None),
        };
        Self {
            joints: robot.joint_count(),
            search,
        }
    }

    /// A search that may take longer than `shortest_long_s` is long.
    pub fn class(&self, shortest_long_s: f64) -> Class {
        match self.search {
            Some((time_limit_s, _)) if time_limit_s > shortest_long_s => Class::Long,
            Some(_) => Class::Brief,
            None => Class::Short,
        }
    }
}

/// News of a running computation.
#[derive(Debug, Clone)]
pub enum Notice {
    Search(Progress),
    Step(Step),
    /// All but what is made for pictures, which comes next.
    Result(JobOutcome),
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JobOutcome {
    /// How a search ended; an identification that has a result has converged.
    pub status: String,
    /// The document, as it is handed out.
    pub document: ByteBuf,
    /// The identified model in all its forms, where there is one.
    pub model: Option<ByteBuf>,
    /// Of a search.
    pub found: Option<SearchFound>,
}

/// What a search has come to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchFound {
    pub is_feasible: bool,
    pub evaluations: u64,
}

fn bytes(document: &impl Serialize) -> ByteBuf {
    ByteBuf::from(serde_json::to_vec(document).expect("documents are plain data"))
}

impl JobOutcome {
    fn of_search(excited: &Excited) -> Self {
        Self {
            status: excited.document.status.to_string(),
            document: bytes(&excited.document),
            model: None,
            found: Some(SearchFound {
                is_feasible: excited.series.is_some(),
                evaluations: excited.document.search.evaluations,
            }),
        }
    }

    fn of_logs(document: &impl Serialize, model: Option<Vec<u8>>) -> Self {
        Self {
            status: "Converged".to_string(),
            document: bytes(document),
            model: model.map(ByteBuf::from),
            found: None,
        }
    }

    /// The same, saying why it has no predictions.
    pub fn without_predictions(mut self, error: &Error) -> Self {
        let Ok(Value::Object(mut fields)) = serde_json::from_slice(&self.document) else {
            return self;
        };
        fields.insert("predictions_error".into(), error.detail.clone().into());
        self.document = bytes(&fields);
        self
    }
}
