//! Asking for jobs: into the queue if there is room, once per key.

use super::audit::{AuditEntry, note};
use super::jobs::JobRow;
use super::{Dialect, Store, Transaction, now_us, unavailable};
use crate::app::{Code, Error};
use crate::service::work::{Class, JobKind};
use sqlx::Row;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct NewJob {
    /// ID of the job.
    pub id: String,
    /// Kind of work.
    pub kind: JobKind,
    /// Queue that the job waits in.
    pub class: Class,
    /// Robot that the job belongs to.
    pub robot: String,
    /// ID of the token that asked for it; empty without tokens.
    pub token: String,
    /// Urgency from 0 (first) to 7 (RFC 9218).
    pub urgency: u8,
    /// Fingerprint of the request: equal requests have equal ones.
    pub fingerprint: String,
    /// File of the request, by SHA-256.
    pub input: String,
    /// Names of its log files.
    pub logs: Vec<String>,
    /// All files that it needs, the input among them.
    pub files: Vec<String>,
}

/// An `Idempotency-Key`, the hash of the body it came with, and the kind of work that was asked for: the same body means another
/// thing at another address.
#[derive(Debug, Clone)]
pub struct Key {
    /// The key as the client chose it.
    pub name: String,
    /// SHA-256 of the body.
    pub body: String,
    /// Kind of work.
    pub kind: JobKind,
}

/// How many of a class may wait: long searches that fill their queue do not keep short jobs out.
#[derive(Debug, Clone, Copy)]
pub struct Waiting {
    /// Jobs of the class that may wait.
    pub in_all: usize,
    /// Jobs of one robot that may wait.
    pub per_robot: usize,
    /// Jobs of one token that may wait.
    pub per_token: usize,
}

/// What became of a request for work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Submission {
    /// The job is new and in the queue.
    Queued,
    /// The key began this job before.
    Known(String),
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
         cancel_requested, created_us, logs) VALUES ($1, $2, $3, $4, $5, $6, 'queued', $7, $8, 1, 0, 0, 0, $9, $10)",
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
    .bind(serde_json::json!(job.logs).to_string())
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
