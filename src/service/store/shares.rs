//! Shares: searches that idle workers make for a design that another worker runs.
//!
//! A share has a lease like a job, and counts if it is handed in while the job still gathers: a share that dies or hangs costs
//! nothing but its own work. What was handed in stays with the job, also when another worker begins it again.

use super::submission::name_file;
use super::{Dialect, Store, unavailable};
use crate::app::Error;
use sqlx::Row;
use sqlx::any::AnyRow;
use std::time::Duration;

/// A share in the hands of this worker.
#[derive(Debug, Clone)]
pub struct Share {
    /// ID of the job.
    pub job: String,
    /// From 1: the search of the job itself is number 0.
    pub number: i64,
    /// Of the job.
    pub lease: i64,
    /// File of the request, by SHA-256.
    pub input: String,
    /// Time left to search.
    pub left: Duration,
}

/// What the shares of a job have done.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ShareResult {
    /// Evaluations of all shares together.
    pub evaluations: i64,
    /// Best criterion of all shares; nothing before the first.
    pub best: Option<f64>,
    /// Results that are in.
    pub results: Vec<String>,
    /// Shares that still may hand theirs in.
    pub outstanding: usize,
}

/// Searches shorter than this are not worth the way to another machine.
const LEAST_LEFT: Duration = Duration::from_secs(3);

impl Store {
    /// Lets other workers search for a job, for `time`; an empty time ends that.
    pub async fn spread(&self, job: &str, lease: i64, time: Duration) -> Result<(), Error> {
        let sql = self.sql("UPDATE jobs SET spread_until_us = {now} + $3 WHERE id = $1 AND lease = $2 AND state = 'running'");
        let done = sqlx::query(sql)
            .bind(job)
            .bind(lease)
            .bind(time.as_micros() as i64)
            .execute(&self.pool)
            .await;
        done.map(drop).map_err(unavailable)
    }

    /// Takes a share of the running search that has the fewest; only of jobs on other workers, and one of each.
    pub async fn take_share(&self, worker: &str, lease: Duration) -> Result<Option<Share>, Error> {
        if self.dialect == Dialect::Sqlite {
            // One process has the folder: its search uses all cores already.
            return Ok(None);
        }
        let sql = self.sql(
            "INSERT INTO shares (job, number, lease, worker, lease_until_us, evaluations) \
             SELECT j.id, (SELECT COALESCE(MAX(s.number), 0) + 1 FROM shares s WHERE s.job = j.id), j.lease, $1, {now} + $2, 0 \
             FROM jobs j WHERE j.state = 'running' AND j.worker <> $1 AND j.cancel_requested = 0 \
               AND j.lease_until_us >= {now} AND j.spread_until_us > {now} + $3 \
               AND NOT EXISTS (SELECT 1 FROM shares s WHERE s.job = j.id AND s.lease = j.lease AND s.worker = $1 AND s.result IS NULL) \
             ORDER BY (SELECT COUNT(*) FROM shares s WHERE s.job = j.id AND s.lease = j.lease AND s.lease_until_us >= {now}), \
               j.created_us LIMIT 1 ON CONFLICT DO NOTHING RETURNING job, number, lease",
        );
        let rows = sqlx::query(sql)
            .bind(worker)
            .bind(lease.as_micros() as i64)
            .bind(LEAST_LEFT.as_micros() as i64)
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        match rows.first() {
            Some(row) => self.share(row).await,
            None => Ok(None),
        }
    }

    async fn share(&self, row: &AnyRow) -> Result<Option<Share>, Error> {
        let (job, number, lease): (String, i64, i64) = (
            row.try_get("job").map_err(unavailable)?,
            row.try_get("number").map_err(unavailable)?,
            row.try_get("lease").map_err(unavailable)?,
        );
        let sql = self.sql("SELECT input, spread_until_us - {now} AS left_us FROM jobs WHERE id = $1 AND lease = $2");
        let row = sqlx::query(sql)
            .bind(&job)
            .bind(lease)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        let Some(row) = row else { return Ok(None) };
        let left: i64 = row.try_get("left_us").map_err(unavailable)?;
        Ok(Some(Share {
            input: row.try_get("input").map_err(unavailable)?,
            left: Duration::from_micros(left.max(0) as u64),
            job,
            number,
            lease,
        }))
    }

