//! What an operator may choose: by flags, by the environment, by a file, in this order.

use super::files;
use crate::app::{Code, Error};
use crate::service::Config;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Where the data is.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Place {
    /// Settings as a TOML file; flags and the environment go before it.
    #[arg(long, value_name = "FILE", env = "DYNIDENT_CONFIG")]
    config: Option<PathBuf>,
    /// Folder of database, logs and results.
    #[arg(long, value_name = "DIR", env = "DYNIDENT_DATA")]
    data: Option<PathBuf>,
    /// PostgreSQL database; without one SQLite in the data folder.
    #[arg(long, value_name = "URL", env = "DATABASE_URL", hide_env_values = true)]
    database_url: Option<String>,
}

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
    /// Identifications and validations that run at the same time beside them, and one search that is not long. 0 leaves them to workers.
    #[arg(long, env = "DYNIDENT_SHORT_JOBS", value_name = "N")]
    pub short_jobs: Option<usize>,
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
    /// What is logged to standard error, as in RUST_LOG.
    #[arg(long, env = "DYNIDENT_LOG", value_name = "FILTER")]
    pub log: Option<String>,
    /// How.
    #[arg(long, env = "DYNIDENT_LOG_FORMAT")]
    pub log_format: Option<LogFormat>,
}

/// Folder of the data where nothing else is said.
const DATA: &str = "dynident-data";

impl Place {
    /// Flags and environment, the file, and what is left out.
    pub fn settings(&self, flags: &Settings) -> Result<Settings, Error> {
        self.layers(flags).map(|layers| merge(&layers))
    }

    /// Settings by what they come from, the weakest first.
    fn layers(&self, flags: &Settings) -> Result<Vec<(&'static str, Settings)>, Error> {
        let file = match &self.config {
            Some(path) => read_file(path)?,
            None => Settings::default(),
        };
        let flags = Settings {
            data: self.data.clone(),
            database_url: self.database_url.clone(),
            ..flags.clone()
        };
        Ok(vec![("default", defaults()), ("file", file), ("environment or flag", flags)])
    }

    /// All settings as a TOML file, each with what it comes from; the password of the database is left out.
    pub fn describe(&self, flags: &Settings) -> Result<String, Error> {
        let layers = self.layers(flags)?;
        let mut settings = merge(&layers);
        settings.database_url = settings.database_url.as_deref().map(without_password);
        let set: Vec<(&str, Map<String, Value>)> = layers.iter().map(|(from, s)| (*from, fields(s))).collect();
        let mut text = String::new();
        for (name, _) in fields_with_null(&settings) {
            let from = set
                .iter()
                .rev()
                .find(|(_, fields)| fields.contains_key(&name))
                .map(|(from, _)| *from);
            let line = match (fields(&settings).get(&name), from) {
                (Some(value), Some(from)) => format!("{name} = {} # {from}\n", toml_value(value)),
                _ => format!("# {name} is not set\n"),
            };
            text.push_str(&line);
        }
        Ok(text)
    }
}

