//! Addresses that can be read at all.

use super::problem::Failure;
use crate::app::{Code, Error};
use axum::extract::Request;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Answers addresses that are no text, at whatever route: their handlers read parts of them as text, and would say so in words of
/// their own.
pub(super) async fn refuse_unreadable(request: Request, next: Next) -> Response {
    match is_text(request.uri().path()) {
        true => next.run(request).await,
        false => Failure(unreadable()).into_response(),
    }
}

fn unreadable() -> Error {
    Error::new(
        Code::MalformedAddress,
        "the path of the address is not UTF-8 once its `%XX` are undone",
    )
    .with_hint(
        "names in addresses are UTF-8 text with `%XX` for every byte that may not stand there; /openapi.json lists all addresses",
    )
}

/// Whether a path is UTF-8 once its percent-encoding (RFC 3986, 2.1) is undone. A `%` without two digits stands for itself.
fn is_text(path: &str) -> bool {
    let bytes = path.as_bytes();
    let (mut decoded, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while at < bytes.len() {
        let escaped = (bytes[at] == b'%').then(|| hex_pair(bytes.get(at + 1..at + 3)?)).flatten();
        decoded.push(escaped.unwrap_or(bytes[at]));
        at += if escaped.is_some() { 3 } else { 1 };
    }
    std::str::from_utf8(&decoded).is_ok()
}

fn hex_pair(digits: &[u8]) -> Option<u8> {
    let digit = |d: u8| char::from(d).to_digit(16);
    let value = 16 * digit(digits[0])? + digit(digits[1])?;
    u8::try_from(value).ok()
}

#[cfg(test)]
mod tests {
    use super::is_text;

    #[test]
    fn prop_paths_are_text_as_the_standard_has_it() {
        for text in [
            "/",
            "/jobs/x",
            "/robots/%C3%A4rm",
            "/robots/\u{e4}rm",
            "/jobs/%",
            "/jobs/%4",
            "/jobs/%zz",
            "/jobs/%%41",
            "/a%2Fb",
        ] {
            assert!(is_text(text), "{text}");
        }
        // A byte that begins nothing, half a letter, a half of a surrogate pair, and the same in the middle of a path.
        for bytes in [
            "/jobs/%FF",
            "/robots/%C3",
            "/robots/%ED%A0%80",
            "/jobs/%ff/events",
            "/%C3/%A4",
        ] {
            assert!(!is_text(bytes), "{bytes}");
        }
    }
}
