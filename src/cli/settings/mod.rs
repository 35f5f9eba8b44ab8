//! What an operator may choose: by flags, by the environment, by a file, in this order.

mod config;
mod layers;

pub use layers::Place;

use crate::service::Config;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Whether requests need a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Auth {
    /// On, save for a server that only its own machine reaches.
    Auto,
    On,
    Off,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    Text,
    Json,
}

/// Everything else. Fields that are not given have the value that `dynident config` prints.
#[derive(Debug, Clone, Default, PartialEq, clap::Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Address and port; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS:PORT", env = "DYNIDENT_LISTEN")]
    pub listen: Option<SocketAddr>,
    #[arg(skip)]
    pub data: Option<PathBuf>,
    #[arg(skip)]
    pub database_url: Option<String>,
    /// Whether requests need a token.
    #[arg(long, env = "DYNIDENT_AUTH")]
    pub auth: Option<Auth>,
    /// Serve without tokens at an address that others reach.
    #[arg(long, env = "DYNIDENT_OPEN_TO_ANYONE", num_args = 0..=1, default_missing_value = "true", value_name = "BOOL")]
    pub open_to_anyone: Option<bool>,
    /// Long searches that run at the same time; each uses all cores. 0 leaves them to workers.
    #[arg(long, env = "DYNIDENT_CONCURRENT_JOBS", value_name = "N")]
    pub concurrent_jobs: Option<usize>,
    /// Identifications and validations that run at the same time beside them, and one search that is not long. 0 leaves them to
    /// workers.
    #[arg(long, env = "DYNIDENT_SHORT_JOBS", value_name = "N")]
    pub short_jobs: Option<usize>,
    /// Work in processes of their own, so that what goes wrong in one costs nothing else.
    #[arg(long, env = "DYNIDENT_ISOLATE", num_args = 0..=1, default_missing_value = "true", value_name = "BOOL")]
    pub isolate: Option<bool>,
    /// Memory that one job or request may take; half of that of the machine or container if left out.
    #[arg(long, env = "DYNIDENT_JOB_MEMORY", value_name = "BYTES")]
    pub job_memory: Option<u64>,
    /// Time that an identification or validation may take, and a search beside its own limit.
    #[arg(long, env = "DYNIDENT_JOB_TIME_S", value_name = "SECONDS")]
    pub job_time_s: Option<f64>,
    /// A search that may take longer than this is long.
    #[arg(long, env = "DYNIDENT_SHORTEST_LONG_S", value_name = "SECONDS")]
    pub shortest_long_s: Option<f64>,
    /// Jobs of one robot that run at the same time, long searches, others, and the rest each; no bound if left out.
    #[arg(long, env = "DYNIDENT_RUNNING_PER_ROBOT", value_name = "N")]
    pub running_per_robot: Option<usize>,
    /// Jobs that may wait, long searches, others, and the rest each.
    #[arg(long, env = "DYNIDENT_WAITING_JOBS", value_name = "N")]
    pub waiting_jobs: Option<usize>,
    /// Jobs of one robot that may wait, long searches, others, and the rest each.
    #[arg(long, env = "DYNIDENT_WAITING_PER_ROBOT", value_name = "N")]
    pub waiting_per_robot: Option<usize>,
    /// Jobs of one token that may wait, long searches, others, and the rest each.
    #[arg(long, env = "DYNIDENT_WAITING_PER_TOKEN", value_name = "N")]
    pub waiting_per_token: Option<usize>,
    /// Ended jobs that are kept with their results; all if left out.
    #[arg(long, env = "DYNIDENT_KEPT_JOBS", value_name = "N")]
    pub kept_jobs: Option<usize>,
    /// Time after which a job is given to another worker when its own is not heard of.
    #[arg(long, env = "DYNIDENT_LEASE_S", value_name = "SECONDS")]
    pub lease_s: Option<f64>,
    /// Longest time that `Prefer: wait` holds an answer back.
    #[arg(long, env = "DYNIDENT_LONGEST_WAIT_S", value_name = "SECONDS")]
    pub longest_wait_s: Option<f64>,
    /// Longest search that may be asked for.
    #[arg(long, env = "DYNIDENT_LONGEST_SEARCH_S", value_name = "SECONDS")]
    pub longest_search_s: Option<f64>,
    /// Most joints of a robot.
    #[arg(long, env = "DYNIDENT_MOST_JOINTS", value_name = "N")]
    pub most_joints: Option<usize>,
    /// Highest order of a Fourier series.
    #[arg(long, env = "DYNIDENT_HIGHEST_ORDER", value_name = "N")]
    pub highest_order: Option<usize>,
    /// Most rows of a log.
    #[arg(long, env = "DYNIDENT_MOST_ROWS", value_name = "N")]
    pub most_rows: Option<usize>,
    /// Largest document.
    #[arg(long, env = "DYNIDENT_LARGEST_DOCUMENT", value_name = "BYTES")]
    pub largest_document: Option<usize>,
    /// Largest body with logs.
    #[arg(long, env = "DYNIDENT_LARGEST_UPLOAD", value_name = "BYTES")]
    pub largest_upload: Option<usize>,
    /// Requests of one token or address per second over a longer time; 0 for no bound.
    #[arg(long, env = "DYNIDENT_REQUESTS_PER_SECOND", value_name = "N")]
    pub requests_per_second: Option<u64>,
    /// Requests of one token or address at once.
    #[arg(long, env = "DYNIDENT_REQUEST_BURST", value_name = "N")]
    pub request_burst: Option<u32>,
    /// Name under which a server without tokens is reached, such as that of a proxy, with its port where that is not the usual
    /// one; several separated by commas, or the flag several times. Addresses in numbers and `localhost` need not be named.
    #[arg(
        long = "allowed-host",
        env = "DYNIDENT_ALLOWED_HOSTS",
        value_name = "HOST",
        value_delimiter = ','
    )]
    pub allowed_hosts: Option<Vec<String>>,
    /// Connections that are open at the same time; further ones wait.
    #[arg(long, env = "DYNIDENT_MOST_CONNECTIONS", value_name = "N")]
    pub most_connections: Option<usize>,
    /// Time in which the header of a request has to be complete, and for which a connection is kept open between requests.
    #[arg(long, env = "DYNIDENT_HEADER_TIMEOUT_S", value_name = "SECONDS")]
    pub header_timeout_s: Option<f64>,
    /// Time after which a body that stops coming in, or an answer that is not taken, ends the connection.
    #[arg(long, env = "DYNIDENT_IDLE_TIMEOUT_S", value_name = "SECONDS")]
    pub idle_timeout_s: Option<f64>,
    /// What is logged to standard error, as in RUST_LOG.
    #[arg(long, env = "DYNIDENT_LOG", value_name = "FILTER")]
    pub log: Option<String>,
    /// How.
    #[arg(long, env = "DYNIDENT_LOG_FORMAT")]
    pub log_format: Option<LogFormat>,
}

