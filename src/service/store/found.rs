//! What the searches of a running design have found, for those beside them and for whoever takes the job over.

use super::{Store, unavailable};
use crate::app::Error;
use sqlx::Row;
use sqlx::any::AnyRow;
use std::time::Duration;

/// What one search has found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRow {
    /// 0 for the search of the job itself, else that of the share.
    pub number: i64,
    /// Logarithm of the criterion at the best point.
    pub value: f64,
    /// Points, as JSON.
    pub points: String,
    /// Time and evaluations of the search.
    pub spent: Spent,
    /// Of the row, in the database: grows with every write.
    pub version: i64,
}

/// What a search has cost so far.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spent {
    /// Time spent searching.
    pub time: Duration,
    /// Evaluations of the criterion.
    pub evaluations: u64,
}

/// Searches whose points are taken in at a time: as many as a pool has niches.
const BEST: i64 = 10;

impl Store {
    /// Writes down what a search has found; nothing changes if the job is in other hands.
    pub async fn write_found(&self, job: &str, lease: i64, found: &FoundRow) -> Result<(), Error> {
        let sql = "INSERT INTO found (job, number, lease, value, points, elapsed_us, evaluations, version) \
             SELECT j.id, $3, j.lease, $4, $5, $6, $7, 1 FROM jobs j WHERE j.id = $1 AND j.lease = $2 AND j.state = 'running' \
             ON CONFLICT (job, number) DO UPDATE SET lease = excluded.lease, value = excluded.value, points = excluded.points, \
               elapsed_us = excluded.elapsed_us, evaluations = excluded.evaluations, version = found.version + 1 \
             WHERE excluded.lease >= found.lease";
        let done = sqlx::query(sql)
            .bind(job)
            .bind(lease)
            .bind(found.number)
            .bind(found.value)
            .bind(&found.points)
            .bind(found.spent.time.as_micros() as i64)
            .bind(found.spent.evaluations as i64)
            .execute(&self.pool)
            .await;
        done.map(drop).map_err(unavailable)
    }

    /// What the best searches of a job have found, those of earlier leases among them, the best first.
    pub async fn found(&self, job: &str) -> Result<Vec<FoundRow>, Error> {
        let rows = sqlx::query(
            "SELECT number, value, points, elapsed_us, evaluations, version FROM found WHERE job = $1 ORDER BY value, number LIMIT $2",
        )
        .bind(job)
        .bind(BEST)
        .fetch_all(&self.pool)
        .await
        .map_err(unavailable)?;
        rows.iter().map(|row| read(row).map_err(unavailable)).collect()
    }

    /// What the job's own search had cost when it last wrote; nothing if it never did.
    pub async fn spent(&self, job: &str) -> Result<Option<Spent>, Error> {
        let row = sqlx::query("SELECT elapsed_us, evaluations FROM found WHERE job = $1 AND number = 0")
            .bind(job)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.map(|row| spent(&row).map_err(unavailable)).transpose()
    }
}

fn read(row: &AnyRow) -> Result<FoundRow, sqlx::Error> {
    Ok(FoundRow {
        number: row.try_get("number")?,
        value: row.try_get("value")?,
        points: row.try_get("points")?,
        spent: spent(row)?,
        version: row.try_get("version")?,
    })
}

fn spent(row: &AnyRow) -> Result<Spent, sqlx::Error> {
    let (us, evaluations): (i64, i64) = (row.try_get("elapsed_us")?, row.try_get("evaluations")?);
    Ok(Spent {
        time: Duration::from_micros(us.max(0) as u64),
        evaluations: evaluations.max(0) as u64,
    })
}
