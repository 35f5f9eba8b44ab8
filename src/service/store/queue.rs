//! The queue: claiming, keeping and ending jobs under leases.
//!
//! A worker claims a job by raising its lease number and must renew the lease before it runs out; a job whose lease has run out
//! is claimed again by whoever comes first. Everything a worker writes names the number it was given: a worker that was presumed
//! dead and comes back finds its number outdated and changes nothing, so that every job has exactly one result.

use super::{Dialect, Store, Transaction, now_us, submission::name_file, unavailable};
use crate::app::Error;
use crate::service::store::jobs::State;
use crate::service::work::{Class, JobKind};
use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;
use std::time::Duration;

/// A job in the hands of this worker.
#[derive(Debug, Clone)]
pub struct Claimed {
    /// ID of the job.
    pub id: String,
    /// Kind of work.
    pub kind: JobKind,
    /// Robot that the job belongs to.
    pub robot: String,
    /// File of the request, by SHA-256.
    pub input: String,
    /// Number of the lease; everything the worker writes names it.
    pub lease: i64,
    /// Whether a cancellation was requested.
    pub cancel_requested: bool,
    /// Time of submission (µs).
    pub created_us: i64,
    /// Of an earlier life that did not come to its end.
    pub kept: Option<Kept>,
}

/// A result that is stored and may still get its predictions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// How the computation ended, such as `Converged`.
    pub outcome: Option<String>,
    /// Files.
    pub result: String,
    /// File of the identified model, by SHA-256; nothing if there is none.
    pub model: Option<String>,
}

/// What a worker learns when it renews its lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Renewed {
    /// Whether a cancellation was requested.
    pub cancel_requested: bool,
}

/// How a job ended.
#[derive(Debug, Clone)]
pub struct Ended {
    /// Final state.
    pub state: State,
    /// How the computation ended; nothing without a result.
    pub outcome: Option<String>,
    /// File of the result, by SHA-256.
    pub result: Option<String>,
    /// File of the identified model, by SHA-256.
    pub model: Option<String>,
    /// The error of a failed job.
    pub error: Option<Value>,
}

/// One step of urgency is worth this much waiting (µs): urgent jobs go first, and no job waits for ever behind them.
const STEP_OF_URGENCY: i64 = 60_000_000;

/// Of a job `j`: nobody has it, and its robot does not run as many as it may; $1 is the class, $2 the bound.
const CLAIMABLE: &str = "j.class = $1 AND (j.state = 'queued' OR (j.state = 'running' AND j.lease_until_us < {now})) \
     AND (SELECT COUNT(*) FROM jobs r WHERE r.robot = j.robot AND r.class = j.class AND r.state = 'running' \
          AND r.lease_until_us >= {now}) < $2";

fn bound(most_of_robot: Option<usize>) -> i64 {
    most_of_robot.map_or(i64::MAX, |n| n as i64)
}

impl Store {
    /// Takes the next job of a class, if there is one.
    ///
    /// Robots take turns: the key of a job is the time since which it, and its robot, have been waiting, later by a minute for
    /// every step of urgency. A robot that was just served counts as if its jobs had come just now.
    pub async fn claim(
        &self,
        class: Class,
        worker: &str,
        lease: Duration,
        most_of_robot: Option<usize>,
    ) -> Result<Option<Claimed>, Error> {
        if !self.may_claim(class, most_of_robot).await? {
            return Ok(None);
        }
        let mut transaction = self.begin().await?;
        if self.dialect == Dialect::Postgres {
            // Two who count a robot's running jobs at the same time would both find room for one.
            sqlx::query("SELECT pg_advisory_xact_lock(4711002)")
                .execute(&mut *transaction)
                .await
                .map_err(unavailable)?;
        }
        let sql = format!(
            "UPDATE jobs SET state = 'running', lease = lease + 1, lease_until_us = {{now}} + $3, worker = $5, spread_until_us = NULL, \
             attempts = attempts + 1, started_us = COALESCE(started_us, $4), sequence = sequence + 1 \
             WHERE id = (SELECT j.id FROM jobs j WHERE {CLAIMABLE} \
               ORDER BY j.urgency * {STEP_OF_URGENCY} + (SELECT MAX(t.at) FROM (SELECT j.created_us AS at UNION ALL \
                    SELECT MAX(r.started_us) FROM jobs r WHERE r.robot = j.robot AND r.class = j.class) t), \
                 j.urgency * {STEP_OF_URGENCY} + j.created_us, j.id \
               LIMIT 1 {{skip}}) \
             RETURNING id, kind, robot, input, lease, cancel_requested, created_us, outcome, result, model"
        );
        let rows = sqlx::query(self.sql(&sql))
            .bind(class.name())
            .bind(bound(most_of_robot))
            .bind(lease.as_micros() as i64)
            .bind(now_us())
            .bind(worker)
            .fetch_all(&mut *transaction)
            .await
            .map_err(unavailable)?;
        transaction.commit().await.map_err(unavailable)?;
        rows.first().map(|row| claimed(row).map_err(unavailable)).transpose()
    }

