//! Logs and metrics: one line per request with its id, duration and status.

use super::state::Service;
use axum::extract::{MatchedPath, Request, State};
use axum::http::HeaderValue;
use axum::middleware::Next;
use axum::response::Response;
use std::io::IsTerminal;
use std::time::Instant;
use tracing::Instrument;
use tracing_subscriber::EnvFilter;
use uuid::Uuid;

const REQUEST_ID: &str = "x-request-id";

/// Id of a request, among its extensions.
#[derive(Debug, Clone)]
pub struct RequestId(pub String);

/// Gives every request an id (the client's own, if it sends a reasonable one), which stands in all its log lines and in the
/// answer.
pub(super) async fn identify_and_log(State(service): State<Service>, mut request: Request, next: Next) -> Response {
    let given = request.headers().get(REQUEST_ID).and_then(|v| v.to_str().ok());
    let id = match given {
        Some(id) if id.len() <= 128 && !id.is_empty() => id.to_string(),
        _ => Uuid::new_v4().to_string(),
    };
    request.extensions_mut().insert(RequestId(id.clone()));
    let span = tracing::info_span!("request", id, method = %request.method(), path = request.uri().path());
    let (method, started) = (request.method().to_string(), Instant::now());
    // Not the address itself: there are as many of those as there are jobs.
    let route = request.extensions().get::<MatchedPath>().map(|p| p.as_str().to_string());
    let mut response = next.run(request).instrument(span.clone()).await;
    let (elapsed, status) = (started.elapsed(), response.status().as_u16());
    let milliseconds = elapsed.as_secs_f64() * 1e3;
    span.in_scope(|| tracing::info!(status, milliseconds, "answered"));
    if let Some(route) = route {
        service.metrics().answered(&method, &route, status, elapsed);
    }
    if let Ok(value) = HeaderValue::from_str(&id) {
        response.headers_mut().insert(REQUEST_ID, value);
    }
    response
}

/// Sends log lines to standard error, as text or as one JSON object each; `filter` as in `RUST_LOG`. Does nothing if a logger is
/// set already.
pub fn log_to_stderr(filter: &str, json: bool) {
    let filter = EnvFilter::try_new(filter).unwrap_or_else(|_| EnvFilter::new("info"));
    let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    let _ = match json {
        true => builder.json().flatten_event(true).try_init(),
        false => builder.with_ansi(std::io::stderr().is_terminal()).try_init(),
    };
}
