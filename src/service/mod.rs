//! The HTTP service: routes with their documentation, jobs, and errors as problem documents.

mod access;
mod address;
pub mod api;
mod blocking;
mod catalogue;
pub mod child;
mod config;
mod connections;
mod design;
mod document;
mod exchange;
mod folder;
mod known;
mod metrics;
mod origin;
mod prefer;
mod problem;
mod progress;
mod protection;
mod rate;
mod router;
mod rows;
mod spread;
mod state;
pub mod store;
mod submit;
mod telemetry;
mod upkeep;
mod upload;
mod work;
mod worker;

pub use access::new_token;
pub use config::Config;
pub use router::{openapi_json, router};
pub use state::Service;
pub use telemetry::log_to_stderr;

use crate::app::Error;
use std::future::Future;
use tokio::net::TcpListener;

/// Serves on `listener` until `shutdown` resolves; then running jobs go back into the queue, or, where the data does not outlive
/// the process, end with the best they have, open answers are finished or cut off after a few seconds, and the function returns.
///
/// # Errors
/// Data folder or database cannot be used.
pub async fn serve(
    listener: TcpListener,
    config: Config,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> Result<(), Error> {
    let service = Service::open(config).await?;
    worker::start(&service);
    upkeep::start(&service);
    let closing = service.clone();
    let graceful = async move {
        shutdown.await;
        tracing::info!("shutting down");
        closing.close();
    };
    connections::serve_connections(listener, router(service.clone()), service.config(), graceful).await;
    service.close();
    service.drained().await;
    service.children().end();
    service.store().close().await;
    Ok(())
}

/// Does jobs of a shared database until `shutdown` resolves; then running jobs go back into the queue, and the function returns.
///
/// # Errors
/// Data folder or database cannot be used.
pub async fn work(config: Config, shutdown: impl Future<Output = ()> + Send + 'static) -> Result<(), Error> {
    let service = Service::open(config).await?;
    worker::start(&service);
    // Files that it has fetched for jobs that are forgotten by now.
    upkeep::start(&service);
    shutdown.await;
    tracing::info!("shutting down");
    service.close();
    service.drained().await;
    service.children().end();
    service.store().close().await;
    Ok(())
}
