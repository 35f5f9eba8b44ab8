//! `/effects`: the lab's catalogue of own effects.

use crate::app::{Error, ProblemDetails};
use crate::documents::requests::CatalogueEffect;
use crate::formats::Parsed;
use crate::model::FieldProblem;
use crate::service::access::Access;
use crate::service::child::{REQUEST, Task};
use crate::service::document::JsonBody;
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::{Role, unreadable_effect};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;

/// An effect of the catalogue.
#[derive(Serialize, utoipa::ToSchema)]
pub struct EffectEntry {
    /// What requests and robots call it.
    #[schema(example = "hose")]
    pub name: String,
    /// Its definition.
    pub definition: CatalogueEffect,
    /// The formula as MathML; null where it cannot be set.
    pub mathml: Option<String>,
}

/// The lab's catalogue of own effects.
#[derive(Serialize, utoipa::ToSchema)]
pub struct EffectList {
    /// In the order of their names.
    pub effects: Vec<EffectEntry>,
}

impl EffectEntry {
    fn new(definition: CatalogueEffect) -> Self {
        Self {
            name: definition.name.clone(),
            mathml: definition.mathml(),
            definition,
        }
    }

    fn kept(name: &str, document: Value) -> Result<Self, Error> {
        let definition = serde_json::from_value(document).map_err(|e| unreadable_effect(name, &e.to_string()))?;
        Ok(Self::new(definition))
    }
}

/// All effects of the catalogue. One that is kept and cannot be read is left out; asked for by its name, it is said why.
#[utoipa::path(get, path = "/effects", tag = "effects", operation_id = "list_effects", responses((status = 200, body = EffectList)))]
pub async fn list(State(service): State<Service>, access: Access) -> Result<Json<EffectList>, Failure> {
    access.require(Role::Read)?;
    let mut effects = Vec::new();
    for (name, document) in service.store().effects().await? {
        match document.and_then(|document| EffectEntry::kept(&name, document)) {
            Ok(entry) => effects.push(entry),
            Err(e) => tracing::error!(effect = name, detail = e.detail, "left out of the list of effects"),
        }
    }
    Ok(Json(EffectList { effects }))
}

/// The definition of an effect of the catalogue.
#[utoipa::path(
    get, path = "/effects/{name}", tag = "effects", operation_id = "get_effect",
    params(("name" = String, Path, description = "Name of the effect", example = "hose")),
    responses(
        (status = 200, body = CatalogueEffect),
        (status = 404, description = "Unknown effect", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 500, description = "Kept, but its document cannot be read", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn get(
    State(service): State<Service>,
    access: Access,
    Path(name): Path<String>,
) -> Result<Json<CatalogueEffect>, Failure> {
    access.require(Role::Read)?;
    let document = service.effect(&name).await?;
    Ok(Json(EffectEntry::kept(&name, document)?.definition))
}

/// Keep an own effect in the catalogue, in the place of the one that had its name.
///
/// The definition is that of `effects` of an identification request; `joint` may be left out, and is then stated where the effect
/// is used. What needs no robot is checked: names, parameters, ranges, units and the formula. Jobs that were submitted before
/// keep the definition as it was. The catalogue is that of all robots: a token needs the role admin for `*`.
#[utoipa::path(
    put, path = "/effects/{name}", tag = "effects", operation_id = "put_effect",
    params(("name" = String, Path, description = "Name, as in the definition", example = "hose")),
    request_body(content((CatalogueEffect = "application/json"))),
    responses(
        (status = 200, description = "Replaced", body = EffectEntry),
        (status = 201, description = "Kept", body = EffectEntry, headers(("Location" = String, description = "Address of the effect"))),
        (status = 400, description = "Not JSON", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "The catalogue has no room", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    access: Access,
    Path(name): Path<String>,
    body: JsonBody,
) -> Result<Response, Failure> {
    access.require_catalogue()?;
    let definition = read(&service, body.parsed).await?;
    if definition.name != name {
        let problem = FieldProblem::new("/name", format!("is `{}`, and the address says `{name}`", definition.name));
        return Err(Failure(Error::invalid(
            "the effect",
            vec![problem.with_hint("let both be the same name")],
        )));
    }
    let document = serde_json::to_value(&definition).expect("plain data");
    let new = service.put_effect(&name, &document, &access).await?;
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    let location = [(header::LOCATION, format!("/effects/{name}"))];
    Ok((status, location, Json(EffectEntry::new(definition))).into_response())
}

/// Read and check a definition without keeping it: what would be wrong with it, and its formula as MathML.
#[utoipa::path(
    post, path = "/effect-preview", tag = "effects", operation_id = "preview_effect",
    request_body(content((CatalogueEffect = "application/json"))),
    responses(
        (status = 200, body = EffectEntry),
        (status = 400, description = "Not JSON", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn preview(State(service): State<Service>, access: Access, body: JsonBody) -> Result<Json<EffectEntry>, Failure> {
    access.require(Role::Run)?;
    Ok(Json(EffectEntry::new(read(&service, body.parsed).await?)))
}

/// Reads a definition where it can do no harm.
async fn read(service: &Service, parsed: Parsed) -> Result<CatalogueEffect, Error> {
    let document = parsed.into();
    service.compute_document(Task::Effect { document }, REQUEST).await
}

/// Remove an effect from the catalogue. Jobs that were submitted before keep its definition.
#[utoipa::path(
    delete, path = "/effects/{name}", tag = "effects", operation_id = "delete_effect",
    params(("name" = String, Path, description = "Name of the effect")),
    responses(
        (status = 204, description = "Removed"),
        (status = 404, description = "Unknown effect", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "A robot of the lab names it", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn delete(State(service): State<Service>, access: Access, Path(name): Path<String>) -> Result<StatusCode, Failure> {
    access.require_catalogue()?;
    service.remove_effect(&name, &access).await?;
    Ok(StatusCode::NO_CONTENT)
}
