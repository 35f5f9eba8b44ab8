//! Jobs as their rows say: looking at them, cancelling and forgetting them.

use super::{Store, now_us, unavailable};
use crate::app::Error;
use crate::service::work::JobKind;
use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;

/// A job as its row says.
#[derive(Debug, Clone)]
pub struct JobRow {
    /// ID of the job.
    pub id: String,
    /// Kind of work.
    pub kind: JobKind,
    /// Robot that the job belongs to.
    pub robot: String,
    /// State of the job.
    pub state: State,
    /// Sequence number of the last news, which is the ID of the event.
    pub sequence: i64,
    /// Whether a cancellation was requested.
    pub cancel_requested: bool,
    /// Time of submission, microseconds since 1970 (UTC).
    pub created_us: i64,
    /// Time of the first claim (µs); nothing while it is queued.
    pub started_us: Option<i64>,
    /// Time of its end (µs); nothing until then.
    pub finished_us: Option<i64>,
    /// How the computation ended, such as `Converged`.
    pub outcome: Option<String>,
    /// Latest progress of a search.
    pub progress: Option<Value>,
    /// Latest step of an identification.
    pub step: Option<Value>,
    /// A stored error.
    pub error: Option<Value>,
    /// Files.
    pub input: Option<String>,
    /// File of the result, by SHA-256.
    pub result: Option<String>,
    /// File of the identified model, by SHA-256.
    pub model: Option<String>,
    /// What people call it, and what they write about it.
    pub name: Option<String>,
    /// Free text about the job.
    pub note: Option<String>,
    /// Name of the token that asked for it.
    pub owner: Option<String>,
    /// Names of its log files: those to identify from, then those to validate with.
    pub logs: Vec<String>,
}

/// Which jobs are listed; nothing is no condition.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Robot of the job.
    pub robot: Option<String>,
    /// Kind of work.
    pub kind: Option<JobKind>,
    /// State of the job.
    pub state: Option<State>,
    /// Part of the name, the note, the robot, the id or the name of a log, in whatever case.
    pub search: Option<String>,
}

impl JobFilter {
    /// Conditions with places from `$first` on, and what is put there.
    fn conditions(&self, first: usize) -> (String, Vec<String>) {
        let (mut sql, mut values) = (String::new(), Vec::new());
        let mut equal = |column: &str, value: Option<&str>| {
            if let Some(value) = value {
                sql.push_str(&format!(" AND {column} = ${}", first + values.len()));
                values.push(value.to_string());
            }
        };
        equal("robot", self.robot.as_deref());
        equal("kind", self.kind.map(JobKind::name));
        equal("state", self.state.map(State::name));
        if let Some(text) = &self.search {
            let place = first + values.len();
            let like = |column: &str| format!("LOWER(COALESCE({column}, '')) LIKE ${place} ESCAPE '!'");
            sql.push_str(&format!(
                " AND ({})",
                ["name", "note", "robot", "id", "logs"].map(like).join(" OR ")
            ));
            values.push(format!("%{}%", escaped(&text.to_lowercase())));
        }
        (sql, values)
    }
}

/// Text in a pattern of LIKE stands for itself.
fn escaped(text: &str) -> String {
    text.replace('!', "!!").replace('%', "!%").replace('_', "!_")
}

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Waits for a worker.
    Queued,
    /// A worker has it.
    Running,
    /// Ended with a result.
    Finished,
    /// Ended on request; with the best result found if it had begun.
    Cancelled,
    /// Ended with an error.
    Failed,
}

impl State {
    /// Every state.
    pub const ALL: [State; 5] = [
        State::Queued,
        State::Running,
        State::Finished,
        State::Cancelled,
        State::Failed,
    ];

    /// Name in the database and in documents.
    pub fn name(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Finished => "finished",
            State::Cancelled => "cancelled",
            State::Failed => "failed",
        }
    }

    /// Whether the state never changes again.
    pub fn is_final(self) -> bool {
        matches!(self, State::Finished | State::Cancelled | State::Failed)
    }
}

/// A place in the list of jobs, the newest first: behind the job of this time and id. Jobs of the same microsecond stand in the
/// order of their ids.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobPlace {
    /// Time of submission (µs).
    pub created_us: i64,
    /// ID of the job, which decides between equal times.
    pub id: String,
}

