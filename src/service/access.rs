//! Who may do what: bearer tokens, each for some robots and with a role.

use super::problem::Failure;
use super::state::Service;
use super::store::{AuditEntry, Role, TokenRow, hex, now_us, rfc3339, sha256};
use super::telemetry::RequestId;
use crate::app::{Code, Error};
use axum::extract::{ConnectInfo, FromRequestParts, Request, State};
use axum::http::{HeaderMap, header, request::Parts};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use rand::RngExt;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use uuid::Uuid;

/// What stands for all robots.
pub const ALL_ROBOTS: &str = "*";

/// Who asks. Without tokens anyone may do anything.
#[derive(Debug, Clone, Default)]
pub struct Access {
    token: Option<Arc<TokenRow>>,
    peer: Option<SocketAddr>,
    request: String,
}

impl Access {
    /// Whether what belongs to `robot` is seen.
    pub fn sees(&self, robot: &str) -> bool {
        match &self.token {
            None => true,
            Some(token) => token.robots.iter().any(|r| r == ALL_ROBOTS || r == robot),
        }
    }

    /// The robots seen; `None` for all.
    pub fn robots(&self) -> Option<&[String]> {
        let robots = &self.token.as_ref()?.robots;
        (!robots.iter().any(|r| r == ALL_ROBOTS)).then_some(robots.as_slice())
    }

    /// Id of the token, empty without one.
    pub fn token(&self) -> &str {
        self.token.as_ref().map_or("", |t| t.id.as_str())
    }

    /// Name of the token, or the address of the client.
    fn who(&self) -> String {
        match (&self.token, self.peer) {
            (Some(token), _) => token.name.clone(),
            (None, Some(peer)) => peer.ip().to_string(),
            (None, None) => String::new(),
        }
    }

    /// What the audit log says of a deed of theirs.
    pub fn entry(&self, action: &str, robot: &str, target: &str) -> AuditEntry {
        tracing::info!(target: "dynident::audit", who = self.who(), token = self.token(), action, robot, subject = target, "did");
        AuditEntry {
            at_us: now_us(),
            request: self.request.clone(),
            token: self.token().to_string(),
            who: self.who(),
            action: action.to_string(),
            robot: robot.to_string(),
            target: target.to_string(),
        }
    }

    /// # Errors
    /// The token's role is a lower one.
    pub fn require(&self, role: Role) -> Result<(), Error> {
        match &self.token {
            Some(token) if token.role < role => {
                let detail = format!("this needs the role `{}`, the token has `{}`", role.name(), token.role.name());
                Err(Error::new(Code::Forbidden, detail))
            }
            _ => Ok(()),
        }
    }

    /// The robot whose tokens see a job on `named` (a robot of the lab or one that comes with the program) or on a robot that
    /// stands in the request itself. Documents are anybody's: with them, a token for one robot works for that robot.
    ///
    /// # Errors
    /// The token is for several robots, and the request does not say which.
    pub fn owner(&self, named: Option<&str>, inside: Option<&str>) -> Result<String, Error> {
        let slug = inside.map(slug);
        let called = named
            .map(str::to_string)
            .or(slug)
            .unwrap_or_else(|| slug_of_nothing().to_string());
        if self.sees(&called) {
            return Ok(called);
        }
        match self.robots() {
            Some([only]) => Ok(only.clone()),
            _ => {
                let detail = "the token is for several robots, and the request does not say which of them this is for";
                Err(Error::new(Code::Forbidden, detail).with_hint("call the robot by one of the names of the token"))
            }
        }
    }
}

fn slug_of_nothing() -> &'static str {
    "robot"
}

