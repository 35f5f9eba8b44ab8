//! dynident
pub mod app;
#[cfg(feature = "cli")]
pub mod cli;
pub mod dynamics;
pub mod excitation;
pub mod io;
pub mod model;
pub mod parameters;
#[cfg(feature = "service")]
pub mod service;
pub mod spatial;
pub mod trajectory;