    /// Keeps a share and tells where it stands; `false` if the search is over, or the job in other hands.
    pub async fn renew_share(
        &self,
        share: &Share,
        worker: &str,
        time: Duration,
        evaluations: u64,
        best: Option<f64>,
    ) -> Result<bool, Error> {
        let sql = self.sql(
            "UPDATE shares SET lease_until_us = {now} + $4, evaluations = $5, best = $6 WHERE job = $1 AND number = $2 AND worker = $3 \
             AND EXISTS (SELECT 1 FROM jobs j WHERE j.id = $1 AND j.lease = shares.lease AND j.state = 'running' \
               AND j.spread_until_us > {now})",
        );
        let done = sqlx::query(sql)
            .bind(&share.job)
            .bind(share.number)
            .bind(worker)
            .bind(time.as_micros() as i64)
            .bind(evaluations as i64)
            // Not NULL: sqlx calls an absent f64 a REAL, and PostgreSQL then refuses the eight bytes of one that is there.
            .bind(best.unwrap_or(f64::INFINITY))
            .execute(&self.pool)
            .await;
        Ok(done.map_err(unavailable)?.rows_affected() == 1)
    }

    /// Hands a share in, or gives it back where there is no result.
    pub async fn end_share(&self, share: &Share, worker: &str, result: Option<&str>, evaluations: u64) -> Result<(), Error> {
        let mut transaction = self.begin().await?;
        let sql =
            "UPDATE shares SET result = $4, evaluations = $5, lease_until_us = 0 WHERE job = $1 AND number = $2 AND worker = $3";
        let done = sqlx::query(sql)
            .bind(&share.job)
            .bind(share.number)
            .bind(worker)
            .bind(result)
            .bind(evaluations as i64)
            .execute(&mut *transaction)
            .await
            .map_err(unavailable)?;
        if let Some(hash) = result.filter(|_| done.rows_affected() == 1) {
            name_file(&mut transaction, &share.job, hash).await?;
        }
        transaction.commit().await.map_err(unavailable)
    }

    /// What the shares of a job have done: those that are in, and those that are out under this lease.
    pub async fn shares(&self, job: &str, lease: i64) -> Result<ShareResult, Error> {
        let sql = self.sql(
            "SELECT evaluations, best, result, CASE WHEN result IS NULL AND lease_until_us >= {now} THEN 1 ELSE 0 END AS out \
             FROM shares WHERE job = $1 AND (lease = $2 OR result IS NOT NULL) ORDER BY number",
        );
        let rows = sqlx::query(sql)
            .bind(job)
            .bind(lease)
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        let mut all = ShareResult::default();
        for row in &rows {
            add(&mut all, row).map_err(unavailable)?;
        }
        Ok(all)
    }
}

fn add(all: &mut ShareResult, row: &AnyRow) -> Result<(), sqlx::Error> {
    let best: Option<f64> = row.try_get("best")?;
    // PostgreSQL calls a constant of CASE an INTEGER, SQLite a BIGINT.
    let out = row
        .try_get::<i32, _>("out")
        .map(i64::from)
        .or_else(|_| row.try_get::<i64, _>("out"))?;
    all.evaluations += row.try_get::<i64, _>("evaluations")?;
    let best = best.filter(|b| b.is_finite());
    all.best = [all.best, best].into_iter().flatten().reduce(f64::min);
    all.results.extend(row.try_get::<Option<String>, _>("result")?);
    all.outstanding += out as usize;
    Ok(())
}
