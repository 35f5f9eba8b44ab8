//! From log to parameters.

#[path = "../support/mod.rs"]
mod support;

mod estimates;
mod filter;
mod logs;
mod periods;
mod simulated;
