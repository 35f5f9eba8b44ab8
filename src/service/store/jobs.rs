//! Jobs: asking for them, looking at them, cancelling and forgetting them.

use super::audit::{AuditEntry, note};
use super::{Dialect, Store, Transaction, now_us, unavailable};
use crate::app::{Code, Error};
use crate::service::work::{Class, Kind};
use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;

/// A job as its row says.
#[derive(Debug, Clone)]
pub struct JobRow {
    pub id: String,
    pub kind: Kind,
    pub robot: String,
    pub state: State,
    pub sequence: i64,
    pub cancel_requested: bool,
    pub created_us: i64,
    pub started_us: Option<i64>,
    pub finished_us: Option<i64>,
    pub outcome: Option<String>,
    pub progress: Option<Value>,
    pub step: Option<Value>,
    /// A stored error.
    pub error: Option<Value>,
    /// Files.
    pub input: Option<String>,
    pub result: Option<String>,
    pub model: Option<String>,
}

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    Queued,
    Running,
    Finished,
    /// Ended on request; with the best result found if it had begun.
    Cancelled,
    Failed,
}

impl State {
    pub const ALL: [State; 5] = [
        State::Queued,
        State::Running,
        State::Finished,
        State::Cancelled,
        State::Failed,
    ];

    pub fn name(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Finished => "finished",
            State::Cancelled => "cancelled",
            State::Failed => "failed",
        }
    }

    pub fn is_final(self) -> bool {
        matches!(self, State::Finished | State::Cancelled | State::Failed)
    }
}

/// What is asked for.
#[derive(Debug, Clone)]
pub struct NewJob {
    pub id: String,
    pub kind: Kind,
    pub class: Class,
    pub robot: String,
    pub token: String,
    pub urgency: u8,
    pub fingerprint: String,
    pub input: String,
    /// All files that it needs, the input among them.
    pub files: Vec<String>,
}

/// An `Idempotency-Key`, the hash of the body it came with, and the kind of work that was asked for: the same body means another thing
/// at another address.
#[derive(Debug, Clone)]
pub struct Key {
    pub name: String,
    pub body: String,
    pub kind: Kind,
}

/// How many of a class may wait: long searches that fill their queue do not keep short jobs out.
#[derive(Debug, Clone, Copy)]
pub struct Waiting {
    pub in_all: usize,
    pub per_robot: usize,
    pub per_token: usize,
}

/// A place in the list of jobs, the newest first: behind the job of this time and id. Jobs of the same microsecond stand in the order of their ids.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobPlace {
    pub created_us: i64,
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

/// What became of a request for work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Submission {
    Queued,
    /// The key began this job before.
    Known(String),
}

const COLUMNS: &str = "id, kind, robot, state, sequence, cancel_requested, created_us, started_us, finished_us, outcome, progress, step, \
     error, input, result, model";

impl JobRow {
    fn read(row: &AnyRow) -> Result<Self, Error> {
        let read = || -> Result<Self, sqlx::Error> {
            let text = |name: &str| row.try_get::<Option<String>, _>(name);
            let json = |name: &str| Ok::<_, sqlx::Error>(text(name)?.and_then(|t| serde_json::from_str(&t).ok()));
            let (kind, state): (String, String) = (row.try_get("kind")?, row.try_get("state")?);
            let unknown = |what: &str| sqlx::Error::Decode(format!("`{what}` is not known to this version").into());
            Ok(Self {
                id: row.try_get("id")?,
                kind: Kind::named(&kind).ok_or_else(|| unknown(&kind))?,
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
            })
        };
        read().map_err(unavailable)
    }
}

impl Store {
    /// Puts a job into the queue. When this returns, the job is on the disk: it will be done whatever happens to this process.
    ///
    /// # Errors
    /// Too many wait already; the key came with another body, or for other work, before.
    pub async fn submit(&self, job: &NewJob, key: Option<&Key>, most: Waiting, entry: &AuditEntry) -> Result<Submission, Error> {
        let mut transaction = self.begin().await?;
        if let Some(key) = key
            && let Some(id) = known(&mut transaction, &job.token, key).await?
        {
            return Ok(Submission::Known(id));
        }
        self.check_room(&mut transaction, job, most).await?;
        insert(&mut transaction, job).await?;
        if let Some(key) = key {
            let kept = sqlx::query(
                "INSERT INTO idempotency_keys (scope, name, body, job) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING",
            )
            .bind(&job.token)
            .bind(&key.name)
            .bind(&key.body)
            .bind(&job.id)
            .execute(&mut *transaction)
            .await
            .map_err(unavailable)?;
            if kept.rows_affected() == 0 {
                // Another request with this key was faster and has committed by now.
                transaction.rollback().await.map_err(unavailable)?;
                let mut again = self.begin().await?;
                let id = known(&mut again, &job.token, key).await?;
                return id.map(Submission::Known).ok_or_else(|| unavailable(sqlx::Error::RowNotFound));
            }
        }
        note(&mut transaction, entry).await?;
        transaction.commit().await.map_err(unavailable)?;
        Ok(Submission::Queued)
    }

    /// The job that a key began.
    ///
    /// # Errors
    /// The key came with another body, or for other work.
    pub async fn begun_with(&self, scope: &str, key: &Key) -> Result<Option<JobRow>, Error> {
        let mut transaction = self.pool.begin().await.map_err(unavailable)?;
        let id = known(&mut transaction, scope, key).await?;
        drop(transaction);
        match id {
            Some(id) => self.job(&id).await,
            None => Ok(None),
        }
    }

