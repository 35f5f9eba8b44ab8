//! What connects the search of a design with its earlier life and with the searches beside it: the table of what they have found.
//!
//! A search writes down the best point of each of its niches, at most every other second, under the lease of its job. Searches take in
//! those of the others when an epoch ends; whoever takes a job over begins with all of them, and with the time that was left. Only
//! searches that are limited by time do so: those limited by evaluations give the same answer in every life.

use super::state::Service;
use super::store::{Dialect, FoundRow, Spent};
use super::worker::in_time;
use crate::app::Exchange;
use crate::excitation::{Found, Point};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::runtime::Handle;
use tokio::time::Instant;

/// What is found is written down at most this often: what a killed process loses.
const OFTEN: Duration = Duration::from_secs(2);
/// And at least this often, for the time that was spent.
const SELDOM: Duration = Duration::from_secs(10);
/// How long a search that has finished an epoch waits for what others have found: its cores are idle meanwhile.
const LISTENING: Duration = Duration::from_secs(1);

/// The link of one search; shared by the threads that search and the task that keeps the lease.
pub struct Link {
    service: Service,
    runtime: Handle,
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

struct Latest {
    progress: Progress,
    points: Vec<Point>,
    evaluations: u64,
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
            runtime: Handle::current(),
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
        let latest = state.latest.as_ref().filter(|l| l.progress.1.is_finite())?;
        if let Some((at, before)) = state.written {
            let wait = if before == latest.progress { SELDOM } else { OFTEN };
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
            value: latest.progress.1,
            points: json!(latest.points.iter().map(document).collect::<Vec<_>>()).to_string(),
            spent,
            version: 0,
        };
        Some((latest.progress, row))
    }

    async fn read(&self) -> Vec<Point> {
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

impl Exchange for Link {
    fn found(&self, found: &Found) {
        let progress = (found.epochs, found.best());
        let mut state = self.state();
        match &mut state.latest {
            Some(latest) if latest.progress == progress => latest.evaluations = found.evaluations,
            _ => {
                state.latest = Some(Latest {
                    progress,
                    points: found.points(),
                    evaluations: found.evaluations,
                });
            }
        }
    }

    fn others(&self) -> Vec<Point> {
        self.runtime.block_on(self.read())
    }
}

fn document(point: &Point) -> Value {
    json!({"x": point.x, "value": point.value, "polished": point.polished})
}

/// What cannot be read was written by another version of the program: the search begins without it.
fn points(text: &str) -> Vec<Point> {
    let read = |p: &Value| {
        let x: Option<Vec<f64>> = p["x"].as_array()?.iter().map(Value::as_f64).collect();
        Some(Point {
            x: x?,
            value: p["value"].as_f64()?,
            polished: p["polished"].as_bool()?,
        })
    };
    let all: Value = serde_json::from_str(text).unwrap_or_default();
    all.as_array().into_iter().flatten().filter_map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_as_they_were_written() {
        let point = Point {
            x: vec![0.1, -1.0 / 3.0, 5e-324],
            value: 4.05,
            polished: true,
        };
        let text = json!([document(&point)]).to_string();
        assert_eq!(points(&text), [point]);
        assert_eq!((points("{}"), points("[{\"x\": [1]}, 3]")), (vec![], vec![]));
    }
}