    /// Looks without taking the writer's place.
    pub async fn may_claim(&self, class: Class, most_of_robot: Option<usize>) -> Result<bool, Error> {
        let sql = self.sql(&format!("SELECT 1 AS one FROM jobs j WHERE {CLAIMABLE} LIMIT 1"));
        let row = sqlx::query(sql)
            .bind(class.name())
            .bind(bound(most_of_robot))
            .fetch_optional(&self.pool)
            .await;
        row.map(|r| r.is_some()).map_err(unavailable)
    }

    /// Keeps a job and tells where it stands; `None` if it is no longer this worker's.
    pub async fn renew(
        &self,
        id: &str,
        lease: i64,
        time: Duration,
        progress: Option<&Value>,
        step: Option<&Value>,
    ) -> Result<Option<Renewed>, Error> {
        let sql = self.sql(
            "UPDATE jobs SET lease_until_us = {now} + $3, progress = COALESCE($4, progress), step = COALESCE($5, step), \
             sequence = sequence + CASE WHEN COALESCE($4, $5) IS NULL THEN 0 ELSE 1 END \
             WHERE id = $1 AND lease = $2 AND state = 'running' RETURNING cancel_requested",
        );
        let rows = sqlx::query(sql)
            .bind(id)
            .bind(lease)
            .bind(time.as_micros() as i64)
            .bind(progress.map(Value::to_string))
            .bind(step.map(Value::to_string))
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        let read = |row: &AnyRow| row.try_get::<i64, _>("cancel_requested").map_err(unavailable);
        let cancel_requested = rows.first().map(read).transpose()?;
        Ok(cancel_requested.map(|c| Renewed {
            cancel_requested: c != 0,
        }))
    }

    /// Counts a death of the process that does the job, and hands back how many there were; `None` if the job is no longer this
    /// worker's.
    pub async fn child_died(&self, id: &str, lease: i64) -> Result<Option<i64>, Error> {
        let rows = sqlx::query(
            "UPDATE jobs SET child_deaths = child_deaths + 1 WHERE id = $1 AND lease = $2 AND state = 'running' RETURNING child_deaths",
        )
        .bind(id)
        .bind(lease)
        .fetch_all(&self.pool)
        .await
        .map_err(unavailable)?;
        let read = |row: &AnyRow| row.try_get("child_deaths").map_err(unavailable);
        rows.first().map(read).transpose()
    }

    /// Stores the result of a job that goes on: whatever becomes of the rest, it has this.
    pub async fn keep_result(&self, id: &str, lease: i64, kept: &Kept) -> Result<(), Error> {
        let mut transaction = self.begin().await?;
        forget_result(&mut transaction, id, lease).await?;
        let done = sqlx::query(
            "UPDATE jobs SET outcome = $3, result = $4, model = $5 WHERE id = $1 AND lease = $2 AND state = 'running'",
        )
        .bind(id)
        .bind(lease)
        .bind(kept.outcome.clone())
        .bind(kept.result.clone())
        .bind(kept.model.clone())
        .execute(&mut *transaction)
        .await
        .map_err(unavailable)?;
        if done.rows_affected() == 1 {
            for hash in [Some(&kept.result), kept.model.as_ref()].into_iter().flatten() {
                name_file(&mut transaction, id, hash).await?;
            }
        }
        transaction.commit().await.map_err(unavailable)
    }

