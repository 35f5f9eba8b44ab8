//! All SQL: robots, effects, jobs, tokens and the audit log, on SQLite or PostgreSQL with the same statements.
//!
//! Leases end by the clock of the database, so that machines whose clocks differ agree about them; times that people read are
//! those of the machine that did the work.

mod audit;
mod dump;
mod effects;
mod files;
mod found;
mod jobs;
mod queue;
mod robots;
mod shares;
mod submission;
mod tokens;

pub use audit::AuditEntry;
pub use dump::{Amount, backup, restore};
pub(super) use effects::unreadable as unreadable_effect;
pub use files::{Files, NewFile, hex, sha256};
pub use found::{FoundRow, Spent};
pub use jobs::{JobFilter, JobPlace, JobRow, State};
pub use queue::{Claimed, Ended, Kept, Renewed};
pub(super) use robots::unreadable as unreadable_robot;
pub use shares::{Share, ShareResult};
pub use submission::{Key, NewJob, Submission, Waiting};
pub use tokens::{Role, TokenRow};

use crate::app::{Code, Error};
use sqlx::any::{AnyConnectOptions, AnyPoolOptions, install_default_drivers};
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::{AnyPool, AssertSqlSafe, ConnectOptions, Executor, SqlSafeStr};
use std::path::Path;
use std::str::FromStr;
use std::time::{Duration, SystemTime};

const MIGRATIONS: &[(i64, &str, &str)] = &[
    (1, "first", include_str!("migrations/0001_first.sql")),
    (2, "found", include_str!("migrations/0002_found.sql")),
    (3, "expiry_and_names", include_str!("migrations/0003_expiry_and_names.sql")),
    (4, "children", include_str!("migrations/0004_children.sql")),
    (5, "logs", include_str!("migrations/0005_logs.sql")),
    (6, "effects", include_str!("migrations/0006_effects.sql")),
];

type Transaction = sqlx::Transaction<'static, sqlx::Any>;

/// Which database this is; statements differ in four words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// SQLite, one file in the data folder.
    Sqlite,
    /// PostgreSQL.
    Postgres,
}

impl Dialect {
    /// How long a statement waits for a connection. A file is there, however slow its disk: every connection may be waiting for a
    /// writer, as long as [`BUSY`] lets it. That a server is gone is said soon.
    fn patience(self) -> Duration {
        match self {
            Dialect::Sqlite => BUSY + Duration::from_secs(5),
            Dialect::Postgres => Duration::from_secs(5),
        }
    }
}

/// How long a writer of SQLite waits for another.
const BUSY: Duration = Duration::from_secs(30);

/// The database. Clones share its connections.
#[derive(Debug, Clone)]
pub struct Store {
    pool: AnyPool,
    dialect: Dialect,
}

impl Store {
    /// SQLite in `folder`.
    pub async fn in_folder(folder: &Path) -> Result<Self, Error> {
        let path = folder.join("dynident.sqlite");
        let text = path.to_str().ok_or_else(|| {
            Error::new(
                Code::StorageUnavailable,
                format!("the name of the data folder {} is not UTF-8 text", folder.display()),
            )
        })?;
        // The address is a URL: these characters mean something in one.
        let escaped = text
            .replace('%', "%25")
            .replace('?', "%3f")
            .replace('#', "%23")
            .replace(' ', "%20");
        // Two processes that make the same new database (the server and `dynident token`) take turns.
        let lock = std::fs::File::create(folder.join("opening")).and_then(|lock| lock.lock().map(|()| lock));
        let _lock = lock.map_err(|e| unavailable(sqlx::Error::Io(e)))?;
        Self::connect(&format!("sqlite://{escaped}?mode=rwc"), Dialect::Sqlite).await
    }

    /// PostgreSQL at `url`.
    pub async fn at(url: &str) -> Result<Self, Error> {
        if !url.starts_with("postgres://") && !url.starts_with("postgresql://") {
            let detail = "the address of the database is not that of a PostgreSQL database".to_string();
            return Err(Error::new(Code::StorageUnavailable, detail).with_hint(
                "DATABASE_URL is like postgres://user:password@host/database; leave it out for SQLite in the data folder",
            ));
        }
        Self::connect(url, Dialect::Postgres).await
    }