fn read_file(path: &Path) -> Result<Settings, Error> {
    let bytes = files::read(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let wrong = |e: toml::de::Error| Error::new(Code::InvalidDocument, format!("{}: {e}", path.display()));
    toml::from_str(&text).map_err(wrong)
}

fn fields_with_null(settings: &Settings) -> Map<String, Value> {
    match serde_json::to_value(settings) {
        Ok(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}

fn fields(settings: &Settings) -> Map<String, Value> {
    fields_with_null(settings).into_iter().filter(|(_, v)| !v.is_null()).collect()
}

fn merge(layers: &[(&str, Settings)]) -> Settings {
    let all = layers.iter().flat_map(|(_, settings)| fields(settings)).collect();
    serde_json::from_value(Value::Object(all)).expect("settings are made of settings")
}

fn toml_value(value: &Value) -> String {
    // Strings, numbers and booleans are written alike.
    value.to_string()
}

fn without_password(url: &str) -> String {
    match (url.find("://"), url.rfind('@')) {
        (Some(scheme), Some(at)) if scheme + 3 <= at => {
            let user = url[scheme + 3..at].split(':').next().unwrap_or_default();
            format!("{}{user}:***{}", &url[..scheme + 3], &url[at..])
        }
        _ => url.to_string(),
    }
}

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
        log: Some("info".to_string()),
        log_format: Some(LogFormat::Text),
    }
}

impl Settings {
    /// Where requests come in.
    pub fn address(&self) -> SocketAddr {
        self.listen.unwrap_or_else(|| SocketAddr::from(([127, 0, 0, 1], 8080)))
    }

    pub fn log_filter(&self) -> &str {
        self.log.as_deref().unwrap_or("info")
    }

    pub fn logs_json(&self) -> bool {
        self.log_format == Some(LogFormat::Json)
    }

    /// The configuration of a server or worker.
    ///
    /// # Errors
    /// A time that is none; a server without tokens that others reach.
    pub fn config(&self) -> Result<Config, Error> {
        let default = Config::default();
        let loopback = self.address().ip().is_loopback();
        let auth = self.auth.unwrap_or(Auth::Auto);
        let tokens_required = auth == Auth::On || (auth == Auth::Auto && !loopback);
        if !tokens_required && !loopback && self.open_to_anyone != Some(true) {
            let detail = format!(
                "anyone who reaches {} could use this server: it asks for no tokens",
                self.address()
            );
            return Err(Error::new(Code::Forbidden, detail)
                .with_hint("leave out --auth off and make tokens with dynident token create; or say --open-to-anyone"));
        }
        let count = |given: Option<usize>, otherwise: usize| given.unwrap_or(otherwise);
        Ok(Config {
            data: Some(self.data.clone().unwrap_or_else(|| DATA.into())),
            database_url: self.database_url.clone(),
            concurrent_jobs: count(self.concurrent_jobs, default.concurrent_jobs),
            short_jobs: count(self.short_jobs, default.short_jobs),
            shortest_long_s: self.shortest_long_s.unwrap_or(default.shortest_long_s),
            running_per_robot: self.running_per_robot,
            waiting_jobs: count(self.waiting_jobs, default.waiting_jobs),
            waiting_per_robot: count(self.waiting_per_robot, default.waiting_per_robot),
            waiting_per_token: count(self.waiting_per_token, default.waiting_per_token),
            kept_jobs: self.kept_jobs,
            lease: seconds("lease_s", self.lease_s, default.lease)?,
            longest_wait: seconds("longest_wait_s", self.longest_wait_s, default.longest_wait)?,
            longest_search_s: self.longest_search_s.unwrap_or(default.longest_search_s),
            most_joints: count(self.most_joints, default.most_joints),
            highest_order: count(self.highest_order, default.highest_order),
            most_rows: count(self.most_rows, default.most_rows),
            largest_document: count(self.largest_document, default.largest_document),
            largest_upload: count(self.largest_upload, default.largest_upload),
            requests_per_second: self.requests_per_second.or(default.requests_per_second).filter(|n| *n > 0),
            request_burst: self.request_burst.unwrap_or(default.request_burst),
            tokens_required,
            refuse_forwarded: auth == Auth::Auto,
        })
    }
}

fn seconds(name: &str, given: Option<f64>, otherwise: Duration) -> Result<Duration, Error> {
    let Some(given) = given else { return Ok(otherwise) };
    match Duration::try_from_secs_f64(given) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err(Error::new(
            Code::InvalidDocument,
            format!("the setting {name} is {given}, expected seconds above zero"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(file: &str) -> (tempfile::TempDir, Place) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("dynident.toml");
        std::fs::write(&path, file).unwrap();
        let place = Place {
            config: Some(path),
            ..Place::default()
        };
        (folder, place)
    }

    #[test]
    fn flags_go_before_the_file_and_the_file_before_defaults() {
        let (_folder, mut place) = place("waiting_jobs = 7\nlease_s = 3.5\ndatabase_url = \"postgres://me:secret@db/x\"\n");
        place.data = Some("here".into());
        let flags = Settings {
            waiting_jobs: Some(9),
            ..Settings::default()
        };
        let config = place.settings(&flags).unwrap().config().unwrap();
        assert_eq!((config.waiting_jobs, config.lease), (9, Duration::from_secs_f64(3.5)));
        assert_eq!(config.short_jobs, Config::default().short_jobs);
        let text = place.describe(&flags).unwrap();
        for line in [
            "waiting_jobs = 9 # environment or flag",
            "lease_s = 3.5 # file",
            "short_jobs = 2 # default",
            "data = \"here\" # environment or flag",
            "database_url = \"postgres://me:***@db/x\" # file",
            "# kept_jobs is not set",
        ] {
            assert!(text.lines().any(|l| l == line), "{line} not in\n{text}");
        }
        // What is printed can be read again.
        assert!(toml::from_str::<Settings>(&text).is_ok());
    }

    #[test]
    fn a_setting_that_is_none_is_named() {
        let (_folder, place) = place("waiting_job = 7\n");
        let error = place.settings(&Settings::default()).unwrap_err();
        assert!(
            error.detail.contains("waiting_job") && error.detail.contains("waiting_jobs"),
            "{error}"
        );
    }

    #[test]
    fn a_server_for_others_is_never_open_by_accident() {
        let at = |address: &str, auth: Option<Auth>, open: Option<bool>| {
            let settings = Settings {
                listen: Some(address.parse().unwrap()),
                auth,
                open_to_anyone: open,
                ..Settings::default()
            };
            settings.config().map(|c| c.tokens_required).map_err(|e| e.code)
        };
        assert_eq!(at("127.0.0.1:80", None, None), Ok(false));
        assert_eq!(at("[::1]:80", Some(Auth::On), None), Ok(true));
        assert_eq!(at("0.0.0.0:80", None, None), Ok(true));
        assert_eq!(at("0.0.0.0:80", Some(Auth::Off), None), Err(Code::Forbidden));
        assert_eq!(at("0.0.0.0:80", Some(Auth::Off), Some(true)), Ok(false));
    }
}
