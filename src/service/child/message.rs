//! What goes through the socket between a server and a child, as MessagePack: each value says where it ends, and numbers keep
//! every bit.

use crate::app::{LogFile, Runs};
use crate::documents::{RobotDocument, RobotReport};
use crate::excitation::Point;
use crate::formats::Parsed;
use crate::model::FieldProblem;
use crate::service::known::Known;
use crate::service::work::{Input, JobKind, JobOutcome};
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{self, Read, Write};
use std::path::PathBuf;

/// To a child.
#[derive(Debug, Serialize, Deserialize)]
pub enum ToChild {
    Begin(Box<Task>),
    /// End with the best there is.
    Cancel,
    /// What the searches beside this one have found.
    Others(Vec<Spot>),
}

/// From a child.
#[derive(Debug, Serialize, Deserialize)]
pub enum FromChild {
    /// The request of a job is read: how long its search may take (s), and whether others may share it.
    Begun {
        search_s: f64,
        shareable: bool,
    },
    News {
        progress: Option<Value>,
        step: Option<Value>,
    },
    Found(Latest),
    /// Wants to know what others have found, and waits.
    AskOthers,
    /// The result, complete but for what is made for pictures.
    Result(JobOutcome),
    /// The end of a job.
    Done(JobOutcome),
    /// The end of any other task.
    Answer(#[serde(with = "serde_bytes")] Vec<u8>),
    /// The end of a task without a result; a stored error.
    Failed(Value),
}

/// What a search has found so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Latest {
    pub epochs: usize,
    /// Logarithm of the criterion at the best point.
    pub best: f64,
    pub points: Vec<Spot>,
    pub evaluations: u64,
}

/// A [`Point`] of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    x: Vec<f64>,
    value: f64,
    polished: bool,
}

impl From<Point> for Spot {
    fn from(Point { x, value, polished }: Point) -> Self {
        Self { x, value, polished }
    }
}

impl From<Spot> for Point {
    fn from(Spot { x, value, polished }: Spot) -> Self {
        Self { x, value, polished }
    }
}

/// What a child is to do.
#[derive(Debug, Serialize, Deserialize)]
pub enum Task {
    Job(Box<JobTask>),
    /// Reads a request: whether it is right, and how large it is. Answers with a [`super::super::work::Measure`].
    Check {
        kind: JobKind,
        document: Document,
        known: Named,
    },
    /// `POST /motion`.
    Motion {
        document: Document,
        known: Named,
    },
    /// `POST /identify/preview`.
    Preview {
        document: Document,
        known: Named,
        logs: Vec<Log>,
        validation: Vec<Log>,
        most_rows: usize,
    },
    /// `POST /logs/columns`. Answers with a [`crate::formats::logs::LogOverview`].
    Columns {
        log: Log,
    },
    /// A robot that is to be kept. Answers with a [`RobotRead`].
    Robot {
        document: Document,
        known: Named,
    },
    /// An own effect that is to be kept in the catalogue, or looked at. Answers with a
    /// [`crate::documents::requests::CatalogueEffect`].
    Effect {
        document: Document,
    },
    /// A ZIP archive of a robot's file with its meshes. Answers with a [`crate::formats::RobotArchive`].
    RobotArchive {
        #[serde(with = "serde_bytes")]
        bytes: Vec<u8>,
    },
    /// `GET /robots/{id}/base-parameters`.
    BaseParameters {
        document: Document,
        known: Named,
    },
    /// `GET /identify/{id}/report`: the result, and what the report says beside it.
    Report {
        #[serde(with = "serde_bytes")]
        result: Vec<u8>,
        id: String,
        ended: Option<String>,
        design: Option<Value>,
    },
    /// Ways into the motion of a design and out of it. Answers with two [`Series`], null where none is asked for.
    Runs {
        input: Input,
        series: Series,
        runs: Runs,
        rate_hz: f64,
    },
    /// A first run of a design: smaller, slower. Answers with its [`Series`], or null where no part of the motion keeps every
    /// limit.
    FirstRun {
        input: Input,
        series: Series,
        amplitude: f64,
        slowness: f64,
    },
}

/// A [`FourierSeries`], joint by joint.
#[derive(Debug, Serialize, Deserialize)]
pub struct Series {
    fundamental_hz: f64,
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    offset: Vec<f64>,
}

