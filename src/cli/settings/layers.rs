//! Where settings come from: defaults, a file, the environment or flags; the last that says something counts.

use super::{Settings, defaults};
use crate::app::{Code, Error};
use crate::cli::files;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::Config;
    use std::time::Duration;

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
}
