//! What can go wrong, under stable codes that the service and the command line share.

use crate::formats::Malformed;
use crate::model::{FieldProblem, readable};

/// A stable name for one kind of error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Code {
    /// The document cannot be read (HTTP 400).
    MalformedDocument,
    /// The document says something that cannot be (HTTP 422).
    InvalidDocument,
    /// The query string is wrong (HTTP 400).
    InvalidQuery,
    /// The address cannot be read (HTTP 400).
    MalformedAddress,
    /// There is nothing at this address (HTTP 404).
    NotFound,
    /// There is no such robot (HTTP 404).
    UnknownRobot,
    /// There is no such job (HTTP 404).
    UnknownJob,
    /// There is no such excitation (HTTP 404).
    UnknownExcitation,
    /// This address does not take this method (HTTP 405).
    MethodNotAllowed,
    /// A robot of this name exists (HTTP 409).
    RobotExists,
    /// Robots that come with the program cannot be changed (HTTP 409).
    RobotReadOnly,
    /// A stored robot cannot be read (HTTP 500).
    RobotUnreadable,
    /// There is no such effect in the catalogue (HTTP 404).
    UnknownEffect,
    /// A robot of the lab names the effect (HTTP 409).
    EffectInUse,
    /// A stored effect cannot be read (HTTP 500).
    EffectUnreadable,
    /// The catalogue of effects has no room (HTTP 409).
    CatalogueFull,
    /// There is no such identification (HTTP 404).
    UnknownIdentification,
    /// A log cannot be used (HTTP 422).
    InvalidLog,
    /// There is no model that is a physical robot (HTTP 409).
    NoModel,
    /// The job ended without a result (HTTP 409).
    NoResult,
    /// There is no trajectory (HTTP 409).
    NoTrajectory,
    /// This idempotency key belongs to another request (HTTP 422).
    IdempotencyKeyReused,
    /// The document is too large (HTTP 413).
    PayloadTooLarge,
    /// The document is of the wrong type (HTTP 415).
    UnsupportedMediaType,
    /// Too many jobs are waiting (HTTP 503).
    TooManyJobs,
    /// Too many jobs of this robot or token are waiting (HTTP 429).
    LimitReached,
    /// Too many requests (HTTP 429).
    RateLimited,
    /// The server is shutting down (HTTP 503).
    ShuttingDown,
    /// Database or data folder cannot be used (HTTP 503).
    StorageUnavailable,
    /// A token is needed (HTTP 401).
    Unauthorized,
    /// The token is no longer valid (HTTP 401).
    TokenExpired,
    /// The token does not allow this (HTTP 403).
    Forbidden,
    /// The request comes from a page of another site (HTTP 403).
    CrossSite,
    /// The request is for another server (HTTP 421).
    WrongHost,
    /// The request stopped coming in (HTTP 408).
    RequestTimeout,
    /// A file cannot be read (HTTP 500).
    FileUnreadable,
    /// A file cannot be written (HTTP 500).
    FileUnwritable,
    /// The server cannot listen at this address (HTTP 500).
    AddressUnavailable,
    /// A picture, a report or its series cannot be made (HTTP 500).
    DrawingFailed,
    /// The process that did the work ended before it was done (HTTP 500).
    JobCrashed,
    /// The work needs more memory than it may take (HTTP 422).
    MemoryLimit,
    /// The work takes longer than it may (HTTP 422).
    TimeLimit,
    /// Something went wrong inside (HTTP 500).
    Internal,
}

/// Exit status of the command line by kind of error; outcomes of a search have their own: 3 infeasible, 4 cancelled with the best
/// found.
pub const EXIT_INTERNAL: u8 = 1;
/// The input or the request cannot be used.
pub const EXIT_BAD_INPUT: u8 = 2;
/// Cancelled without a result.
pub const EXIT_CANCELLED: u8 = 4;

