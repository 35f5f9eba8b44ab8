//! News of a running job, from the threads of the child that does it to the task that writes it down.

use super::child::Advance;
use super::work::Notice;
use crate::app::Step;
use crate::documents::{StartDocument, criterion_name};
use crate::excitation::Progress;
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// State of a running search.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Progress)]
pub struct ProgressDocument {
    /// What is minimised.
    #[schema(example = "condition_number")]
    pub criterion: &'static str,
    /// Value of the criterion at the best trajectory so far; null before the first.
    #[schema(example = 63.1)]
    pub best: Option<f64>,
    pub starts_finished: usize,
    pub starts: usize,
    pub evaluations: u64,
    pub rounds_finished: usize,
    pub elapsed_s: f64,
    /// Random starts that have ended since the news before.
    pub ended: Vec<StartDocument>,
}

/// Where an identification stands.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Step)]
pub struct StepDocument {
    #[schema(example = "reading logs")]
    pub what: &'static str,
    pub done: usize,
    pub of: usize,
}

impl ProgressDocument {
    fn from_progress(p: &Progress, elapsed: Duration) -> Self {
        Self {
            criterion: criterion_name(p.criterion),
            best: p.best.is_finite().then_some(p.best),
            starts_finished: p.starts_finished,
            starts: p.starts,
            evaluations: p.evaluations,
            rounds_finished: p.rounds_finished,
            elapsed_s: elapsed.as_secs_f64(),
            ended: p.start.iter().map(StartDocument::from_report).collect(),
        }
    }
}

/// News in a child since it was last asked for: the last of a search, with all starts that ended, and of an identification.
#[derive(Default)]
pub struct News {
    latest: Mutex<(Option<ProgressDocument>, Option<Value>)>,
    /// By earlier lives of the search.
    before: Advance,
}

impl News {
    /// Of a search that goes on.
    pub fn after(before: Advance) -> Self {
        Self {
            before,
            ..Self::default()
        }
    }

    pub fn tell(&self, notice: Notice, elapsed: Duration) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        match notice {
            Notice::Search(p) => {
                let mut news = ProgressDocument::from_progress(&p, Duration::from_secs_f64(self.before.seconds) + elapsed);
                news.evaluations += self.before.evaluations;
                if let Some(before) = latest.0.take() {
                    news.ended.splice(..0, before.ended);
                }
                latest.0 = Some(news);
            }
            Notice::Step(Step { what, done, of }) => latest.1 = Some(json!(StepDocument { what, done, of })),
            // The end of the work is no news of it.
            Notice::Result(_) => {}
        }
    }

    /// Progress of a search and step of an identification, as documents.
    pub fn take(&self) -> (Option<Value>, Option<Value>) {
        let (search, step) = std::mem::take(&mut *self.latest.lock().unwrap_or_else(PoisonError::into_inner));
        (search.map(|p| json!(p)), step)
    }
}

/// The same in the server: news of children since it was last stored.
#[derive(Default)]
pub struct Latest(Mutex<(Option<Value>, Option<Value>)>);

impl Latest {
    pub fn put(&self, progress: Option<Value>, step: Option<Value>) {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mut news) = progress {
            let before = latest
                .0
                .take()
                .and_then(|mut p| p["ended"].as_array_mut().map(std::mem::take));
            if let (Some(before), Some(ended)) = (before, news["ended"].as_array_mut()) {
                ended.splice(..0, before);
            }
            latest.0 = Some(news);
        }
        latest.1 = step.or(latest.1.take());
    }

    /// Progress of a search and step of an identification.
    pub fn take(&self) -> (Option<Value>, Option<Value>) {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
