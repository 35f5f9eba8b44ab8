//! From log to parameters.

#[path = "../support/mod.rs"]
mod support;

mod estimates;
mod filter;
mod logs;
mod paper;
mod periods;
mod physical;
mod real;
mod simulated;
mod velocities;