    /// Ends a job; `false` if it is no longer this worker's, and then nothing has changed.
    pub async fn finish(&self, id: &str, lease: i64, ended: &Ended) -> Result<bool, Error> {
        let mut transaction = self.begin().await?;
        forget_result(&mut transaction, id, lease).await?;
        let done = sqlx::query(
            "UPDATE jobs SET state = $3, outcome = $4, result = $5, model = $6, error = $7, finished_us = $8, \
             lease_until_us = NULL, sequence = sequence + 1 WHERE id = $1 AND lease = $2 AND state = 'running'",
        )
        .bind(id)
        .bind(lease)
        .bind(ended.state.name())
        .bind(ended.outcome.clone())
        .bind(ended.result.clone())
        .bind(ended.model.clone())
        .bind(ended.error.as_ref().map(Value::to_string))
        .bind(now_us())
        .execute(&mut *transaction)
        .await
        .map_err(unavailable)?;
        if done.rows_affected() == 0 {
            return Ok(false);
        }
        for hash in [&ended.result, &ended.model].into_iter().flatten() {
            name_file(&mut transaction, id, hash).await?;
        }
        for sql in ["DELETE FROM shares WHERE job = $1", "DELETE FROM found WHERE job = $1"] {
            let done = sqlx::query(sql).bind(id).execute(&mut *transaction).await;
            done.map_err(unavailable)?;
        }
        transaction.commit().await.map_err(unavailable)?;
        Ok(true)
    }

    /// Puts a job back into the queue, to be done by another.
    pub async fn release(&self, id: &str, lease: i64) -> Result<(), Error> {
        let done = sqlx::query(
            "UPDATE jobs SET state = 'queued', lease_until_us = NULL, worker = NULL, sequence = sequence + 1, attempts = attempts - 1 \
             WHERE id = $1 AND lease = $2 AND state = 'running'",
        )
        .bind(id)
        .bind(lease)
        .execute(&self.pool)
        .await;
        done.map(drop).map_err(unavailable)
    }

    /// Puts back what a worker of this name held: for its next life, when the last one is known to be over.
    pub async fn release_all_of(&self, worker: &str) -> Result<u64, Error> {
        let done = sqlx::query(
            "UPDATE jobs SET state = 'queued', lease_until_us = NULL, worker = NULL, sequence = sequence + 1 \
             WHERE worker = $1 AND state = 'running'",
        )
        .bind(worker)
        .execute(&self.pool)
        .await;
        done.map(|d| d.rows_affected()).map_err(unavailable)
    }
}

/// The files of a result that is about to be replaced are no longer the job's.
async fn forget_result(transaction: &mut Transaction, id: &str, lease: i64) -> Result<(), Error> {
    let sql = "DELETE FROM job_files WHERE job = $1 AND hash IN (SELECT result FROM jobs WHERE id = $1 AND lease = $2 AND state = 'running' \
         UNION SELECT model FROM jobs WHERE id = $1 AND lease = $2 AND state = 'running')";
    let done = sqlx::query(sql).bind(id).bind(lease).execute(&mut **transaction).await;
    done.map(drop).map_err(unavailable)
}

fn claimed(row: &AnyRow) -> Result<Claimed, sqlx::Error> {
    let kind: String = row.try_get("kind")?;
    Ok(Claimed {
        id: row.try_get("id")?,
        kind: JobKind::named(&kind)
            .ok_or_else(|| sqlx::Error::Decode(format!("`{kind}` is not known to this version").into()))?,
        robot: row.try_get("robot")?,
        input: row.try_get("input")?,
        lease: row.try_get("lease")?,
        cancel_requested: row.try_get::<i64, _>("cancel_requested")? != 0,
        created_us: row.try_get("created_us")?,
        kept: match row.try_get("result")? {
            Some(result) => Some(Kept {
                outcome: row.try_get("outcome")?,
                result,
                model: row.try_get("model")?,
            }),
            None => None,
        },
    })
}