/// A name as a path segment: letters and digits in lower case, everything else a hyphen; 64 characters at most.
pub fn slug(name: &str) -> String {
    let mapped: String = name
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' })
        .take(64)
        .collect();
    let parts: Vec<&str> = mapped.split('-').filter(|p| !p.is_empty()).collect();
    if parts.is_empty() {
        slug_of_nothing().to_string()
    } else {
        parts.join("-")
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Access {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Failure> {
        let found = parts.extensions.get::<Access>().cloned();
        // A route without the layer would be open: better none.
        found.ok_or_else(|| Failure(Error::new(Code::Internal, "this address does not know who asks")))
    }
}

/// Why a request is turned away, among its extensions until it has been counted.
#[derive(Debug, Clone)]
struct Refusal(Error);

/// Finds out who asks. Who may not is turned away by [`turn_away`] only: between the two, requests are counted by who was found
/// to ask.
pub async fn authenticate(State(service): State<Service>, mut request: Request, next: Next) -> Response {
    let extensions = request.extensions();
    let peer = extensions.get::<ConnectInfo<SocketAddr>>().map(|c| c.0);
    let id = extensions.get::<RequestId>().map(|r| r.0.clone()).unwrap_or_default();
    let asked = Access {
        token: None,
        peer,
        request: id,
    };
    match identify(&service, request.headers(), asked).await {
        Ok(access) => drop(request.extensions_mut().insert(access)),
        Err(error) => drop(request.extensions_mut().insert(Refusal(error))),
    }
    next.run(request).await
}

/// Answers requests that [`authenticate`] found no leave for.
pub async fn turn_away(mut request: Request, next: Next) -> Response {
    match request.extensions_mut().remove::<Refusal>() {
        Some(Refusal(error)) => Failure(error).into_response(),
        None => next.run(request).await,
    }
}

async fn identify(service: &Service, headers: &HeaderMap, mut access: Access) -> Result<Access, Error> {
    if !service.config().tokens_required {
        return match forwarded(headers) && service.config().refuse_forwarded {
            true => Err(Error::new(
                Code::Forbidden,
                "the request came through a proxy, and this server is open only to its own machine",
            )
            .with_hint("start it with --auth on and give out tokens")),
            false => Ok(access),
        };
    }
    let unauthorized = |detail: &str| {
        Error::new(Code::Unauthorized, detail).with_hint("send `Authorization: Bearer TOKEN`; dynident token create makes tokens")
    };
    let secret = bearer(headers).ok_or_else(|| unauthorized("the request has no bearer token"))?;
    let token = service.store().token(&sha256(secret.as_bytes())).await?;
    let token = token.ok_or_else(|| unauthorized("the bearer token is not known, or was revoked"))?;
    if token.is_expired() {
        let end = token.expires_us.map(rfc3339).unwrap_or_default();
        let error = Error::new(
            Code::TokenExpired,
            format!("the bearer token `{}` was valid until {end}", token.id),
        );
        return Err(error.with_hint("ask the operator for another; dynident token create makes tokens"));
    }
    access.token = Some(Arc::new(token));
    Ok(access)
}

/// Headers that proxies add.
fn forwarded(headers: &HeaderMap) -> bool {
    ["forwarded", "x-forwarded-for", "x-real-ip"]
        .iter()
        .any(|name| headers.contains_key(*name))
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

/// Makes a token that is `valid` for a time from now, or until it is revoked; its secret, which is handed back, is shown once and
/// kept nowhere.
pub fn new_token(name: &str, role: Role, robots: Vec<String>, valid: Option<Duration>) -> (TokenRow, String, String) {
    let secret: [u8; 32] = rand::rng().random();
    let id = Uuid::new_v4().simple().to_string()[..8].to_string();
    let secret = format!("dynident_{id}_{}", hex(&secret));
    let hash = sha256(secret.as_bytes());
    let created_us = now_us();
    let row = TokenRow {
        id,
        name: name.to_string(),
        role,
        robots,
        created_us,
        expires_us: valid.map(|time| created_us.saturating_add(i64::try_from(time.as_micros()).unwrap_or(i64::MAX))),
        revoked_us: None,
    };
    (row, secret, hash)
}

#[cfg(test)]
impl Access {
    /// That of a token that may run jobs of these robots.
    pub(super) fn of_test(robots: &[&str]) -> Self {
        let (row, ..) = new_token("t", Role::Run, robots.iter().map(|r| r.to_string()).collect(), None);
        Self {
            token: Some(Arc::new(row)),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access(robots: &[&str]) -> Access {
        Access::of_test(robots)
    }

    #[test]
    fn a_job_belongs_to_a_robot_of_its_token() {
        let one = access(&["arm-a"]);
        assert_eq!(one.owner(Some("arm-a"), None).unwrap(), "arm-a");
        assert_eq!(one.owner(Some("iiwa14"), None).unwrap(), "arm-a");
        assert_eq!(one.owner(None, Some("Any Name")).unwrap(), "arm-a");
        let two = access(&["arm-a", "arm-b"]);
        assert_eq!(two.owner(None, Some("Arm B")).unwrap(), "arm-b");
        assert_eq!(two.owner(Some("iiwa14"), None).unwrap_err().code, Code::Forbidden);
        let all = access(&["*"]);
        assert_eq!(all.owner(None, Some("My Arm / 2")).unwrap(), "my-arm-2");
        assert_eq!((all.robots(), one.robots().unwrap().len()), (None, 1));
    }

    #[test]
    fn roles_include_the_lower_ones() {
        let run = access(&["*"]);
        assert!(run.require(Role::Read).is_ok() && run.require(Role::Run).is_ok());
        assert_eq!(run.require(Role::Admin).unwrap_err().code, Code::Forbidden);
    }

    #[test]
    fn a_token_expires_when_its_time_is_over() {
        let lasting = |valid: Option<Duration>| new_token("t", Role::Read, vec!["*".into()], valid).0;
        assert!(!lasting(None).is_expired());
        assert!(!lasting(Some(Duration::from_secs(3600))).is_expired());
        // A time beyond all calendars does not come round to the past.
        assert!(!lasting(Some(Duration::MAX)).is_expired());
        assert!(lasting(Some(Duration::ZERO)).is_expired());
    }

    #[test]
    fn secrets_are_not_kept() {
        let (row, secret, hash) = new_token("t", Role::Read, vec!["*".into()], None);
        assert!(!format!("{row:?}").contains(&secret) && hash == sha256(secret.as_bytes()) && secret.len() > 70);
    }
}
