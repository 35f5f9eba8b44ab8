//! `dynident serve`, `dynident worker` and `dynident config`.

use super::settings::{Place, Settings};
use super::{Ending, files};
use crate::app::{Code, Error};
use crate::service::{log_to_stderr, serve, work};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    settings: Settings,
}

pub fn run(arguments: &Arguments) -> Result<Ending, Error> {
    let settings = arguments.place.settings(&arguments.settings)?;
    block_on(&settings, listen_and_serve(&settings))
}

/// Does jobs of a shared database.
pub fn run_worker(arguments: &Arguments) -> Result<Ending, Error> {
    let settings = arguments.place.settings(&arguments.settings)?;
    let config = settings.config()?;
    if config.database_url.is_none() {
        let detail = "a worker shares a PostgreSQL database with its server, and no database is given";
        return Err(Error::new(Code::StorageUnavailable, detail)
            .with_hint("set DATABASE_URL; with SQLite the server does all work itself"));
    }
    block_on(&settings, async {
        files::print("working\n")?;
        work(config, interrupted()).await
    })
}

/// Prints the settings and where they come from.
pub fn run_config(arguments: &Arguments) -> Result<Ending, Error> {
    arguments.place.settings(&arguments.settings)?.config()?;
    files::print(&arguments.place.describe(&arguments.settings)?)?;
    Ok(Ending::Done)
}

fn block_on(settings: &Settings, work: impl Future<Output = Result<(), Error>>) -> Result<Ending, Error> {
    log_to_stderr(settings.log_filter(), settings.logs_json());
    let runtime = tokio::runtime::Runtime::new().map_err(|e| Error::new(Code::Internal, format!("cannot start: {e}")))?;
    runtime.block_on(work)?;
    Ok(Ending::Done)
}

async fn listen_and_serve(settings: &Settings) -> Result<(), Error> {
    let config = settings.config()?;
    let asked = settings.address();
    let taken = |e: std::io::Error| {
        Error::new(Code::AddressUnavailable, format!("cannot listen at {asked}: {e}"))
            .with_hint("choose another port with --listen, such as 127.0.0.1:8081")
    };
    let listener = tokio::net::TcpListener::bind(asked).await.map_err(taken)?;
    let address = listener.local_addr().map_err(taken)?;
    files::print(&format!("listening on http://{address}\n"))?;
    serve(listener, config, interrupted()).await
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