impl JobPlace {
    /// Before all jobs.
    pub fn first() -> Self {
        Self {
            created_us: i64::MAX,
            id: String::new(),
        }
    }

    /// The place right after a job in the list.
    pub fn behind(job: &JobRow) -> Self {
        Self {
            created_us: job.created_us,
            id: job.id.clone(),
        }
    }

    /// `TIME.ID`, or `TIME` alone for what is older than that microsecond.
    pub fn read(text: &str) -> Option<Self> {
        let (time, id) = text.split_once('.').unwrap_or((text, ""));
        let is_id = id.len() <= 64 && id.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
        let created_us = time.parse().ok().filter(|t: &i64| *t >= 0)?;
        is_id.then(|| Self {
            created_us,
            id: id.to_string(),
        })
    }
}

impl std::fmt::Display for JobPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.created_us, self.id)
    }
}

const COLUMNS: &str = "id, kind, robot, state, sequence, cancel_requested, created_us, started_us, finished_us, outcome, progress, step, \
     error, input, result, model, name, note, logs, (SELECT t.name FROM tokens t WHERE t.id = jobs.token) AS owner";

impl JobRow {
    fn read(row: &AnyRow) -> Result<Self, Error> {
        let read = || -> Result<Self, sqlx::Error> {
            let text = |name: &str| row.try_get::<Option<String>, _>(name);
            let json = |name: &str| Ok::<_, sqlx::Error>(text(name)?.and_then(|t| serde_json::from_str(&t).ok()));
            let (kind, state): (String, String) = (row.try_get("kind")?, row.try_get("state")?);
            let unknown = |what: &str| sqlx::Error::Decode(format!("`{what}` is not known to this version").into());
            Ok(Self {
                id: row.try_get("id")?,
                kind: JobKind::named(&kind).ok_or_else(|| unknown(&kind))?,
                robot: row.try_get("robot")?,
                state: State::ALL
                    .into_iter()
                    .find(|s| s.name() == state)
                    .ok_or_else(|| unknown(&state))?,
                sequence: row.try_get("sequence")?,
                cancel_requested: row.try_get::<i64, _>("cancel_requested")? != 0,
                created_us: row.try_get("created_us")?,
                started_us: row.try_get("started_us")?,
                finished_us: row.try_get("finished_us")?,
                outcome: text("outcome")?,
                progress: json("progress")?,
                step: json("step")?,
                error: json("error")?,
                input: text("input")?,
                result: text("result")?,
                model: text("model")?,
                name: text("name")?,
                note: text("note")?,
                owner: text("owner")?.filter(|name| !name.is_empty()),
                logs: text("logs")?.and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default(),
            })
        };
        read().map_err(unavailable)
    }
}

impl Store {
    /// The job of this ID; nothing if there is none.
    pub async fn job(&self, id: &str) -> Result<Option<JobRow>, Error> {
        let sql = self.sql(&format!("SELECT {COLUMNS} FROM jobs WHERE id = $1"));
        let row = sqlx::query(sql)
            .bind(id)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.as_ref().map(JobRow::read).transpose()
    }

    /// The newest `most` jobs behind `place` that `filter` takes and `robots` names (all if it is `None`).
    pub async fn jobs(
        &self,
        robots: Option<&[String]>,
        filter: &JobFilter,
        place: &JobPlace,
        most: usize,
    ) -> Result<Vec<JobRow>, Error> {
        let names = robots.unwrap_or_default();
        let places: Vec<String> = (0..names.len()).map(|i| format!("${}", i + 4)).collect();
        let of_robots = match robots {
            None => String::new(),
            Some([]) => "AND 1 = 0".to_string(),
            Some(_) => format!("AND robot IN ({})", places.join(", ")),
        };
        let (conditions, values) = filter.conditions(names.len() + 4);
        let sql = self.sql(&format!(
            "SELECT {COLUMNS} FROM jobs WHERE (created_us < $1 OR (created_us = $1 AND id < $2)) {of_robots} {conditions} \
             ORDER BY created_us DESC, id DESC LIMIT $3"
        ));
        let mut query = sqlx::query(sql).bind(place.created_us).bind(&place.id).bind(most as i64);
        for name in names.iter().chain(&values) {
            query = query.bind(name);
        }
        let rows = query.fetch_all(&self.pool).await.map_err(unavailable)?;
        rows.iter().map(JobRow::read).collect()
    }

