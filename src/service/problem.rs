//! Errors as answers.

use crate::app::{Code, Error, ProblemDetails};
use axum::Json;
use axum::extract::rejection::BytesRejection;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use tower_http::timeout::TimeoutError;

/// An error on its way to the client.
#[derive(Debug)]
pub struct Failure(pub Error);

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self(error)
    }
}

impl From<BytesRejection> for Failure {
    fn from(rejection: BytesRejection) -> Self {
        if rejection.status() == StatusCode::PAYLOAD_TOO_LARGE {
            return Self(Error::new(
                Code::PayloadTooLarge,
                "the document is larger than this server accepts",
            ));
        }
        if is_timeout(&rejection) {
            return stalled();
        }
        Self(Error::new(
            Code::MalformedDocument,
            format!("the body could not be read: {}", rejection.body_text()),
        ))
    }
}

/// Whether a body could not be read because it stopped coming in.
pub(super) fn is_timeout(error: &(dyn std::error::Error + 'static)) -> bool {
    std::iter::successors(Some(error), |e| e.source()).any(|e| e.is::<TimeoutError>())
}

/// What a client hears whose body stopped coming in.
pub(super) fn stalled() -> Failure {
    Failure(Error::new(Code::RequestTimeout, "the body stopped coming in").with_hint("send it again"))
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let problem = ProblemDetails::from(&self.0);
        let status = StatusCode::from_u16(problem.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        if status == StatusCode::INTERNAL_SERVER_ERROR {
            tracing::error!(code = problem.code, detail = problem.detail, "request failed");
        }
        let mut response = (status, Json(problem)).into_response();
        response
            .headers_mut()
            .insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        let headers = response.headers_mut();
        if matches!(status, StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS) {
            // A search takes a minute or so; asking more often than this is of no use.
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static("10"));
        }
        if status == StatusCode::UNAUTHORIZED {
            headers.insert(
                header::WWW_AUTHENTICATE,
                HeaderValue::from_static("Bearer realm=\"dynident\""),
            );
        }
        response
    }
}

/// What a client hears of a panic: nothing of its inside.
pub fn internal_error() -> Error {
    Error::new(Code::Internal, "an error inside the server ended this request")
        .with_hint("report it with the X-Request-Id of this answer")
}
