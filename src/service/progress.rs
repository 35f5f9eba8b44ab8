//! News of a running job, from the threads that do it to the one that writes it down.

use super::store::Spent;
use super::work::Told;
use crate::app::Step;
use crate::excitation::Progress;
use crate::io::{StartDocument, criterion_name};
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::{Arc, Mutex, PoisonError};
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
    fn of(p: &Progress, elapsed: Duration) -> Self {
        Self {
            criterion: criterion_name(p.criterion),
            best: p.best.is_finite().then_some(p.best),
            starts_finished: p.starts_finished,
            starts: p.starts,
            evaluations: p.evaluations,
            rounds_finished: p.rounds_finished,
            elapsed_s: elapsed.as_secs_f64(),
            ended: p.start.iter().map(StartDocument::of).collect(),
        }
    }
}

/// The last that was told of a search, with all starts that ended since it was asked for, and of an identification.
type Latest = (Option<ProgressDocument>, Option<Value>);

/// What was told since it was last asked for. Clones share.
#[derive(Clone, Default)]
pub struct News {
    latest: Arc<Mutex<Latest>>,
    /// By earlier lives of the search.
    before: Spent,
}

impl News {
    /// Of a search that goes on.
    pub fn after(before: Spent) -> Self {
        Self {
            before,
            ..Self::default()
        }
    }

    pub fn tell(&self, told: Told, elapsed: Duration) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        match told {
            Told::Search(p) => {
                let mut news = ProgressDocument::of(&p, self.before.time + elapsed);
                news.evaluations += self.before.evaluations;
                if let Some(before) = latest.0.take() {
                    news.ended.splice(..0, before.ended);
                }
                latest.0 = Some(news);
            }
            Told::Step(Step { what, done, of }) => latest.1 = Some(json!(StepDocument { what, done, of })),
        }
    }

    /// Progress of a search and step of an identification, as documents.
    pub fn take(&self) -> (Option<Value>, Option<Value>) {
        let (search, step) = std::mem::take(&mut *self.latest.lock().unwrap_or_else(PoisonError::into_inner));
        (search.map(|p| json!(p)), step)
    }
}