impl From<FourierSeries> for Series {
    fn from(series: FourierSeries) -> Self {
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        Self {
            fundamental_hz: series.fundamental_hz,
            a: rows(&series.a),
            b: rows(&series.b),
            offset: series.offset,
        }
    }
}

impl From<Series> for FourierSeries {
    fn from(series: Series) -> Self {
        let matrix = |rows: &[Vec<f64>]| {
            let columns = rows.first().map_or(0, Vec::len);
            DMatrix::from_row_iterator(rows.len(), columns, rows.iter().flatten().copied())
        };
        Self {
            fundamental_hz: series.fundamental_hz,
            a: matrix(&series.a),
            b: matrix(&series.b),
            offset: series.offset,
        }
    }
}

/// What there is to say of a robot.
#[derive(Debug, Serialize, Deserialize)]
pub struct RobotRead {
    pub name: String,
    pub joints: Vec<String>,
    pub notes: Vec<String>,
    /// A [`RobotReport`].
    pub understood: Value,
}

impl From<RobotDocument> for RobotRead {
    fn from(read: RobotDocument) -> Self {
        let understood = serde_json::to_value(RobotReport::from_document(&read)).unwrap_or_default();
        let RobotDocument { robot, notes, .. } = read;
        Self {
            understood,
            name: robot.name().to_string(),
            joints: robot.joints().iter().map(|j| j.name.clone()).collect(),
            notes,
        }
    }
}

/// A job of the queue.
#[derive(Debug, Serialize, Deserialize)]
pub struct JobTask {
    pub kind: JobKind,
    pub input: Input,
    pub logs: Vec<Log>,
    pub validation: Vec<Log>,
    pub most_rows: usize,
    /// Whether the search may take longer than a short one.
    pub long: bool,
    /// Whether other work goes before it.
    pub nice: bool,
    /// What an earlier life of the search has come to.
    pub advance: Advance,
    /// A search beside that of another worker.
    pub share: Option<ShareOf>,
}

/// What earlier lives of a search have spent, and the number of this one.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Advance {
    pub lease: i64,
    pub seconds: f64,
    pub evaluations: u64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct ShareOf {
    pub number: i64,
    /// Until the search is over (s).
    pub seconds: f64,
}

/// A file by its path, and as the client calls it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Log {
    pub name: String,
    pub path: PathBuf,
}

impl From<LogFile> for Log {
    fn from(LogFile { name, path }: LogFile) -> Self {
        Self { name, path }
    }
}

impl From<Log> for LogFile {
    fn from(Log { name, path }: Log) -> Self {
        Self { name, path }
    }
}

/// A [`Parsed`] document.
#[derive(Debug, Serialize, Deserialize)]
pub struct Document {
    value: Value,
    /// Pointer, detail, hint.
    problems: Vec<(String, String, Option<String>)>,
}

impl From<Parsed> for Document {
    fn from(parsed: Parsed) -> Self {
        let parts = |p: FieldProblem| (p.pointer, p.detail, p.hint);
        Self {
            value: parsed.value,
            problems: parsed.problems.into_iter().map(parts).collect(),
        }
    }
}

impl From<Document> for Parsed {
    fn from(document: Document) -> Self {
        let whole = |(pointer, detail, hint)| FieldProblem { pointer, detail, hint };
        Self {
            value: document.value,
            problems: document.problems.into_iter().map(whole).collect(),
        }
    }
}

/// What a request calls by name, with all names that it might have called.
#[derive(Debug, Serialize, Deserialize)]
pub struct Named {
    known: Known,
    names: [Vec<String>; 2],
}

impl From<Known> for Named {
    fn from(known: Known) -> Self {
        let names = known.all_names().map(<[String]>::to_vec);
        Self { known, names }
    }
}

impl From<Named> for Known {
    fn from(Named { known, names }: Named) -> Self {
        known.among(names)
    }
}

/// Writes one message.
pub fn send(stream: &mut impl Write, message: &impl Serialize) -> io::Result<()> {
    // At once: a message in many small writes would wake the reader for each.
    let bytes = rmp_serde::to_vec_named(message).map_err(io::Error::other)?;
    stream.write_all(&bytes)
}

/// Reads one message.
///
/// # Errors
/// The other end is gone, or says what cannot be understood.
pub fn receive<T: DeserializeOwned>(stream: &mut impl Read) -> io::Result<T> {
    rmp_serde::from_read(stream).map_err(io::Error::other)
}
