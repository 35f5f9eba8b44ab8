//! How many requests one client may make.
//!
//! A client is who it has been proven to be: a token that is known, else the address that the connection comes from. What a
//! request says of itself does not count: whoever invents tokens, or addresses in the headers of proxies, would have a fresh
//! budget for every invention. Behind a proxy all who have no token share the budget of the proxy; tokens have theirs wherever
//! they come from.

use super::access::Access;
use super::config::Config;
use super::problem::Failure;
use crate::app::{Code, Error};
use axum::body::Body;
use axum::extract::ConnectInfo;
use axum::http::{HeaderValue, Request, Response, header};
use axum::response::IntoResponse;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tower_governor::governor::{GovernorConfig, GovernorConfigBuilder};
use tower_governor::key_extractor::KeyExtractor;
use tower_governor::{GovernorError, GovernorLayer};

/// A token that is known, or an address where there is none.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Client {
    /// By its id.
    Token(String),
    /// By the address of the connection; nothing where it is unknown.
    Address(Option<IpAddr>),
}

#[derive(Debug, Clone)]
pub struct ClientOf;

impl KeyExtractor for ClientOf {
    type Key = Client;

    fn extract<T>(&self, request: &Request<T>) -> Result<Client, GovernorError> {
        let access = request.extensions().get::<Access>();
        if let Some(token) = access.map(Access::token).filter(|id| !id.is_empty()) {
            return Ok(Client::Token(token.to_string()));
        }
        let peer = request.extensions().get::<ConnectInfo<SocketAddr>>();
        Ok(Client::Address(peer.map(|p| p.0.ip())))
    }
}

type Limits = GovernorConfig<ClientOf, governor_middleware::NoOp>;

mod governor_middleware {
    /// Without headers about what is left.
    pub type NoOp = governor::middleware::NoOpMiddleware<governor::clock::QuantaInstant>;
}

/// The layer, unless requests are not limited.
pub fn limit(config: &Config) -> Option<GovernorLayer<ClientOf, governor_middleware::NoOp, Body>> {
    let per_second = config.requests_per_second?.clamp(1, 1_000_000);
    let limits: Arc<Limits> = Arc::new(
        GovernorConfigBuilder::default()
            .period(Duration::from_secs(1) / per_second as u32)
            .burst_size(config.request_burst.max(1))
            .key_extractor(ClientOf)
            .finish()?,
    );
    forget_idle(&limits);
    Some(GovernorLayer::new(limits).error_handler(refused))
}

/// Clients that have not been heard of for a while need no memory.
fn forget_idle(limits: &Arc<Limits>) {
    let weak = Arc::downgrade(limits);
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(Duration::from_secs(60)).await;
            let Some(limits) = weak.upgrade() else { return };
            limits.limiter().retain_recent();
        }
    });
}

fn refused(error: GovernorError) -> Response<Body> {
    let wait = match error {
        GovernorError::TooManyRequests { wait_time, .. } => wait_time.max(1),
        _ => 1,
    };
    let mut response = Failure(Error::new(Code::RateLimited, "too many requests in a short time")).into_response();
    response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(wait));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Invented tokens and headers of proxies do not make another client.
    #[test]
    fn prop_a_client_is_what_has_been_proven_of_it() {
        let peer = SocketAddr::from(([192, 0, 2, 7], 4000));
        let request = |headers: &[(&str, &str)]| {
            let bare = Request::builder().extension(ConnectInfo(peer));
            let built = headers.iter().fold(bare, |r, (name, value)| r.header(*name, *value));
            built.body(()).unwrap()
        };
        let address = Client::Address(Some(peer.ip()));
        for headers in [
            [].as_slice(),
            &[("authorization", "Bearer invented")],
            &[("x-forwarded-for", "10.0.0.1")],
        ] {
            assert_eq!(ClientOf.extract(&request(headers)).unwrap(), address, "{headers:?}");
        }
        let mut anybody = request(&[]);
        anybody.extensions_mut().insert(Access::default());
        assert_eq!(ClientOf.extract(&anybody).unwrap(), address);
        let mut known = request(&[]);
        let access = Access::of_test(&["*"]);
        let id = access.token().to_string();
        known.extensions_mut().insert(access);
        assert_eq!(ClientOf.extract(&known).unwrap(), Client::Token(id));
    }
}
