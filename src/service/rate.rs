//! How many requests one client may make.

use super::access::bearer;
use super::config::Config;
use super::problem::Failure;
use super::store::sha256;
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

/// A token, or an address where there is none.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Client {
    Token(String),
    Address(Option<IpAddr>),
}

#[derive(Debug, Clone)]
pub struct ClientOf;

impl KeyExtractor for ClientOf {
    type Key = Client;

    fn extract<T>(&self, request: &Request<T>) -> Result<Client, GovernorError> {
        if let Some(token) = bearer(request.headers()) {
            return Ok(Client::Token(sha256(token.as_bytes())));
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