    async fn connect(url: &str, dialect: Dialect) -> Result<Self, Error> {
        install_default_drivers();
        let options = AnyConnectOptions::from_str(url).map_err(unavailable)?;
        // SQLite waits for a writer, and sqlx warns of every statement that did.
        let options = options.log_slow_statements(tracing::log::LevelFilter::Debug, Duration::from_secs(5));
        let pool = AnyPoolOptions::new()
            .max_connections(8)
            .acquire_timeout(dialect.patience())
            .after_connect(move |connection, _| {
                Box::pin(async move {
                    if dialect == Dialect::Sqlite {
                        // Readers and one writer side by side; a commit is on the disk before it is reported.
                        let busy = format!("PRAGMA busy_timeout = {}", BUSY.as_millis());
                        connection.execute(AssertSqlSafe(busy).into_sql_str()).await?;
                        for pragma in ["PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL"] {
                            connection.execute(pragma).await?;
                        }
                    }
                    Ok(())
                })
            })
            .connect_with(options)
            .await
            .map_err(unavailable)?;
        let store = Self { pool, dialect };
        store.migrate().await?;
        Ok(store)
    }

    async fn migrate(&self) -> Result<(), Error> {
        let migrations = MIGRATIONS.iter().map(|(version, name, sql)| {
            let sql = AssertSqlSafe(self.words(sql)).into_sql_str();
            Migration::new(*version, (*name).into(), MigrationType::Simple, sql, false)
        });
        let migrator = Migrator::with_migrations(migrations.collect());
        let failed = |e: sqlx::migrate::MigrateError| {
            Error::new(
                Code::StorageUnavailable,
                format!("the database cannot be brought to this version: {e}"),
            )
            .with_hint("a database of a newer version of the program cannot be used by this one")
        };
        migrator.run(&self.pool).await.map_err(failed)
    }

    /// Which database it is.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Puts the words in which the two databases differ into a statement.
    fn words(&self, sql: &str) -> String {
        let (now, skip, bytes, real) = match self.dialect {
            Dialect::Sqlite => ("CAST(unixepoch('subsec') * 1000000 AS INTEGER)", "", "BLOB", "REAL"),
            Dialect::Postgres => (
                "CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000000 AS BIGINT)",
                "FOR UPDATE OF j SKIP LOCKED",
                "BYTEA",
                "DOUBLE PRECISION",
            ),
        };
        sql.replace("{now}", now)
            .replace("{skip}", skip)
            .replace("{bytes}", bytes)
            .replace("{real}", real)
    }

    fn sql(&self, sql: &str) -> AssertSqlSafe<String> {
        AssertSqlSafe(self.words(sql))
    }

    /// A transaction that may write: on SQLite it takes the writer's place at once rather than fail when it first writes.
    async fn begin(&self) -> Result<Transaction, Error> {
        match self.dialect {
            Dialect::Sqlite => self.pool.begin_with("BEGIN IMMEDIATE").await.map_err(unavailable),
            Dialect::Postgres => self.pool.begin().await.map_err(unavailable),
        }
    }

    /// Whether the database answers.
    pub async fn ping(&self) -> Result<(), Error> {
        sqlx::query("SELECT 1")
            .execute(&self.pool)
            .await
            .map(drop)
            .map_err(unavailable)
    }

    /// Closes all connections.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}

/// Microseconds since 1970 by the clock of this machine.
pub fn now_us() -> i64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    since.as_micros() as i64
}

/// The last time that RFC 3339 has a form for (s since 1970).
const LAST_OF_CALENDAR: u64 = 253_402_300_799;

/// Microseconds since 1970 as people read them: RFC 3339, UTC.
pub fn rfc3339(us: i64) -> String {
    let since = Duration::from_micros(us.max(0) as u64).min(Duration::from_secs(LAST_OF_CALENDAR));
    humantime::format_rfc3339_millis(SystemTime::UNIX_EPOCH + since).to_string()
}

/// What clients hear of a database that fails: what it said itself goes to the log.
fn unavailable(e: sqlx::Error) -> Error {
    tracing::error!(error = %e, "the database failed");
    let detail = match &e {
        // SQLite says it in words, PostgreSQL by its code `disk_full`.
        sqlx::Error::Database(e) if e.message().contains("disk is full") || e.code().as_deref() == Some("53100") => {
            "the disk of the database is full"
        }
        _ => "the database does not answer as it should",
    };
    Error::new(Code::StorageUnavailable, detail).with_hint("nothing was changed; try again later")
}
