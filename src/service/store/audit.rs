//! Who did what.

use super::{Store, Transaction, now_us, unavailable};
use crate::app::Error;
use serde::Serialize;
use sqlx::Row;
use sqlx::any::AnyRow;

/// One line of the audit log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AuditEntry {
    /// Microseconds since 1970.
    pub at_us: i64,
    /// Id of the request.
    pub request: String,
    /// Id of the token; empty without one.
    pub token: String,
    /// Name of the token, or the address of the client.
    pub who: String,
    /// As `run_excitation`, `cancel_job`, `put_robot`, `token_create`.
    pub action: String,
    /// Robot that the action concerned; empty if none.
    pub robot: String,
    /// Job, robot or token.
    pub target: String,
}

impl Store {
    /// Adds an entry to the log of actions.
    pub async fn note(&self, entry: &AuditEntry) -> Result<(), Error> {
        let mut transaction = self.begin().await?;
        note(&mut transaction, entry).await?;
        transaction.commit().await.map_err(unavailable)
    }

    /// The newest `most` entries, the newest last.
    pub async fn audit(&self, most: usize) -> Result<Vec<AuditEntry>, Error> {
        let rows = sqlx::query("SELECT * FROM audit ORDER BY at_us DESC LIMIT $1")
            .bind(most as i64)
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        rows.iter().rev().map(|row| read(row).map_err(unavailable)).collect()
    }
}

/// Notes what is done in the same transaction: both are there or neither.
pub(super) async fn note(transaction: &mut Transaction, entry: &AuditEntry) -> Result<(), Error> {
    let done =
        sqlx::query("INSERT INTO audit (at_us, request, token, who, action, robot, target) VALUES ($1, $2, $3, $4, $5, $6, $7)")
            .bind(now_us())
            .bind(&entry.request)
            .bind(&entry.token)
            .bind(&entry.who)
            .bind(&entry.action)
            .bind(&entry.robot)
            .bind(&entry.target)
            .execute(&mut **transaction)
            .await;
    done.map(drop).map_err(unavailable)
}

fn read(row: &AnyRow) -> Result<AuditEntry, sqlx::Error> {
    Ok(AuditEntry {
        at_us: row.try_get("at_us")?,
        request: row.try_get("request")?,
        token: row.try_get("token")?,
        who: row.try_get("who")?,
        action: row.try_get("action")?,
        robot: row.try_get("robot")?,
        target: row.try_get("target")?,
    })
}
