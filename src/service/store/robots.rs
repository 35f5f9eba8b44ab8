//! Robots of the lab.

use super::{Store, now_us, unavailable};
use crate::app::{Code, Error};
use serde_json::Value;
use sqlx::Row;

impl Store {
    /// Names of all robots of the lab.
    pub async fn robots(&self) -> Result<Vec<String>, Error> {
        let rows = sqlx::query("SELECT id FROM robots ORDER BY id").fetch_all(&self.pool).await;
        let rows = rows.map_err(unavailable)?;
        rows.iter().map(|row| row.try_get("id").map_err(unavailable)).collect()
    }

    /// # Errors
    /// `robot_unreadable`, where its document is no JSON: one that came from elsewhere into the database.
    pub async fn robot(&self, id: &str) -> Result<Option<Value>, Error> {
        let row = sqlx::query("SELECT document FROM robots WHERE id = $1")
            .bind(id)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.map(|row| document(id, row.try_get("document").map_err(unavailable)?))
            .transpose()
    }

    /// Keeps a robot; `None` if there is one of that name and it is not to be replaced, else whether it is new.
    pub async fn put_robot(&self, id: &str, robot: &Value, replace: bool) -> Result<Option<bool>, Error> {
        let mut transaction = self.begin().await?;
        let inserted =
            sqlx::query("INSERT INTO robots (id, document, updated_us) VALUES ($1, $2, $3) ON CONFLICT (id) DO NOTHING")
                .bind(id)
                .bind(robot.to_string())
                .bind(now_us())
                .execute(&mut *transaction)
                .await
                .map_err(unavailable)?;
        let new = inserted.rows_affected() == 1;
        if !new && !replace {
            return Ok(None);
        }
        if !new {
            sqlx::query("UPDATE robots SET document = $2, updated_us = $3 WHERE id = $1")
                .bind(id)
                .bind(robot.to_string())
                .bind(now_us())
                .execute(&mut *transaction)
                .await
                .map_err(unavailable)?;
        }
        transaction.commit().await.map_err(unavailable)?;
        Ok(Some(new))
    }

    /// Whether there was one.
    pub async fn remove_robot(&self, id: &str) -> Result<bool, Error> {
        let removed = sqlx::query("DELETE FROM robots WHERE id = $1")
            .bind(id)
            .execute(&self.pool)
            .await;
        Ok(removed.map_err(unavailable)?.rows_affected() == 1)
    }
}

fn document(id: &str, text: String) -> Result<Value, Error> {
    serde_json::from_str(&text).map_err(|e| unreadable(id, &e.to_string()))
}

/// A robot whose document cannot be read, or not by this version.
pub fn unreadable(id: &str, why: &str) -> Error {
    Error::new(
        Code::RobotUnreadable,
        format!("the stored robot `{id}` cannot be read: {why}"),
    )
    .with_hint(format!("PUT /robots/{id} replaces it, DELETE /robots/{id} forgets it"))
}
