//! What has to be done now and then: forgetting what is not kept, sweeping files, ending children that nobody needs.

use super::state::Service;
use crate::app::Error;
use std::time::Duration;

/// Files wait an hour before they are swept: looking every ten minutes is often enough.
const PERIOD: Duration = Duration::from_secs(600);

/// Children that a busy time has left are ended, but for one: another is there in some milliseconds.
const REST: Duration = Duration::from_secs(60);

/// Starts the upkeep; needs a running tokio runtime.
pub fn start(service: &Service) {
    tokio::spawn(rest(service.clone()));
    let service = service.clone();
    tokio::spawn(async move {
        while !service.is_closing() {
            if let Err(error) = once(&service).await {
                tracing::warn!(%error, "upkeep failed; it is tried again later");
            }
            tokio::time::sleep(PERIOD).await;
        }
    });
}

async fn rest(service: Service) {
    service.children().warm_up().await;
    while !service.is_closing() {
        tokio::time::sleep(REST).await;
        service.children().rest();
    }
}

async fn once(service: &Service) -> Result<(), Error> {
    if let Some(kept) = service.config().kept_jobs {
        let forgotten = service.store().forget_oldest(kept).await?;
        if forgotten > 0 {
            tracing::info!(jobs = forgotten, "old jobs were forgotten");
        }
    }
    let swept = service.files().sweep().await?;
    if swept > 0 {
        tracing::info!(files = swept, "files that no job needs were removed");
    }
    Ok(())
}
