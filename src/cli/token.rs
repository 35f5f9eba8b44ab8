//! `dynident token`: who may use the server.

use super::settings::{Place, Settings};
use super::store::{note, open_store, run_async};
use super::{Ending, files};
use crate::app::{Code, Error};
use crate::service::new_token;
use crate::service::store::{Role, TokenRow, rfc3339};
use clap::Subcommand;
use serde_json::{Value, json};
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a token and print it; it is shown this once.
    Create {
        /// Robot whose data it is for; may be given several times, `*` for all.
        #[arg(long, required = true, value_name = "NAME")]
        robot: Vec<String>,
        /// What it may do: read results, run jobs, administer robots; each includes those before it.
        #[arg(long, value_parser = role, default_value = "run")]
        role: Role,
        /// What the audit log calls its bearer.
        #[arg(long, default_value = "")]
        name: String,
        /// Time from now after which it is refused, such as 90d, 12h or 1year; without one it is valid until it is revoked.
        #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
        expires_in: Option<Duration>,
        #[command(flatten)]
        place: Place,
    },
    /// List all tokens, without their secrets.
    List {
        #[command(flatten)]
        place: Place,
    },
    /// End a token: from now on it is refused.
    Revoke {
        /// Id, as in the list.
        id: String,
        #[command(flatten)]
        place: Place,
    },
}

fn role(text: &str) -> Result<Role, String> {
    Role::named(text).ok_or_else(|| "must be read, run or admin".to_string())
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    match &arguments.command {
        Command::Create {
            robot,
            role,
            name,
            expires_in,
            place,
        } => {
            let new = new_token(name, *role, robot.clone(), *expires_in);
            run_async(create(&place.settings(&Settings::default())?, robot, new, json))
        }
        Command::List { place } => run_async(list(&place.settings(&Settings::default())?, json)),
        Command::Revoke { id, place } => run_async(revoke(&place.settings(&Settings::default())?, id)),
    }
}

async fn create(
    settings: &Settings,
    robots: &[String],
    (row, secret, hash): (TokenRow, String, String),
    json: bool,
) -> Result<(), Error> {
    if let Some(empty) = robots.iter().find(|r| r.trim().is_empty()) {
        return Err(Error::new(
            Code::InvalidDocument,
            format!("`{empty}` is not the name of a robot"),
        ));
    }
    let store = open_store(settings).await?;
    store.add_token(&row, &hash).await?;
    note(&store, "token_create", &robots.join(","), &row.id).await?;
    match json {
        true => files::print(&files::pretty(
            &json!({"id": row.id, "token": secret, "expires_at": row.expires_us.map(rfc3339)}),
        )),
        false => files::print(&format!("{secret}\n")),
    }
}

async fn list(settings: &Settings, json: bool) -> Result<(), Error> {
    let tokens = open_store(settings).await?.tokens().await?;
    if json {
        return files::print(&files::pretty(&tokens.iter().map(document).collect::<Vec<Value>>()));
    }
    let line = |t: &TokenRow| {
        let (created, end) = (day(t.created_us), t.expires_us.map_or("never".to_string(), day));
        let (id, role, robots) = (&t.id, t.role.name(), t.robots.join(","));
        format!(
            "{id}  {role:<5}  {:<7}  {created}  {end:<20}  {robots}  {}\n",
            state(t),
            t.name
        )
    };
    files::print(&(heads() + &tokens.iter().map(line).collect::<String>()))
}

fn heads() -> String {
    format!(
        "{:<8}  {:<5}  {:<7}  {:<20}  {:<20}  robots  name\n",
        "id", "role", "state", "created", "expires"
    )
}

/// A time to the second.
fn day(us: i64) -> String {
    let text = rfc3339(us);
    text.split_once('.')
        .map_or(text.clone(), |(seconds, _)| format!("{seconds}Z"))
}

fn state(t: &TokenRow) -> &'static str {
    match (t.revoked_us, t.is_expired()) {
        (Some(_), _) => "revoked",
        (None, true) => "expired",
        (None, false) => "valid",
    }
}

fn document(t: &TokenRow) -> Value {
    json!({
        "id": t.id, "name": t.name, "role": t.role.name(), "robots": t.robots, "revoked": t.revoked_us.is_some(), "state": state(t),
        "created_at": rfc3339(t.created_us), "expires_at": t.expires_us.map(rfc3339),
    })
}

async fn revoke(settings: &Settings, id: &str) -> Result<(), Error> {
    let store = open_store(settings).await?;
    store.revoke_token(id).await?;
    note(&store, "token_revoke", "", id).await
}
