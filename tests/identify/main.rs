//! From log to parameters.

#[path = "../support/mod.rs"]
mod support;

mod accelerations;
mod estimates;
mod filter;
mod formats;
mod logs;
mod paper;
mod paper_chain;
mod periods;
mod physical;
mod real;
mod simulated;
mod splits;
mod velocities;
