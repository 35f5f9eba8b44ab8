//! All routes. A route and its documentation are registered together.

use super::access::{authenticate, turn_away};
use super::address::refuse_unreadable;
use super::api;
use super::config::Config;
use super::origin::{changes_of_own_pages, only_own_pages};
use super::problem::{Failure, internal_error};
use super::protection::protect;
use super::rate;
use super::state::Service;
use super::telemetry::identify_and_log;
use crate::app::{Code, Error};
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::header::{ACCEPT, CONTENT_LENGTH, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::middleware::{from_fn, from_fn_with_state, map_response};
use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Document;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::SwaggerUi;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "dynident",
        description = "Identifies the dynamics of robot arms. SI units, radians, joints by name. Errors are RFC 9457 problem documents \
            with a stable `code` that name every bad field at once.",
        license(name = "MIT OR Apache-2.0")
    ),
    tags(
        (name = "excitation", description = "Trajectories that excite the dynamics of an arm"),
        (name = "identification", description = "From logs to parameters, and models against logs"),
        (name = "jobs", description = "Work that goes on: state, progress, cancelling"),
        (name = "robots", description = "Robots that come with the program, and the lab's own"),
        (name = "effects", description = "The lab's catalogue of own effects, which requests and robots use by their names"),
        (name = "health", description = "For whoever watches the process"),
    )
)]
struct ApiDocument;

/// Routes with their document: those that need to know who asks, and those that do not.
fn documented(largest_upload: usize) -> (Router<Service>, Router<Service>, Document) {
    let uploads = OpenApiRouter::new()
        .routes(routes!(api::identify::post))
        .routes(routes!(api::identify::post_validation))
        .routes(routes!(api::inspect::post))
        .routes(routes!(api::inspect::columns))
        // Logs are streamed to disk: their bound is not that of documents, which are held in memory.
        .layer(DefaultBodyLimit::max(largest_upload));
    let open = OpenApiRouter::new()
        .routes(routes!(api::health::live))
        .routes(routes!(api::health::ready));
    let (open, open_document) = open.split_for_parts();
    let (routes, mut document) = OpenApiRouter::with_openapi(ApiDocument::openapi())
        .routes(routes!(api::excitation::post))
        .routes(routes!(api::excitation::get))
        .routes(routes!(api::excitation::trajectory))
        .merge(uploads)
        .routes(routes!(api::identify::get))
        .routes(routes!(api::identify::model, api::identify::patch_model))
        .routes(routes!(api::report::get))
        .routes(routes!(api::identify::get_validation))
        .routes(routes!(api::jobs::list))
        .routes(routes!(api::jobs::get, api::jobs::cancel, api::jobs::describe))
        .routes(routes!(api::jobs::events))
        .routes(routes!(api::robots::list, api::robots::post))
        .routes(routes!(api::robots::get, api::robots::put, api::robots::delete))
        .routes(routes!(api::robots::base_parameters))
        .routes(routes!(api::effects::list))
        .routes(routes!(api::effects::get, api::effects::put, api::effects::delete))
        .routes(routes!(api::effects::preview))
        .routes(routes!(api::archive::post))
        .routes(routes!(api::motion::post))
        .routes(routes!(api::health::metrics))
        .split_for_parts();
    say_what_any_may_answer(&mut document);
    document.merge(open_document);
    (routes, open, document)
}

/// Every address that asks for tokens may refuse.
fn say_what_any_may_answer(document: &mut Document) {
    use utoipa::openapi::{ContentBuilder, Ref, ResponseBuilder, security::SecurityRequirement};
    let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).build();
    let components = document.components.get_or_insert_with(Default::default);
    components
        .security_schemes
        .insert("token".to_string(), SecurityScheme::Http(scheme).into());
    let problem = |text: &str| {
        let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
        ResponseBuilder::new()
            .description(text)
            .content("application/problem+json", content)
            .build()
    };
    let all = [
        ("401", "No bearer token, or one that is not known, where tokens are needed"),
        (
            "403",
            "The token's role or robots do not allow it; or the request comes from a page of another site, where no token is needed",
        ),
        ("408", "The body stopped coming in"),
        (
            "421",
            "A server that needs no tokens, asked for by a name that is not known to be its own",
        ),
        ("429", "Too many requests, or too many waiting jobs; see `Retry-After`"),
        ("503", "Database or disk fail, or too many jobs wait; see `Retry-After`"),
    ];
    for (path, item) in document.paths.paths.iter_mut() {
        let names = path.contains('{').then_some(("400", "The address is not UTF-8 text"));
        let operations = [
            &mut item.get,
            &mut item.put,
            &mut item.post,
            &mut item.delete,
            &mut item.patch,
        ];
        for operation in operations.into_iter().flatten() {
            for (status, text) in names.into_iter().chain(all) {
                let answers = &mut operation.responses.responses;
                answers.entry(status.to_string()).or_insert_with(|| problem(text).into());
            }
            let token = SecurityRequirement::new("token", Vec::<String>::new());
            operation.security = Some(vec![SecurityRequirement::default(), token]);
        }
    }
}