/// Folder of the data where nothing else is said.
const DATA: &str = "dynident-data";

fn defaults() -> Settings {
    let config = Config::default();
    Settings {
        listen: Some(SocketAddr::from(([127, 0, 0, 1], 8080))),
        data: Some(DATA.into()),
        database_url: None,
        auth: Some(Auth::Auto),
        open_to_anyone: Some(false),
        concurrent_jobs: Some(config.concurrent_jobs),
        short_jobs: Some(config.short_jobs),
        isolate: Some(true),
        job_memory: config.job_memory,
        job_time_s: Some(config.job_time.as_secs_f64()),
        shortest_long_s: Some(config.shortest_long_s),
        running_per_robot: config.running_per_robot,
        waiting_jobs: Some(config.waiting_jobs),
        waiting_per_robot: Some(config.waiting_per_robot),
        waiting_per_token: Some(config.waiting_per_token),
        kept_jobs: config.kept_jobs,
        lease_s: Some(config.lease.as_secs_f64()),
        longest_wait_s: Some(config.longest_wait.as_secs_f64()),
        longest_search_s: Some(config.longest_search_s),
        most_joints: Some(config.most_joints),
        highest_order: Some(config.highest_order),
        most_rows: Some(config.most_rows),
        largest_document: Some(config.largest_document),
        largest_upload: Some(config.largest_upload),
        requests_per_second: Some(config.requests_per_second.unwrap_or(0)),
        request_burst: Some(config.request_burst),
        allowed_hosts: Some(config.allowed_hosts),
        most_connections: Some(config.most_connections),
        header_timeout_s: Some(config.header_timeout.as_secs_f64()),
        idle_timeout_s: Some(config.idle_timeout.as_secs_f64()),
        log: Some("info".to_string()),
        log_format: Some(LogFormat::Text),
    }
}
