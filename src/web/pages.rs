//! The pages: one frame around one fragment each.

use super::assets::{Asset, asset, text};
use axum::Router;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;

/// Address, title and name of every page: `name.html` is its fragment, `name.js` its module.
const PAGES: &[(&str, &str, &str)] = &[
    ("/", "Lab", "lab"),
    ("/robot", "Robot", "robot"),
    ("/design", "Design", "design"),
    ("/identification", "Identification", "identification"),
    ("/loop", "Diagnosis", "loop"),
    ("/runs", "Runs", "runs"),
    ("/help", "Help", "help"),
];

/// What the pages may load: their own files, and no script that stands in a page. plotly.js sets styles on elements and hands
/// pictures out as data and blob addresses; so does Swagger UI.
pub const PAGE_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
    font-src 'self'; connect-src 'self'; form-action 'self'; base-uri 'none'; object-src 'none'; frame-ancestors 'none'";

/// Routes of the pages and of what they load. They hold no data of the lab: that comes over the interface, with whatever it asks
/// for in the way of tokens.
pub fn pages<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let router = PAGES.iter().fold(Router::new(), |router, &(address, title, name)| {
        let page = framed(title, name);
        router.route(address, get(move || std::future::ready(Html(page.clone()))))
    });
    router.route("/assets/{*file}", get(file))
}

fn framed(title: &str, name: &str) -> String {
    text("frame.html")
        .replace("{title}", title)
        .replace("{name}", name)
        .replace("{main}", &text(&format!("{name}.html")))
}

/// What a browser shows at an address where there is nothing.
pub fn missing_page() -> Response {
    (StatusCode::NOT_FOUND, Html(framed("Not found", "missing"))).into_response()
}

async fn file(axum::extract::Path(name): axum::extract::Path<String>, headers: HeaderMap) -> Response {
    let Some(Asset {
        media_type,
        etag,
        plain,
        gzip,
    }) = asset(&name)
    else {
        return (StatusCode::NOT_FOUND, format!("there is no asset `{name}`")).into_response();
    };
    // Asked for again every time, answered in a line while it has not changed: a new program never meets old pages.
    let common = [
        (header::CONTENT_TYPE, media_type),
        (header::ETAG, etag.clone()),
        (header::CACHE_CONTROL, "no-cache".to_string()),
        (header::VARY, "accept-encoding".to_string()),
    ];
    let has = |name: header::HeaderName, wanted: &str| {
        let values = headers.get_all(name).iter().filter_map(|v| v.to_str().ok());
        values
            .flat_map(|v| v.split(','))
            .any(|v| v.trim().split(';').next() == Some(wanted))
    };
    if has(header::IF_NONE_MATCH, &etag) {
        return (StatusCode::NOT_MODIFIED, common).into_response();
    }
    match gzip.filter(|_| has(header::ACCEPT_ENCODING, "gzip")) {
        Some(packed) => (common, [(header::CONTENT_ENCODING, "gzip")], packed).into_response(),
        None => (common, plain).into_response(),
    }
}
