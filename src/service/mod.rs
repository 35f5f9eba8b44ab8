//! The HTTP service: routes with their documentation, jobs, and errors as problem documents.

pub mod api;
mod config;
mod document;
mod jobs;
mod prefer;
mod problem;
mod router;
mod state;
mod telemetry;

pub use config::Config;
pub use router::{openapi_json, router};
pub use state::Service;
pub use telemetry::log_to_stderr;

use std::future::Future;
use tokio::net::TcpListener;

/// Serves on `listener` until `shutdown` resolves; then jobs are cancelled, their results handed to those who wait, open answers
/// finished, and the function returns.
///
/// # Errors
/// The listener fails.
pub async fn serve(
    listener: TcpListener,
    config: Config,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> std::io::Result<()> {
    let service = Service::start(config);
    let closing = service.clone();
    let graceful = async move {
        shutdown.await;
        tracing::info!("shutting down");
        closing.jobs().close();
    };
    axum::serve(listener, router(service.clone()))
        .with_graceful_shutdown(graceful)
        .await?;
    service.jobs().drained().await;
    Ok(())
}
