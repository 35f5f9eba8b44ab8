//! Query strings, checked like documents: all that is wrong is reported at once.

use crate::app::{Code, Error};
use crate::model::FieldProblem;
use crate::service::problem::Failure;
use axum::extract::{FromRequestParts, Query};
use axum::http::request::Parts;
use std::collections::BTreeMap;

/// The parameters of a query string, taken one by one.
pub struct QueryFields {
    given: BTreeMap<String, String>,
    known: Vec<&'static str>,
    problems: Vec<FieldProblem>,
}

impl<S: Send + Sync> FromRequestParts<S> for QueryFields {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Failure> {
        let Query(given) = Query::try_from_uri(&parts.uri).map_err(|e| {
            Failure(Error::new(
                Code::InvalidQuery,
                format!("the query string cannot be read: {e}"),
            ))
        })?;
        Ok(Self {
            given,
            known: Vec::new(),
            problems: Vec::new(),
        })
    }
}

impl QueryFields {
    /// The value of `name` read by `read`, which says what it expects otherwise; `default` where it is not given.
    pub fn take<T>(&mut self, name: &'static str, default: T, expected: &str, read: impl Fn(&str) -> Option<T>) -> T {
        self.known.push(name);
        let Some(text) = self.given.remove(name) else { return default };
        read(&text).unwrap_or_else(|| {
            let shown: String = text.chars().take(80).collect();
            self.problems.push(FieldProblem::new(
                format!("/query/{name}"),
                format!("is `{shown}`, expected {expected}"),
            ));
            default
        })
    }

    /// # Errors
    /// Values that were wrong, and parameters that nobody took.
    pub fn finish(mut self) -> Result<(), Failure> {
        for name in self.given.keys() {
            let shown: String = name.chars().take(80).collect();
            let problem = FieldProblem::new(format!("/query/{shown}"), "is not a parameter of this address");
            self.problems
                .push(problem.with_hint(format!("one of: {}", self.known.join(", "))));
        }
        if self.problems.is_empty() {
            return Ok(());
        }
        let detail = format!("the query string has {} problem(s)", self.problems.len());
        Err(Failure(Error {
            errors: self.problems,
            ..Error::new(Code::InvalidQuery, detail)
        }))
    }
}
