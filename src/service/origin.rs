//! Whose pages may use a server that asks for no tokens.
//!
//! A browser lets any page send requests to any server. Where no token is needed, being reached is being trusted, so the server
//! itself has to tell its own pages from those of others:
//!
//! - *DNS rebinding*: a foreign name that suddenly points to this machine makes a foreign page one of ours, for the browser. The
//!   page still says the foreign name in `Host`; only addresses in numbers, `localhost` and the names that the operator allows
//!   are answered.
//! - *Requests across sites*: forms, `fetch` and embedded pictures say in `Sec-Fetch-Site` and `Origin` where they come from.
//!   Those that change something are held to tower-http's `csrf` layer; those that read, here, where more is refused than they
//!   could see anyway. What stays allowed is that a person follows a link to a page.
//!
//! Programs send none of these headers, and are not hindered. Where tokens are needed, no foreign page has one, and nothing is
//! checked.

use super::problem::Failure;
use super::state::Service;
use crate::app::{Code, Error};
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use tower_http::csrf::{CsrfLayer, ProtectionError};

/// Fetch metadata, <https://www.w3.org/TR/fetch-metadata/>: who asks, how, and for what.
const SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
const MODE: HeaderName = HeaderName::from_static("sec-fetch-mode");
const DESTINATION: HeaderName = HeaderName::from_static("sec-fetch-dest");

/// The layer that refuses requests of other sites that may change something; pages under the names in `allowed` are this server's
/// own.
pub(super) fn changes_of_own_pages(
    allowed: &[String],
) -> CsrfLayer<impl Fn(ProtectionError) -> Response<Body> + Clone + Send + Sync + 'static> {
    let origins = allowed
        .iter()
        .flat_map(|name| ["http", "https"].map(|scheme| format!("{scheme}://{name}")));
    let trusting = origins.fold(CsrfLayer::new(), |layer, origin| {
        // Names were looked at when the settings were read; one that is none is nobody's origin.
        layer.clone().add_trusted_origin(origin).unwrap_or(layer)
    });
    trusting.with_rejection_response(|_| Failure(of_another_site()).into_response())
}

/// Refuses requests to a name that is not this server's, and those of other sites that read.
pub(super) async fn only_own_pages(State(service): State<Service>, request: Request, next: Next) -> Response {
    match check(&request, &service.config().allowed_hosts) {
        Ok(()) => next.run(request).await,
        Err(error) => Failure(error).into_response(),
    }
}

fn check(request: &Request, allowed: &[String]) -> Result<(), Error> {
    let host = host(request).ok_or_else(no_host)?;
    if !is_own(&host, allowed) {
        return Err(not_our_name(host.host()));
    }
    // What may change something is left to the layer for that.
    let reads = matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    match !reads || is_of_own_page(request.method(), request.headers(), &host, allowed) {
        true => Ok(()),
        false => Err(of_another_site()),
    }
}

/// Name and port that the request is sent to.
fn host(request: &Request) -> Option<Authority> {
    if let Some(authority) = request.uri().authority() {
        return Some(authority.clone());
    }
    let mut given = request.headers().get_all(header::HOST).into_iter();
    let (first, second) = (given.next()?, given.next());
    let host: Authority = first.to_str().ok()?.parse().ok()?;
    // Two of them are read differently by different programs; `user@host` is no host.
    (second.is_none() && !host.as_str().contains('@')).then_some(host)
}

/// Whether a name cannot be that of a foreign page: numbers and `localhost` are not looked up in the DNS.
fn is_own(host: &Authority, allowed: &[String]) -> bool {
    let name = host.host().trim_end_matches('.');
    let number = name.trim_start_matches('[').trim_end_matches(']');
    number.parse::<IpAddr>().is_ok()
        || name.eq_ignore_ascii_case("localhost")
        || allowed
            .iter()
            .any(|own| own.eq_ignore_ascii_case(name) || own.eq_ignore_ascii_case(host.as_str()))
}

/// Whether a request that reads comes from a page of this server, from the address bar, by a link, or from a program.
fn is_of_own_page(method: &Method, headers: &HeaderMap, host: &Authority, allowed: &[String]) -> bool {
    let is = |name: &HeaderName, wanted: &str| headers.get(name).is_some_and(|v| v == wanted);
    if headers.contains_key(SITE) {
        let followed = *method == Method::GET && is(&MODE, "navigate") && is(&DESTINATION, "document");
        return is(&SITE, "same-origin") || is(&SITE, "none") || followed;
    }
    // Browsers say where a request comes from in `Sec-Fetch-Site` only to servers with TLS and on the same machine.
    let Some(origin) = headers.get(header::ORIGIN) else {
        return true;
    };
    let names = || allowed.iter().map(String::as_str).chain([host.as_str()]);
    let own = |origin: &str| {
        let name = origin.split_once("://").map(|(_, name)| name);
        name.is_some_and(|name| names().any(|own| own.eq_ignore_ascii_case(name)))
    };
    origin.to_str().is_ok_and(own)
}

