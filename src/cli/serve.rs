//! `dynident serve`.

use super::{Ending, files};
use crate::app::{Code, Error};
use crate::service::{Config, log_to_stderr, serve};
use std::net::SocketAddr;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Address and port; port 0 takes a free one.
    #[arg(long, default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Searches that run at the same time; each uses all cores.
    #[arg(long, default_value_t = 1)]
    concurrent_jobs: usize,
    /// Jobs that may wait.
    #[arg(long, default_value_t = 100)]
    waiting_jobs: usize,
    /// What is logged to standard error, as in RUST_LOG.
    #[arg(long, default_value = "info")]
    log: String,
}

pub fn run(arguments: &Arguments) -> Result<Ending, Error> {
    log_to_stderr(&arguments.log);
    let runtime = tokio::runtime::Runtime::new().map_err(|e| Error::new(Code::Internal, format!("cannot start: {e}")))?;
    runtime.block_on(listen_and_serve(arguments))?;
    Ok(Ending::Done)
}

async fn listen_and_serve(arguments: &Arguments) -> Result<(), Error> {
    let taken = |e: std::io::Error| {
        Error::new(
            Code::AddressUnavailable,
            format!("cannot listen at {}: {e}", arguments.listen),
        )
        .with_hint("choose another port with --listen, such as 127.0.0.1:8081")
    };
    let listener = tokio::net::TcpListener::bind(arguments.listen).await.map_err(taken)?;
    let address = listener.local_addr().map_err(taken)?;
    files::print(&format!("listening on http://{address}\n"))?;
    let config = Config {
        concurrent_jobs: arguments.concurrent_jobs,
        waiting_jobs: arguments.waiting_jobs,
        ..Config::default()
    };
    serve(listener, config, interrupted())
        .await
        .map_err(|e| Error::new(Code::Internal, format!("the server failed: {e}")))
}

/// Resolves on Ctrl-C or SIGTERM.
async fn interrupted() {
    let interrupt = tokio::signal::ctrl_c();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = interrupt => {}
                _ = terminate.recv() => {}
            }
            return;
        }
    }
    let _ = interrupt.await;
}