    /// The newest finished job that did exactly this work and is seen by those who see `robot`.
    pub async fn finished_before(&self, robot: &str, fingerprint: &str) -> Result<Option<JobRow>, Error> {
        let sql = self.sql(&format!(
            "SELECT {COLUMNS} FROM jobs WHERE fingerprint = $1 AND robot = $2 AND state = 'finished' ORDER BY created_us DESC LIMIT 1"
        ));
        let row = sqlx::query(sql)
            .bind(fingerprint)
            .bind(robot)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.as_ref().map(JobRow::read).transpose()
    }

    /// Ends a waiting job, and asks a running one to end; one that was put back has something to hand out first.
    pub async fn cancel(&self, id: &str) -> Result<(), Error> {
        let at_once = "state = 'queued' AND NOT EXISTS (SELECT 1 FROM found f WHERE f.job = jobs.id)";
        let sql = self.sql(&format!(
            "UPDATE jobs SET cancel_requested = 1, sequence = sequence + 1, \
             finished_us = CASE WHEN {at_once} THEN $2 ELSE finished_us END, \
             state = CASE WHEN {at_once} THEN 'cancelled' ELSE state END \
             WHERE id = $1 AND state IN ('queued', 'running')"
        ));
        let done = sqlx::query(sql).bind(id).bind(now_us()).execute(&self.pool).await;
        done.map(drop).map_err(unavailable)
    }

    /// Names a job, and writes about it; `None` leaves what there is, an empty text takes it away.
    pub async fn describe_job(&self, id: &str, name: Option<&str>, note: Option<&str>) -> Result<(), Error> {
        let sql = "UPDATE jobs SET name = CASE WHEN $2 IS NULL THEN name ELSE NULLIF($2, '') END, \
             note = CASE WHEN $3 IS NULL THEN note ELSE NULLIF($3, '') END WHERE id = $1";
        let done = sqlx::query(sql).bind(id).bind(name).bind(note).execute(&self.pool).await;
        done.map(drop).map_err(unavailable)
    }

    /// Forgets an ended job with its result; whether there was one.
    pub async fn forget_job(&self, id: &str) -> Result<bool, Error> {
        let sql = "DELETE FROM jobs WHERE id = $1 AND state IN ('finished', 'cancelled', 'failed')";
        let done = sqlx::query(sql).bind(id).execute(&self.pool).await;
        done.map(|d| d.rows_affected() > 0).map_err(unavailable)
    }

    /// Forgets all but the newest `kept` ended jobs.
    pub async fn forget_oldest(&self, kept: usize) -> Result<u64, Error> {
        let sql = "DELETE FROM jobs WHERE id IN (SELECT id FROM jobs WHERE state IN ('finished', 'cancelled', 'failed') \
             ORDER BY created_us DESC LIMIT $2 OFFSET $1)";
        let done = sqlx::query(sql).bind(kept as i64).bind(i64::MAX).execute(&self.pool).await;
        done.map(|d| d.rows_affected()).map_err(unavailable)
    }

    /// How many jobs are in each state and class, for metrics.
    pub async fn counts(&self) -> Result<Vec<(String, String, i64)>, Error> {
        let rows = sqlx::query("SELECT state, class, COUNT(*) AS jobs FROM jobs GROUP BY state, class")
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        let read = |row: &AnyRow| Ok::<_, sqlx::Error>((row.try_get("state")?, row.try_get("class")?, row.try_get("jobs")?));
        rows.iter().map(|row| read(row).map_err(unavailable)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_stand_for_themselves() {
        assert_eq!(JobFilter::default().conditions(4), (String::new(), vec![]));
        let filter = JobFilter {
            kind: Some(JobKind::Identification),
            search: Some("50%_A!".into()),
            ..JobFilter::default()
        };
        let (sql, values) = filter.conditions(6);
        assert!(
            sql.starts_with(" AND kind = $6 AND (LOWER(COALESCE(name, '')) LIKE $7 ESCAPE '!' OR "),
            "{sql}"
        );
        assert_eq!(values, ["identification", "%50!%!_a!!%"]);
    }
}
