//! The lease of a running job: news are written down, and it is renewed in time.

use super::{NEWS, in_time};
use crate::app::CancelFlag;
use crate::service::exchange::Link;
use crate::service::progress::Latest;
use crate::service::spread;
use crate::service::state::Service;
use crate::service::store::{Claimed, Dialect};
use std::sync::Arc;
use tokio::time::{Instant, MissedTickBehavior, interval};

/// Keeps a job while it runs.
pub(super) struct Lease<'a> {
    service: &'a Service,
    job: &'a Claimed,
    cancel: &'a CancelFlag,
    pub(super) news: Arc<Latest>,
    /// Of a search that another may go on with.
    pub(super) link: Option<Arc<Link>>,
    renewed: Instant,
    pub(super) cancel_requested: bool,
    pub(super) lost: bool,
}

impl<'a> Lease<'a> {
    pub(super) fn new(service: &'a Service, job: &'a Claimed, cancel: &'a CancelFlag) -> Self {
        Self {
            service,
            job,
            cancel,
            news: Arc::default(),
            link: None,
            renewed: Instant::now(),
            cancel_requested: job.cancel_requested,
            lost: false,
        }
    }

    /// Keeps the job until `work` is done.
    pub(super) async fn kept_while<T>(&mut self, work: impl Future<Output = T>) -> T {
        tokio::pin!(work);
        let mut ticks = interval(NEWS);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                done = &mut work => return done,
                _ = ticks.tick() => self.keep().await,
            }
        }
    }

    /// Writes news down and renews the lease when a third of it is over: two failures may come between.
    pub(super) async fn keep(&mut self) {
        if let Some(link) = self.link.as_ref().filter(|_| !self.lost) {
            link.write(false).await;
        }
        let time = self.service.config().lease;
        let (progress, step) = self.news.take();
        let has_news = progress.is_some() || step.is_some();
        if self.lost || (!has_news && self.renewed.elapsed() < time / 3) {
            return;
        }
        let store = self.service.store();
        let progress = match progress {
            Some(progress) if store.dialect() == Dialect::Postgres => {
                Some(spread::with_shares(self.service, self.job, progress).await)
            }
            own => own,
        };
        let renew = store.renew(&self.job.id, self.job.lease, time, progress.as_ref(), step.as_ref());
        match in_time(time / 3, renew).await {
            Ok(Some(answer)) => {
                self.renewed = Instant::now();
                self.cancel_requested |= answer.cancel_requested;
                if answer.cancel_requested {
                    self.cancel.cancel();
                }
            }
            Ok(None) => {
                tracing::warn!(job = self.job.id, "another worker has this job now");
                self.service.metrics().lost_lease();
                self.lost = true;
                self.cancel.cancel();
            }
            // The work goes on: if nobody else took the job until the database is back, its result counts.
            Err(_) => {}
        }
        if has_news {
            self.service.changed(&self.job.id);
        }
    }
}