fn no_host() -> Error {
    Error::new(
        Code::WrongHost,
        "the request does not say in one `Host` header which server it is for",
    )
}

fn not_our_name(name: &str) -> Error {
    let name: String = name.chars().take(80).collect();
    let detail = format!("this server needs no tokens, and is not known to be called `{name}`");
    Error::new(Code::WrongHost, detail).with_hint(format!(
        "use its address in numbers, or start it with --allowed-host {name} if that is its name"
    ))
}

fn of_another_site() -> Error {
    let detail = "the request comes from a page of another site, and this server needs no tokens";
    Error::new(Code::CrossSite, detail)
        .with_hint("use the server's own pages, or a program; a proxy must hand on `Host` and `Origin` as they are")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(method: &str, headers: &[(&str, &str)]) -> Request {
        let bare = Request::builder().method(method).uri("/jobs");
        let built = headers.iter().fold(bare, |r, (name, value)| r.header(*name, *value));
        built.body(Body::empty()).unwrap()
    }

    fn refused(request: &Request, allowed: &[&str]) -> Option<Code> {
        let allowed: Vec<String> = allowed.iter().map(|a| a.to_string()).collect();
        check(request, &allowed).err().map(|e| e.code)
    }

    #[test]
    fn only_names_that_nobody_else_can_have_are_answered() {
        for host in [
            "127.0.0.1:8080",
            "127.0.0.1",
            "[::1]:8080",
            "192.168.1.7:80",
            "localhost:8080",
            "LOCALHOST",
            "lab.example.org",
            "lab.example.org.",
            "proxy:8443",
        ] {
            let own = request("GET", &[("host", host)]);
            assert_eq!(refused(&own, &["lab.example.org", "proxy:8443"]), None, "{host}");
        }
        // Names of others that point here, names that only begin or end like ours, and what is no name.
        for host in [
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "localhost.evil.example",
            "evil.example:127",
            "proxy:8444",
            "a@127.0.0.1",
            "",
            "127.0.0.1 evil",
            "1.2.3",
        ] {
            let foreign = request("GET", &[("host", host)]);
            assert_eq!(
                refused(&foreign, &["lab.example.org", "proxy:8443"]),
                Some(Code::WrongHost),
                "{host}"
            );
        }
        assert_eq!(refused(&request("GET", &[]), &[]), Some(Code::WrongHost));
        let two = request("GET", &[("host", "127.0.0.1"), ("host", "evil.example")]);
        assert_eq!(refused(&two, &[]), Some(Code::WrongHost));
    }

    #[test]
    fn pages_of_other_sites_neither_read_nor_embed() {
        let cases = [
            ("GET", &[][..], true),
            ("GET", &[("sec-fetch-site", "same-origin"), ("sec-fetch-mode", "cors")], true),
            ("GET", &[("sec-fetch-site", "none"), ("sec-fetch-mode", "navigate")], true),
            // A link in a wiki.
            (
                "GET",
                &[
                    ("sec-fetch-site", "cross-site"),
                    ("sec-fetch-mode", "navigate"),
                    ("sec-fetch-dest", "document"),
                ],
                true,
            ),
            (
                "GET",
                &[
                    ("sec-fetch-site", "cross-site"),
                    ("sec-fetch-mode", "navigate"),
                    ("sec-fetch-dest", "iframe"),
                ],
                false,
            ),
            (
                "GET",
                &[
                    ("sec-fetch-site", "cross-site"),
                    ("sec-fetch-mode", "no-cors"),
                    ("sec-fetch-dest", "image"),
                ],
                false,
            ),
            // Another port of the same machine is the same site, and another's page.
            ("GET", &[("sec-fetch-site", "same-site"), ("sec-fetch-mode", "cors")], false),
            ("GET", &[("origin", "http://127.0.0.1:8080")], true),
            ("GET", &[("origin", "http://127.0.0.1:3000")], false),
            ("OPTIONS", &[("origin", "http://evil.example")], false),
            ("GET", &[("origin", "null")], false),
        ];
        for (method, headers, allowed) in cases {
            let headers = [&[("host", "127.0.0.1:8080")], headers].concat();
            let code = (!allowed).then_some(Code::CrossSite);
            assert_eq!(refused(&request(method, &headers), &[]), code, "{method} {headers:?}");
        }
    }
}
