//! What an operator may choose.

use std::path::PathBuf;
use std::time::Duration;

/// Bounds and places of the service.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Folder of the database, logs and results. Without one a temporary folder is used that goes with the server.
    pub data: Option<PathBuf>,
    /// Address of a PostgreSQL database; SQLite in the data folder without one.
    pub database_url: Option<String>,
    /// Long searches that run at the same time. Each uses all cores, so more than one shares them. 0 leaves the work to workers.
    pub concurrent_jobs: usize,
    /// Identifications and validations that run at the same time, beside the searches; with at least one place for them there is
    /// one for searches that are not long. 0 leaves the work to workers.
    pub short_jobs: usize,
    /// Program that is started for the work of jobs and requests, as `PROGRAM child`. `None` does it on threads of this process,
    /// which an abort or an endless loop takes with it.
    pub program: Option<PathBuf>,
    /// Memory that one job or request may take (bytes); half of that of the machine, or of its container, if `None`.
    pub job_memory: Option<u64>,
    /// Time that an identification or a validation may take, and a search beside its own limit.
    pub job_time: Duration,
    /// A search that may take longer than this is long (s).
    pub shortest_long_s: f64,
    /// Jobs of one robot that run at the same time, long searches, others, and the rest each; `None` for no bound.
    pub running_per_robot: Option<usize>,
    /// Jobs that may wait, of each of these; further ones are refused with `too_many_jobs`.
    pub waiting_jobs: usize,
    /// Jobs of one robot that may wait, of each of these.
    pub waiting_per_robot: usize,
    /// Jobs of one token that may wait, of each of these.
    pub waiting_per_token: usize,
    /// Ended jobs whose results are kept; the oldest go first. `None` keeps all.
    pub kept_jobs: Option<usize>,
    /// Time after which a job is given to another worker when its own is not heard of.
    pub lease: Duration,
    /// Longest time that `Prefer: wait` holds an answer back.
    pub longest_wait: Duration,
    /// Longest search that may be asked for (s).
    pub longest_search_s: f64,
    /// Most joints of a robot.
    pub most_joints: usize,
    /// Highest order of a Fourier series.
    pub highest_order: usize,
    /// Most rows of a log.
    pub most_rows: usize,
    /// Largest document accepted (bytes). URDF files with many links reach a few hundred kilobytes.
    pub largest_document: usize,
    /// Largest multipart body accepted, all its logs together (bytes). Two hours of seven joints at 1 kHz are 1.3 GB of text.
    pub largest_upload: usize,
    /// Requests that one client (a known token, else the address that the connection comes from) may make per second over a
    /// longer time; `None` for no bound.
    pub requests_per_second: Option<u64>,
    /// Requests that it may make at once.
    pub request_burst: u32,
    /// Whether every request needs a bearer token.
    pub tokens_required: bool,
    /// Names of hosts, with a port where it is not the usual one, under which a server without tokens is reached, beside
    /// addresses in numbers and `localhost`.
    pub allowed_hosts: Vec<String>,
    /// Connections that are open at the same time; further ones wait. Fewer where the limit on open files says so.
    pub most_connections: usize,
    /// Time in which the header of a request has to be complete, and in which a connection that is kept open has to have its next
    /// request.
    pub header_timeout: Duration,
    /// Time after which a body that stops coming in, or an answer that is not taken, ends the connection.
    pub idle_timeout: Duration,
    /// Whether requests that came through a proxy are refused: right for a server that is open because it serves its own machine
    /// only.
    pub refuse_forwarded: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            data: None,
            database_url: None,
            concurrent_jobs: 1,
            short_jobs: 2,
            program: None,
            job_memory: None,
            // The largest log, two hours of seven joints at 1 kHz, takes some minutes.
            job_time: Duration::from_secs(1800),
            shortest_long_s: 5.0,
            running_per_robot: None,
            waiting_jobs: 1000,
            waiting_per_robot: 200,
            waiting_per_token: 500,
            kept_jobs: None,
            lease: Duration::from_secs(15),
            longest_wait: Duration::from_secs(600),
            longest_search_s: 86_400.0,
            most_joints: 32,
            highest_order: 50,
            // Two hours at 1 kHz, as for the largest upload.
            most_rows: 7_200_000,
            largest_document: 8 << 20,
            largest_upload: 2 << 30,
            requests_per_second: Some(100),
            request_burst: 1000,
            tokens_required: false,
            allowed_hosts: Vec::new(),
            most_connections: 1000,
            header_timeout: Duration::from_secs(30),
            idle_timeout: Duration::from_secs(60),
            refuse_forwarded: true,
        }
    }
}
