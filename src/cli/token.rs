//! `dynident token`: who may use the server.

use super::settings::{Place, Settings};
use super::store::{note, open_store, run_async};
use super::{Ending, files};
use crate::app::{Code, Error};
use crate::service::new_token;
use crate::service::store::{Role, TokenRow};
use clap::Subcommand;
use serde_json::{Value, json};
use std::time::{Duration, SystemTime};

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
            place,
        } => run_async(create(&place.settings(&Settings::default())?, robot, *role, name, json)),
        Command::List { place } => run_async(list(&place.settings(&Settings::default())?, json)),
        Command::Revoke { id, place } => run_async(revoke(&place.settings(&Settings::default())?, id)),
    }
}

async fn create(settings: &Settings, robots: &[String], role: Role, name: &str, json: bool) -> Result<(), Error> {
    if let Some(empty) = robots.iter().find(|r| r.trim().is_empty()) {
        return Err(Error::new(
            Code::InvalidDocument,
            format!("`{empty}` is not the name of a robot"),
        ));
    }
    let store = open_store(settings).await?;
    let (row, secret, hash) = new_token(name, role, robots.to_vec());
    store.add_token(&row, &hash).await?;
    note(&store, "token_create", &robots.join(","), &row.id).await?;
    match json {
        true => files::print(&files::pretty(&json!({"id": row.id, "token": secret}))),
        false => files::print(&format!("{secret}\n")),
    }
}

async fn list(settings: &Settings, json: bool) -> Result<(), Error> {
    let tokens = open_store(settings).await?.tokens().await?;
    if json {
        return files::print(&files::pretty(&tokens.iter().map(document).collect::<Vec<Value>>()));
    }
    let line = |t: &TokenRow| {
        let state = if t.revoked_us.is_some() { "revoked" } else { "valid" };
        let created =
            humantime::format_rfc3339_seconds(SystemTime::UNIX_EPOCH + Duration::from_micros(t.created_us.max(0) as u64));
        format!(
            "{}  {:<5}  {:<7}  {created}  {}  {}\n",
            t.id,
            t.role.name(),
            state,
            t.robots.join(","),
            t.name
        )
    };
    files::print(&tokens.iter().map(line).collect::<String>())
}

fn document(t: &TokenRow) -> Value {
    json!({"id": t.id, "name": t.name, "role": t.role.name(), "robots": t.robots, "revoked": t.revoked_us.is_some()})
}

async fn revoke(settings: &Settings, id: &str) -> Result<(), Error> {
    let store = open_store(settings).await?;
    store.revoke_token(id).await?;
    note(&store, "token_revoke", "", id).await
}
