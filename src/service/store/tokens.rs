//! Bearer tokens, of which only the hash is kept.

use super::{Store, now_us, unavailable};
use crate::app::{Code, Error};
use sqlx::Row;
use sqlx::any::AnyRow;

/// What a token may do; each may do what stands before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Look at robots, jobs and results.
    Read,
    /// Begin and cancel jobs.
    Run,
    /// Add, replace and remove robots.
    Admin,
}

impl Role {
    /// Names of the roles.
    pub const ALL: [(&'static str, Role); 3] = [("read", Role::Read), ("run", Role::Run), ("admin", Role::Admin)];

    /// Name in the database and on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, r)| *r == self).map_or("", |(name, _)| name)
    }

    /// The role of this name; nothing if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(n, _)| *n == name).map(|(_, role)| *role)
    }
}

/// A token as it is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TokenRow {
    /// ID of the token.
    pub id: String,
    /// Name that people gave it.
    pub name: String,
    /// What it may do.
    pub role: Role,
    /// Names of robots, or `*` for all.
    pub robots: Vec<String>,
    /// Time of creation (µs).
    pub created_us: i64,
    /// From when on it is refused; `None` for never.
    pub expires_us: Option<i64>,
    /// Time of revocation (µs); nothing while it is valid.
    pub revoked_us: Option<i64>,
}

impl TokenRow {
    /// Whether it is refused by the clock of this machine, which its time was taken from.
    pub fn is_expired(&self) -> bool {
        self.expires_us.is_some_and(|end| end <= now_us())
    }
}

impl Store {
    /// Adds a token; `hash` is the SHA-256 of its text.
    pub async fn add_token(&self, token: &TokenRow, hash: &str) -> Result<(), Error> {
        let sql = "INSERT INTO tokens (id, name, hash, role, robots, created_us, expires_us) VALUES ($1, $2, $3, $4, $5, $6, $7)";
        let done = sqlx::query(sql)
            .bind(&token.id)
            .bind(&token.name)
            .bind(hash)
            .bind(token.role.name())
            .bind(serde_json::json!(token.robots).to_string())
            .bind(token.created_us)
            .bind(token.expires_us)
            .execute(&self.pool)
            .await;
        done.map(drop).map_err(unavailable)
    }

    /// The token of this hash, unless it was revoked; one that has expired is found.
    pub async fn token(&self, hash: &str) -> Result<Option<TokenRow>, Error> {
        let row = sqlx::query("SELECT * FROM tokens WHERE hash = $1 AND revoked_us IS NULL")
            .bind(hash)
            .fetch_optional(&self.pool)
            .await
            .map_err(unavailable)?;
        row.as_ref().map(|row| read(row).map_err(unavailable)).transpose()
    }

    /// All tokens, revoked ones included.
    pub async fn tokens(&self) -> Result<Vec<TokenRow>, Error> {
        let rows = sqlx::query("SELECT * FROM tokens ORDER BY created_us, id")
            .fetch_all(&self.pool)
            .await
            .map_err(unavailable)?;
        rows.iter().map(|row| read(row).map_err(unavailable)).collect()
    }

    /// # Errors
    /// There is no such token that is not revoked.
    pub async fn revoke_token(&self, id: &str) -> Result<(), Error> {
        let done = sqlx::query("UPDATE tokens SET revoked_us = $2 WHERE id = $1 AND revoked_us IS NULL")
            .bind(id)
            .bind(now_us())
            .execute(&self.pool)
            .await
            .map_err(unavailable)?;
        match done.rows_affected() {
            0 => Err(Error::new(
                Code::NotFound,
                format!("there is no token `{id}` that is not revoked already"),
            )
            .with_hint("dynident token list shows them")),
            _ => Ok(()),
        }
    }
}

fn read(row: &AnyRow) -> Result<TokenRow, sqlx::Error> {
    let (role, robots): (String, String) = (row.try_get("role")?, row.try_get("robots")?);
    let unreadable = |what: String| sqlx::Error::Decode(what.into());
    Ok(TokenRow {
        id: row.try_get("id")?,
        name: row.try_get("name")?,
        role: Role::named(&role).ok_or_else(|| unreadable(format!("the role `{role}` is not known")))?,
        robots: serde_json::from_str(&robots).map_err(|e| unreadable(e.to_string()))?,
        created_us: row.try_get("created_us")?,
        expires_us: row.try_get("expires_us")?,
        revoked_us: row.try_get("revoked_us")?,
    })
}
