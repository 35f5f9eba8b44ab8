//! What connects the search of a design with its earlier life and with the searches beside it: the table of what they have found.
//!
//! A search writes down the best point of each of its niches, at most every other second, under the lease of its job. Searches
//! take in those of the others when an epoch ends; whoever takes a job over begins with all of them, and with the time that was
//! left. Only searches that are limited by time do so: those limited by evaluations give the same answer in every life.

use super::child::{Latest, Spot};
use super::state::Service;
use super::store::{Dialect, FoundRow, Spent};
use super::worker::in_time;
use serde_json::json;
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::time::Instant;

/// What is found is written down at most this often: what a killed process loses.
const OFTEN: Duration = Duration::from_secs(2);
/// And at least this often, for the time that was spent.
const SELDOM: Duration = Duration::from_secs(10);
/// How long a search that has finished an epoch waits for what others have found: its cores are idle meanwhile.
const LISTENING: Duration = Duration::from_secs(1);

/// The link of one search, whose child tells what it finds.
pub struct Link {
    service: Service,
    job: String,
    lease: i64,
    /// Of the share, 0 for the job itself.
    number: i64,
    started: Instant,
    /// In earlier lives.
    pub before: Spent,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    latest: Option<Latest>,
    written: Option<(Instant, Progress)>,
    /// Versions of what has been taken in, by number of the share.
    seen: HashMap<i64, i64>,
}

/// Changes when there is something worth telling.
type Progress = (usize, f64);

impl Link {
    /// Of the job's own search, with what earlier lives have spent.
    pub async fn of_job(service: &Service, job: &str, lease: i64) -> Result<Self, crate::app::Error> {
        let before = service.store().spent(job).await?.unwrap_or_default();
        Ok(Self::new(service, job, lease, 0, before))
    }

    pub fn of_share(service: &Service, job: &str, lease: i64, number: i64) -> Self {
        Self::new(service, job, lease, number, Spent::default())
    }

    fn new(service: &Service, job: &str, lease: i64, number: i64, before: Spent) -> Self {
        Self {
            service: service.clone(),
            job: job.to_string(),
            lease,
            number,
            started: Instant::now(),
            before,
            state: Mutex::default(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // The state is whole at every moment.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes in what the search has found.
    pub fn found(&self, latest: Latest) {
        self.state().latest = Some(latest);
    }

    /// Writes down what has been found since the last time, if it is time; `now` at once.
    pub async fn write(&self, now: bool) {
        let Some((progress, row)) = self.due(now) else { return };
        let written = self.service.store().write_found(&self.job, self.lease, &row);
        // Without it a later life begins a little earlier.
        if in_time(LISTENING, written).await.is_ok() {
            self.state().written = Some((Instant::now(), progress));
        }
    }

    fn due(&self, now: bool) -> Option<(Progress, FoundRow)> {
        let state = self.state();
        let latest = state.latest.as_ref().filter(|l| l.best.is_finite())?;
        let progress = (latest.epochs, latest.best);
        if let Some((at, before)) = state.written {
            let wait = if before == progress { SELDOM } else { OFTEN };
            if !now && at.elapsed() < wait {
                return None;
            }
        }
        let spent = Spent {
            time: self.before.time + self.started.elapsed(),
            evaluations: self.before.evaluations + latest.evaluations,
        };
        let row = FoundRow {
            number: self.number,
            value: latest.best,
            points: json!(latest.points).to_string(),
            spent,
            version: 0,
        };
        Some((progress, row))
    }

    /// What others have found since it was last asked for.
    pub async fn others(&self) -> Vec<Spot> {
        // On SQLite nobody searches beside this process: only its earlier life has left something.
        let alone = self.service.store().dialect() == Dialect::Sqlite && self.state().latest.is_some();
        if alone {
            return Vec::new();
        }
        let found = in_time(LISTENING, self.service.store().found(&self.job)).await;
        let mut state = self.state();
        let own = |row: &FoundRow| row.number == self.number && state.latest.is_some();
        let rows: Vec<FoundRow> = found.unwrap_or_default().into_iter().filter(|r| !own(r)).collect();
        let mut news = Vec::new();
        for row in rows {
            if state.seen.insert(row.number, row.version) != Some(row.version) {
                news.extend(points(&row.points));
            }
        }
        news
    }
}

/// What cannot be read was written by another version of the program: the search begins without it.
fn points(text: &str) -> Vec<Spot> {
    let all: Vec<serde_json::Value> = serde_json::from_str(text).unwrap_or_default();
    all.into_iter().filter_map(|p| serde_json::from_value(p).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Point;

    #[test]
    fn points_are_read_as_they_were_written() {
        let point = Point {
            x: vec![0.1, -1.0 / 3.0, 5e-324],
            value: 4.05,
            polished: true,
        };
        let point = Spot::from(point);
        let text = json!([point]).to_string();
        assert_eq!(points(&text), [point]);
        assert_eq!((points("{}"), points("[{\"x\": [1]}, 3]")), (vec![], vec![]));
    }
}
