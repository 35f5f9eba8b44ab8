//! What has to be done now and then: forgetting what is not kept, sweeping files, handing back memory.

use super::state::Service;
use crate::app::{Error, hand_back_memory};
use std::time::Duration;

/// Files wait an hour before they are swept: looking every ten minutes is often enough.
const PERIOD: Duration = Duration::from_secs(600);

/// What the jobs of a minute have left is handed back: fetching it again takes some milliseconds of the next minute.
const MEMORY: Duration = Duration::from_secs(60);

/// Starts the upkeep; needs a running tokio runtime.
pub fn start(service: &Service) {
    tokio::spawn(hand_back(service.clone()));
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

async fn hand_back(service: Service) {
    while !service.is_closing() {
        tokio::time::sleep(MEMORY).await;
        let _ = tokio::task::spawn_blocking(hand_back_memory).await;
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