    async fn check_room(&self, transaction: &mut Transaction, job: &NewJob, most: Waiting) -> Result<(), Error> {
        if self.dialect == Dialect::Postgres {
            // Two who count at the same time would both find room for one.
            sqlx::query("SELECT pg_advisory_xact_lock(4711001)")
                .execute(&mut **transaction)
                .await
                .map_err(unavailable)?;
        }
        let row = sqlx::query(
            "SELECT COUNT(*) AS in_all, COUNT(CASE WHEN robot = $1 THEN 1 END) AS of_robot, \
             COUNT(CASE WHEN token = $2 THEN 1 END) AS of_token FROM jobs WHERE state = 'queued' AND class = $3",
        )
        .bind(&job.robot)
        .bind(&job.token)
        .bind(job.class.name())
        .fetch_one(&mut **transaction)
        .await
        .map_err(unavailable)?;
        let count = |name: &str| row.try_get::<i64, _>(name).map(|n| n as usize).map_err(unavailable);
        if count("in_all")? >= most.in_all {
            return Err(Error::new(
                Code::TooManyJobs,
                format!("too many {} jobs are waiting already", job.class.name()),
            ));
        }
        if count("of_robot")? >= most.per_robot {
            let detail = format!(
                "{} {} jobs of the robot `{}` are waiting already",
                most.per_robot,
                job.class.name(),
                job.robot
            );
            return Err(Error::new(Code::LimitReached, detail));
        }
        if !job.token.is_empty() && count("of_token")? >= most.per_token {
            let detail = format!(
                "{} {} jobs of this token are waiting already",
                most.per_token,
                job.class.name()
            );
            return Err(Error::new(Code::LimitReached, detail));
        }
        Ok(())
    }

    pub async fn job(&self, id: &str) -> Result<Option<JobRow>, Error> {
        let sql = self.sql(&format!("SELECT {COLUMNS} FROM jobs WHERE id = $1"));
        let row = sqlx::query(sql)
            .bind(id)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.as_ref().map(JobRow::read).transpose()
    }

    /// The newest `most` jobs behind `place` that `robots` names (all if it is `None`).
    pub async fn jobs(&self, robots: Option<&[String]>, place: &JobPlace, most: usize) -> Result<Vec<JobRow>, Error> {
        let names = robots.unwrap_or_default();
        let places: Vec<String> = (0..names.len()).map(|i| format!("${}", i + 4)).collect();
        let of_robots = match robots {
            None => String::new(),
            Some([]) => "AND 1 = 0".to_string(),
            Some(_) => format!("AND robot IN ({})", places.join(", ")),
        };
        let sql = self.sql(&format!(
            "SELECT {COLUMNS} FROM jobs WHERE (created_us < $1 OR (created_us = $1 AND id < $2)) {of_robots} \
             ORDER BY created_us DESC, id DESC LIMIT $3"
        ));
        let mut query = sqlx::query(sql).bind(place.created_us).bind(&place.id).bind(most as i64);
        for name in names {
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

/// The job that a key began.
async fn known(transaction: &mut Transaction, scope: &str, key: &Key) -> Result<Option<String>, Error> {
    // The kind stands with the job, which is forgotten together with its key.
    let row = sqlx::query(
        "SELECT k.body, k.job, j.kind FROM idempotency_keys k JOIN jobs j ON j.id = k.job WHERE k.scope = $1 AND k.name = $2",
    )
    .bind(scope)
    .bind(&key.name)
    .fetch_optional(&mut **transaction)
    .await
    .map_err(unavailable)?;
    let Some(row) = row else { return Ok(None) };
    let text = |name: &str| row.try_get::<String, _>(name).map_err(unavailable);
    let (body, job, kind) = (text("body")?, text("job")?, text("kind")?);
    let reused = |before: &str| {
        let detail = format!("the key `{}` came {before} before", key.name);
        Error::new(Code::IdempotencyKeyReused, detail)
            .with_hint("send a new key with every new request; only a retry has that of the first try")
    };
    if kind != key.kind.name() {
        return Err(reused(&format!("with a request for another kind of work ({kind})")));
    }
    match body == key.body {
        true => Ok(Some(job)),
        false => Err(reused("with another document")),
    }
}

async fn insert(transaction: &mut Transaction, job: &NewJob) -> Result<(), Error> {
    sqlx::query(
        "INSERT INTO jobs (id, kind, class, robot, token, urgency, state, fingerprint, input, sequence, lease, attempts, \
         cancel_requested, created_us) VALUES ($1, $2, $3, $4, $5, $6, 'queued', $7, $8, 1, 0, 0, 0, $9)",
    )
    .bind(&job.id)
    .bind(job.kind.name())
    .bind(job.class.name())
    .bind(&job.robot)
    .bind(&job.token)
    .bind(i64::from(job.urgency))
    .bind(&job.fingerprint)
    .bind(&job.input)
    .bind(now_us())
    .execute(&mut **transaction)
    .await
    .map_err(unavailable)?;
    for hash in &job.files {
        name_file(transaction, &job.id, hash).await?;
    }
    Ok(())
}

/// Notes that a job needs a file.
pub(super) async fn name_file(transaction: &mut Transaction, job: &str, hash: &str) -> Result<(), Error> {
    let done = sqlx::query("INSERT INTO job_files (job, hash) VALUES ($1, $2) ON CONFLICT DO NOTHING")
        .bind(job)
        .bind(hash)
        .execute(&mut **transaction)
        .await;
    done.map(drop).map_err(unavailable)
}
