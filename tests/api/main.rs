//! The service as its clients meet it: a real server on a free port, a real HTTP client.

#[path = "../support/server.rs"]
mod server;

mod bad_input;
mod degenerate;
mod designs;
mod effects;
mod identify;
mod identify_faults;
mod identify_logs;
mod jobs;
mod log_formats;
mod openapi;
mod pages;
mod python;
mod queue;
mod readme;
mod robot_files;
mod robots;
mod runs;
mod security;
mod tokens;
