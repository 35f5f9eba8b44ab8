//! The configuration of a server or worker that settings make.

use super::{Auth, DATA, LogFormat, Settings};
use crate::app::{Code, Error};
use crate::service::Config;
use axum::http::uri::Authority;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

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
            program: self.isolate.unwrap_or(true).then(own_program),
            job_memory: self.job_memory,
            job_time: seconds("job_time_s", self.job_time_s, default.job_time)?,
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
            allowed_hosts: hosts(self.allowed_hosts.clone().unwrap_or_default())?,
            most_connections: self.most_connections.unwrap_or(default.most_connections).max(1),
            header_timeout: seconds("header_timeout_s", self.header_timeout_s, default.header_timeout)?,
            idle_timeout: seconds("idle_timeout_s", self.idle_timeout_s, default.idle_timeout)?,
            refuse_forwarded: auth == Auth::Auto,
        })
    }
}

/// Names as they stand in a `Host` header.
fn hosts(names: Vec<String>) -> Result<Vec<String>, Error> {
    let is_host = |name: &str| !name.is_empty() && !name.contains(['/', '@', '*', ' ']) && name.parse::<Authority>().is_ok();
    match names.iter().find(|name| !is_host(name)) {
        None => Ok(names),
        Some(wrong) => {
            let detail = format!("the setting allowed_hosts has `{wrong}`, which is no name of a host");
            Err(Error::new(Code::InvalidDocument, detail).with_hint("names are like dynident.example.org or lab-pc:8443"))
        }
    }
}

/// This program, also after its file was replaced by that of another version.
fn own_program() -> PathBuf {
    let running = PathBuf::from("/proc/self/exe");
    match running.exists() {
        true => running,
        false => std::env::current_exe().unwrap_or_else(|_| PathBuf::from("dynident")),
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
