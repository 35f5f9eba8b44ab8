//! Why a description is not a robot. Every problem is collected, so that one round of corrections is enough.

use super::readable;
use std::fmt;

/// All that is wrong with a robot description.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the robot description has {} problem(s): {}", .0.len(), join(.0))]
pub struct ModelError(pub Vec<FieldProblem>);

/// One problem and the place it stands in, as a JSON pointer into the robot document.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldProblem {
    /// JSON pointer (RFC 6901) to the field.
    pub pointer: String,
    /// What is wrong with it.
    pub detail: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl FieldProblem {
    /// A problem without a hint.
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            pointer: pointer.into(),
            detail: readable(detail),
            hint: None,
        }
    }

    /// The same with what to do about it.
    pub fn with_hint(self, hint: impl Into<String>) -> Self {
        Self {
            hint: Some(readable(hint)),
            ..self
        }
    }
}

impl fmt::Display for FieldProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.pointer, self.detail)?;
        match &self.hint {
            Some(hint) => write!(f, " ({hint})"),
            None => Ok(()),
        }
    }
}

fn join(problems: &[FieldProblem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
