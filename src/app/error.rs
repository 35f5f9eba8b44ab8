//! What can go wrong, under stable codes that the service and the command line share.

use crate::formats::Malformed;
use crate::model::{FieldProblem, readable};

/// A stable name for one kind of error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Code {
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
}

/// Exit status of the command line by kind of error; outcomes of a search have their own: 3 infeasible, 4 cancelled with the best found.
pub const EXIT_INTERNAL: u8 = 1;
pub const EXIT_BAD_INPUT: u8 = 2;
/// Cancelled without a result.
pub const EXIT_CANCELLED: u8 = 4;

impl Code {
    pub const ALL: [Code; 39] = {
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

    pub fn http_status(self) -> u16 {
        self.entry().1
    }

    pub fn exit_status(self) -> u8 {
        self.entry().2
    }

    pub fn title(self) -> &'static str {
        self.entry().3
    }
}

/// An error as users see it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: {detail}", code.name())]
pub struct Error {
    pub code: Code,
    /// What happened, for people.
    pub detail: String,
    /// What to do about it, where that is known.
    pub hint: Option<String>,
    /// Every bad field.
    pub errors: Vec<FieldProblem>,
}

impl Error {
    pub fn new(code: Code, detail: impl Into<String>) -> Self {
        Self {
            code,
            detail: readable(detail),
            hint: None,
            errors: Vec::new(),
        }
    }

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
