//! Headers by which browsers protect the answers of this server.

use crate::web;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::Response;

/// Of everything that is not a page: data that a browser shows loads nothing, and stands in no frame.
const DATA_POLICY: &str = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// Of every answer: what it says it is, is what it is; other sites neither embed it nor learn from which address somebody came.
const ALWAYS: [(HeaderName, &str); 4] = [
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    // Not `no-referrer`: forms would then come from the origin `null`.
    (header::REFERRER_POLICY, "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Puts the headers into an answer that does not have its own.
pub(super) async fn protect(mut response: Response) -> Response {
    let is_page = response
        .headers()
        .get(header::CONTENT_TYPE)
        .is_some_and(|kind| kind.as_bytes().starts_with(b"text/html"));
    let policy = if is_page { web::PAGE_POLICY } else { DATA_POLICY };
    let headers = response.headers_mut();
    let mut set = |name: HeaderName, value: &'static str| {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    };
    ALWAYS.into_iter().for_each(|(name, value)| set(name, value));
    set(header::CONTENT_SECURITY_POLICY, policy);
    if is_page {
        // A page that opened this one has no hold on it.
        set(HeaderName::from_static("cross-origin-opener-policy"), "same-origin");
    }
    response
}
