//! The lab's catalogue of own effects.

use super::{Store, Transaction, now_us, unavailable};
use crate::app::{Code, Error};
use crate::documents::effects_named;
use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;

/// Most effects of a catalogue: each is 10 kB at most, and requests that name one read the names of all.
pub const MOST_EFFECTS: i64 = 1000;

impl Store {
    /// Names of all effects of the catalogue.
    pub async fn effect_names(&self) -> Result<Vec<String>, Error> {
        let rows = sqlx::query("SELECT name FROM effects ORDER BY name")
            .fetch_all(&self.pool)
            .await;
        let rows = rows.map_err(unavailable)?;
        rows.iter().map(|row| row.try_get("name").map_err(unavailable)).collect()
    }

    /// Names and documents of all effects; the document is an error where it is no JSON.
    pub async fn effects(&self) -> Result<Vec<(String, Result<Value, Error>)>, Error> {
        let rows = sqlx::query("SELECT name, document FROM effects ORDER BY name")
            .fetch_all(&self.pool)
            .await;
        let read = |row: &AnyRow| {
            let name: String = row.try_get("name").map_err(unavailable)?;
            let read = document(&name, row.try_get("document").map_err(unavailable)?);
            Ok((name, read))
        };
        rows.map_err(unavailable)?.iter().map(read).collect()
    }

    /// # Errors
    /// `effect_unreadable`, where its document is no JSON: one that came from elsewhere into the database.
    pub async fn effect(&self, name: &str) -> Result<Option<Value>, Error> {
        let row = sqlx::query("SELECT document FROM effects WHERE name = $1")
            .bind(name)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.map(|row| document(name, row.try_get("document").map_err(unavailable)?))
            .transpose()
    }

    /// Keeps an effect in the place of the one that had its name; whether it is new.
    ///
    /// # Errors
    /// `catalogue_full`, where it is new and there are `MOST_EFFECTS`.
    pub async fn put_effect(&self, name: &str, effect: &Value) -> Result<bool, Error> {
        let mut transaction = self.begin().await?;
        let replaced = sqlx::query("UPDATE effects SET document = $2, updated_us = $3 WHERE name = $1")
            .bind(name)
            .bind(effect.to_string())
            .bind(now_us())
            .execute(&mut *transaction)
            .await
            .map_err(unavailable)?;
        let new = replaced.rows_affected() == 0;
        if new {
            check_room(&mut transaction).await?;
            let sql = "INSERT INTO effects (name, document, updated_us) VALUES ($1, $2, $3) \
                ON CONFLICT (name) DO UPDATE SET document = excluded.document, updated_us = excluded.updated_us";
            let inserted = sqlx::query(sql).bind(name).bind(effect.to_string()).bind(now_us());
            inserted.execute(&mut *transaction).await.map_err(unavailable)?;
        }
        transaction.commit().await.map_err(unavailable)?;
        Ok(new)
    }

    /// Whether there was one.
    ///
    /// # Errors
    /// `effect_in_use`, where a robot of the lab names it.
    pub async fn remove_effect(&self, name: &str) -> Result<bool, Error> {
        let mut transaction = self.begin().await?;
        let users = users(&mut transaction, name).await?;
        if !users.is_empty() {
            let detail = format!("the effect `{name}` is named by robots of the lab: {}", users.join(", "));
            return Err(Error::new(Code::EffectInUse, detail)
                .with_hint("write the definition into their `effects`, or take it out there, before it is deleted"));
        }
        let removed = sqlx::query("DELETE FROM effects WHERE name = $1")
            .bind(name)
            .execute(&mut *transaction)
            .await
            .map_err(unavailable)?;
        transaction.commit().await.map_err(unavailable)?;
        Ok(removed.rows_affected() == 1)
    }
}

async fn check_room(transaction: &mut Transaction) -> Result<(), Error> {
    let row = sqlx::query("SELECT COUNT(*) AS rows FROM effects")
        .fetch_one(&mut **transaction)
        .await
        .map_err(unavailable)?;
    match row.try_get::<i64, _>("rows").map_err(unavailable)? < MOST_EFFECTS {
        true => Ok(()),
        false => Err(Error::new(
            Code::CatalogueFull,
            format!("the catalogue has {MOST_EFFECTS} effects, the most that it takes"),
        )
        .with_hint("DELETE /effects/{name} removes one")),
    }
}

/// Robots of the lab whose documents name an effect; one that cannot be read names none.
async fn users(transaction: &mut Transaction, name: &str) -> Result<Vec<String>, Error> {
    let rows = sqlx::query("SELECT id, document FROM robots ORDER BY id")
        .fetch_all(&mut **transaction)
        .await
        .map_err(unavailable)?;
    let mut users = Vec::new();
    for row in &rows {
        let text: String = row.try_get("document").map_err(unavailable)?;
        let robot: Value = serde_json::from_str(&text).unwrap_or_default();
        if effects_named(&robot).any(|used| used == name) {
            users.push(row.try_get("id").map_err(unavailable)?);
        }
    }
    Ok(users)
}

fn document(name: &str, text: String) -> Result<Value, Error> {
    serde_json::from_str(&text).map_err(|e| unreadable(name, &e.to_string()))
}

/// An effect whose document cannot be read, or not by this version.
pub fn unreadable(name: &str, why: &str) -> Error {
    Error::new(
        Code::EffectUnreadable,
        format!("the stored effect `{name}` cannot be read: {why}"),
    )
    .with_hint(format!("PUT /effects/{name} replaces it, DELETE /effects/{name} removes it"))
}