/// The interface as an OpenAPI document, as it is checked in under `openapi/`.
pub fn openapi_json() -> String {
    let mut text = documented(Config::default().largest_upload)
        .2
        .to_pretty_json()
        .expect("an OpenAPI document is plain data");
    text.push('\n');
    text
}

/// What the page of Swagger UI lacks: the width of a screen, without which phones show it as wide as a desk; its main part as
/// such; names and colours that everybody can read (`docs.js`, `docs.css`); and a title.
const ADDED_TO_DOCS: [(&str, &str); 4] = [
    (
        "<head>",
        "<head>\n    <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n    <script type=\"module\" src=\"/assets/docs.js\"></script>",
    ),
    (
        "href=\"index.css\" />",
        "href=\"index.css\" />\n    <link rel=\"stylesheet\" href=\"/assets/docs.css\" />",
    ),
    ("<title>Swagger UI</title>", "<title>API · dynident</title>"),
    ("<div id=\"swagger-ui\"></div>", "<main id=\"swagger-ui\"></main>"),
];

/// The page of Swagger UI for every screen and for everybody.
async fn fit_for_all(response: Response) -> Response {
    const LARGEST_PAGE: usize = 1 << 16;
    let html = |r: &Response| {
        r.headers()
            .get(CONTENT_TYPE)
            .is_some_and(|t| t.as_bytes().starts_with(b"text/html"))
    };
    if !html(&response) {
        return response;
    }
    let (mut head, body) = response.into_parts();
    let Ok(page) = axum::body::to_bytes(body, LARGEST_PAGE).await else {
        return StatusCode::INTERNAL_SERVER_ERROR.into_response();
    };
    let page = ADDED_TO_DOCS
        .iter()
        .fold(String::from_utf8_lossy(&page).into_owned(), |page, (old, new)| {
            page.replacen(old, new, 1)
        });
    head.headers.remove(CONTENT_LENGTH);
    Response::from_parts(head, page.into())
}

/// The service as a tower of routes and layers.
pub fn router(service: Service) -> Router {
    let (routes, open, document) = documented(service.config().largest_upload);
    let largest = service.config().largest_document;
    // From the inside out: who asks is found first, counted next, and turned away last, so that refused requests count as well.
    let routes = routes.layer(from_fn(turn_away));
    let routes = match rate::limit(service.config()) {
        Some(layer) => routes.layer(layer),
        None => routes,
    };
    let routes = routes.layer(from_fn_with_state(service.clone(), authenticate));
    let routes = routes
        .merge(open)
        .merge(crate::web::pages())
        .merge(Router::from(SwaggerUi::new("/docs").url("/openapi.json", document)).layer(map_response(fit_for_all)))
        .fallback(nothing_here)
        .method_not_allowed_fallback(method_not_allowed)
        .layer(DefaultBodyLimit::max(largest))
        .layer(from_fn(refuse_unreadable))
        // Events must go out as they happen: the compressor leaves text/event-stream alone.
        .layer(CompressionLayer::new())
        .layer(CatchPanicLayer::custom(panicked));
    // A server without tokens trusts whoever reaches it: pages of other sites do, through the browser of somebody who may.
    let routes = match service.config().tokens_required {
        true => routes,
        false => routes
            .layer(changes_of_own_pages(&service.config().allowed_hosts))
            .layer(from_fn_with_state(service.clone(), only_own_pages)),
    };
    routes
        .layer(map_response(protect))
        .layer(from_fn_with_state(service.clone(), identify_and_log))
        .with_state(service)
}

/// A page for browsers, a problem for programs.
async fn nothing_here(uri: Uri, headers: HeaderMap) -> Response {
    let accepts = headers.get(ACCEPT).and_then(|v| v.to_str().ok()).unwrap_or_default();
    if accepts.contains("text/html") {
        return crate::web::missing_page();
    }
    let error = Error::new(Code::NotFound, format!("there is nothing at `{}`", uri.path()));
    Failure(error.with_hint("/openapi.json lists all addresses")).into_response()
}

async fn method_not_allowed(uri: Uri) -> Failure {
    let detail = format!("`{}` does not take this method", uri.path());
    Failure(Error::new(Code::MethodNotAllowed, detail).with_hint("the Allow header of this answer lists those it takes"))
}

fn panicked(_: Box<dyn std::any::Any + Send>) -> Response {
    Failure(internal_error()).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_panic_becomes_an_opaque_problem() {
        let response = panicked(Box::new("the secret inside".to_string()));
        assert_eq!(response.status().as_u16(), 500);
        assert_eq!(response.headers()["content-type"], "application/problem+json");
        let body = axum::body::to_bytes(response.into_body(), 10_000).await.unwrap();
        let text = String::from_utf8(body.to_vec()).unwrap();
        assert!(text.contains("\"code\":\"internal\"") && !text.contains("secret"), "{text}");
    }
}
