//! What passes between the server and a child that does a job.

use crate::app::{CancelFlag, Error};
use crate::service::child::{Child, Death, Event, FromChild, ToChild};
use crate::service::exchange::Link;
use crate::service::progress::Latest;
use crate::service::state::Service;
use crate::service::store::{Claimed, Kept};
use crate::service::submit::error_from;
use crate::service::work::JobOutcome;
use crate::service::worker::{HANDING_IN, NEWS, in_time};
use std::sync::OnceLock;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};

/// How often it is looked whether the work is to end.
const LOOK: Duration = Duration::from_millis(50);
/// How long a child that was asked to end may take to hand out its best: a search takes less than a second.
const LAST_GRACE: Duration = Duration::from_secs(5);

/// A job, or a share of one, in the hands of a child.
pub(in super::super) struct Course<'a> {
    pub service: &'a Service,
    pub cancel: &'a CancelFlag,
    pub link: Option<&'a Link>,
    pub news: &'a Latest,
    /// `None` for a share, whose result is not the job's.
    pub job: Option<Keeping<'a>>,
}

/// The job whose result is kept as soon as it is there.
pub(in super::super) struct Keeping<'a> {
    pub claimed: &'a Claimed,
    pub kept: &'a OnceLock<JobOutcome>,
}

/// How the work of a child ended.
pub(in super::super) enum Ending {
    Done(JobOutcome),
    Failed(Error),
    Died(Death),
    /// It was asked to end, and did not.
    Deaf,
}

impl Course<'_> {
    /// Follows a child that has begun until it ends.
    pub(in super::super) async fn follow(&self, child: &mut Child) -> Ending {
        let started = Instant::now();
        let mut most = self.service.config().job_time;
        let (mut asked, mut ticks) = (None, interval(LOOK));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                event = child.event() => match event {
                    Event::Notice(FromChild::Done(outcome)) => return Ending::Done(outcome),
                    Event::Notice(FromChild::Failed(error)) => return Ending::Failed(error_from(&error)),
                    Event::Died(death) => return Ending::Died(death),
                    Event::Notice(FromChild::Begun { search_s, shareable }) => {
                        let search = Duration::try_from_secs_f64(search_s).unwrap_or_default();
                        most = most.saturating_add(search);
                        self.share(shareable, search).await;
                    }
                    Event::Notice(notice) => self.take_in(notice, child).await,
                },
                _ = ticks.tick() => {
                    if started.elapsed() > most {
                        return Ending::Died(Death::TooLong(most));
                    }
                    match asked {
                        Some(at) if Instant::now() > at + LAST_GRACE => return Ending::Deaf,
                        None if self.cancel.is_cancelled() => {
                            child.tell(ToChild::Cancel);
                            asked = Some(Instant::now());
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Lets others search as well.
    async fn share(&self, shareable: bool, time: Duration) {
        if let Some(job) = self.job.as_ref().filter(|_| shareable) {
            // Without it the search is merely not shared.
            let spread = self.service.store().spread(&job.claimed.id, job.claimed.lease, time);
            let _ = in_time(NEWS, spread).await;
        }
    }

    async fn take_in(&self, notice: FromChild, child: &Child) {
        match notice {
            FromChild::News { progress, step } => self.news.put(progress, step),
            FromChild::Found(latest) => {
                if let Some(link) = self.link {
                    link.found(latest);
                }
            }
            FromChild::AskOthers => {
                let others = match self.link {
                    Some(link) => link.others().await,
                    None => Vec::new(),
                };
                child.tell(ToChild::Others(others));
            }
            FromChild::Result(outcome) => self.keep(outcome).await,
            // No answer to a job.
            FromChild::Begun { .. } | FromChild::Done(_) | FromChild::Answer(_) | FromChild::Failed(_) => {}
        }
    }

    /// Stores a result while the child goes on to what is made for pictures.
    async fn keep(&self, outcome: JobOutcome) {
        let Some(job) = &self.job else { return };
        let storing = async {
            let files = self.service.files();
            let model = match &outcome.model {
                Some(model) => Some(files.put(model).await?),
                None => None,
            };
            let kept = Kept {
                outcome: Some(outcome.status.clone()),
                result: files.put(&outcome.document).await?,
                model,
            };
            self.service
                .store()
                .keep_result(&job.claimed.id, job.claimed.lease, &kept)
                .await
        };
        if let Err(error) = in_time(HANDING_IN, storing).await {
            // It is tried again with the whole.
            tracing::warn!(job = job.claimed.id, %error, "a result is not stored before its predictions");
        }
        let _ = job.kept.set(outcome);
    }
}