impl Code {
    /// Every code, for the table of errors in the documentation.
    pub const ALL: [Code; 43] = {
        use Code::*;
        [
            MalformedDocument,
            InvalidDocument,
            InvalidQuery,
            MalformedAddress,
            NotFound,
            UnknownRobot,
            UnknownJob,
            UnknownExcitation,
            MethodNotAllowed,
            RobotExists,
            RobotReadOnly,
            RobotUnreadable,
            UnknownEffect,
            EffectInUse,
            EffectUnreadable,
            CatalogueFull,
            UnknownIdentification,
            InvalidLog,
            NoModel,
            NoResult,
            NoTrajectory,
            IdempotencyKeyReused,
            PayloadTooLarge,
            UnsupportedMediaType,
            TooManyJobs,
            LimitReached,
            RateLimited,
            ShuttingDown,
            StorageUnavailable,
            Unauthorized,
            TokenExpired,
            Forbidden,
            CrossSite,
            WrongHost,
            RequestTimeout,
            FileUnreadable,
            FileUnwritable,
            AddressUnavailable,
            DrawingFailed,
            JobCrashed,
            MemoryLimit,
            TimeLimit,
            Internal,
        ]
    };

    /// `(code, HTTP status, exit status, title)`: the one table of errors.
    fn entry(self) -> (&'static str, u16, u8, &'static str) {
        match self {
            Code::MalformedDocument => ("malformed_document", 400, EXIT_BAD_INPUT, "The document cannot be read"),
            Code::InvalidDocument => (
                "invalid_document",
                422,
                EXIT_BAD_INPUT,
                "The document says something that cannot be",
            ),
            Code::InvalidQuery => ("invalid_query", 400, EXIT_BAD_INPUT, "The query string is wrong"),
            Code::MalformedAddress => ("malformed_address", 400, EXIT_BAD_INPUT, "The address cannot be read"),
            Code::NotFound => ("not_found", 404, EXIT_BAD_INPUT, "There is nothing at this address"),
            Code::UnknownRobot => ("unknown_robot", 404, EXIT_BAD_INPUT, "There is no such robot"),
            Code::UnknownJob => ("unknown_job", 404, EXIT_BAD_INPUT, "There is no such job"),
            Code::UnknownExcitation => ("unknown_excitation", 404, EXIT_BAD_INPUT, "There is no such excitation"),
            Code::UnknownIdentification => (
                "unknown_identification",
                404,
                EXIT_BAD_INPUT,
                "There is no such identification",
            ),
            Code::InvalidLog => ("invalid_log", 422, EXIT_BAD_INPUT, "A log cannot be used"),
            Code::NoModel => ("no_model", 409, EXIT_BAD_INPUT, "There is no model that is a physical robot"),
            Code::MethodNotAllowed => (
                "method_not_allowed",
                405,
                EXIT_BAD_INPUT,
                "This address does not take this method",
            ),
            Code::RobotExists => ("robot_exists", 409, EXIT_BAD_INPUT, "A robot of this name exists"),
            Code::RobotReadOnly => (
                "robot_read_only",
                409,
                EXIT_BAD_INPUT,
                "Robots that come with the program cannot be changed",
            ),
            Code::RobotUnreadable => ("robot_unreadable", 500, EXIT_INTERNAL, "A stored robot cannot be read"),
            Code::UnknownEffect => (
                "unknown_effect",
                404,
                EXIT_BAD_INPUT,
                "There is no such effect in the catalogue",
            ),
            Code::EffectInUse => ("effect_in_use", 409, EXIT_BAD_INPUT, "A robot of the lab names the effect"),
            Code::EffectUnreadable => ("effect_unreadable", 500, EXIT_INTERNAL, "A stored effect cannot be read"),
            Code::CatalogueFull => ("catalogue_full", 409, EXIT_BAD_INPUT, "The catalogue of effects has no room"),
            Code::NoResult => ("no_result", 409, EXIT_CANCELLED, "The job ended without a result"),
            Code::NoTrajectory => ("no_trajectory", 409, EXIT_BAD_INPUT, "There is no trajectory"),
            Code::IdempotencyKeyReused => (
                "idempotency_key_reused",
                422,
                EXIT_BAD_INPUT,
                "This idempotency key belongs to another request",
            ),
            Code::PayloadTooLarge => ("payload_too_large", 413, EXIT_BAD_INPUT, "The document is too large"),
            Code::UnsupportedMediaType => (
                "unsupported_media_type",
                415,
                EXIT_BAD_INPUT,
                "The document is of the wrong type",
            ),
            Code::TooManyJobs => ("too_many_jobs", 503, EXIT_INTERNAL, "Too many jobs are waiting"),
            Code::LimitReached => (
                "limit_reached",
                429,
                EXIT_INTERNAL,
                "Too many jobs of this robot or token are waiting",
            ),
            Code::RateLimited => ("rate_limited", 429, EXIT_INTERNAL, "Too many requests"),
            Code::StorageUnavailable => (
                "storage_unavailable",
                503,
                EXIT_INTERNAL,
                "Database or data folder cannot be used",
            ),
            Code::Unauthorized => ("unauthorized", 401, EXIT_BAD_INPUT, "A token is needed"),
            Code::TokenExpired => ("token_expired", 401, EXIT_BAD_INPUT, "The token is no longer valid"),
            Code::CrossSite => (
                "cross_site",
                403,
                EXIT_BAD_INPUT,
                "The request comes from a page of another site",
            ),
            Code::WrongHost => ("wrong_host", 421, EXIT_BAD_INPUT, "The request is for another server"),
            Code::RequestTimeout => ("request_timeout", 408, EXIT_BAD_INPUT, "The request stopped coming in"),
            Code::Forbidden => ("forbidden", 403, EXIT_BAD_INPUT, "The token does not allow this"),
            Code::ShuttingDown => ("shutting_down", 503, EXIT_INTERNAL, "The server is shutting down"),
            Code::FileUnreadable => ("file_unreadable", 500, EXIT_BAD_INPUT, "A file cannot be read"),
            Code::FileUnwritable => ("file_unwritable", 500, EXIT_BAD_INPUT, "A file cannot be written"),
            Code::AddressUnavailable => (
                "address_unavailable",
                500,
                EXIT_BAD_INPUT,
                "The server cannot listen at this address",
            ),
            Code::DrawingFailed => (
                "drawing_failed",
                500,
                EXIT_INTERNAL,
                "A picture, a report or its series cannot be made",
            ),
            Code::JobCrashed => (
                "job_crashed",
                500,
                EXIT_INTERNAL,
                "The process that did the work ended before it was done",
            ),
            Code::MemoryLimit => (
                "memory_limit",
                422,
                EXIT_INTERNAL,
                "The work needs more memory than it may take",
            ),
            Code::TimeLimit => ("time_limit", 422, EXIT_INTERNAL, "The work takes longer than it may"),
            Code::Internal => ("internal", 500, EXIT_INTERNAL, "Something went wrong inside"),
        }
    }

    /// The stable name.
    pub fn name(self) -> &'static str {
        self.entry().0
    }

    /// HTTP status of an answer with this error.
    pub fn http_status(self) -> u16 {
        self.entry().1
    }

    /// Exit status of the command line, 1 to 4.
    pub fn exit_status(self) -> u8 {
        self.entry().2
    }

    /// One sentence for people, the same for every error of this code.
    pub fn title(self) -> &'static str {
        self.entry().3
    }
}

/// An error as users see it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: {detail}", code.name())]
pub struct Error {
    /// Stable code; HTTP and exit status follow from it.
    pub code: Code,
    /// What happened, for people.
    pub detail: String,
    /// What to do about it, where that is known.
    pub hint: Option<String>,
    /// Every bad field.
    pub errors: Vec<FieldProblem>,
}

impl Error {
    /// An error with a detail of its own and no remedy.
    pub fn new(code: Code, detail: impl Into<String>) -> Self {
        Self {
            code,
            detail: readable(detail),
            hint: None,
            errors: Vec::new(),
        }
    }

    /// The same error with a remedy.
    pub fn with_hint(self, hint: impl Into<String>) -> Self {
        Self {
            hint: Some(readable(hint)),
            ..self
        }
    }

    /// A document with bad fields.
    pub fn invalid(what: &str, errors: Vec<FieldProblem>) -> Self {
        let count = errors.len();
        let detail = format!("{what} has {count} {}", if count == 1 { "problem" } else { "problems" });
        Self {
            errors,
            ..Self::new(Code::InvalidDocument, detail)
        }
    }
}

impl From<Malformed> for Error {
    fn from(malformed: Malformed) -> Self {
        Self {
            hint: malformed.hint,
            ..Self::new(Code::MalformedDocument, malformed.detail)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn codes_are_distinct_and_complete() {
        let names: HashSet<_> = Code::ALL.iter().map(|c| c.name()).collect();
        assert_eq!(names.len(), Code::ALL.len());
        // The last variant closes the list: a new one that is not in ALL makes this fail.
        assert_eq!(Code::Internal as usize + 1, Code::ALL.len());
        for code in Code::ALL {
            assert!((400..600).contains(&code.http_status()), "{code:?}");
            assert!(
                [EXIT_INTERNAL, EXIT_BAD_INPUT, EXIT_CANCELLED].contains(&code.exit_status()),
                "{code:?}"
            );
        }
    }
}
