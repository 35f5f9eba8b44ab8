//! Agreement with outside references: an independent rigid-body library and published tables.

#[path = "../support/mod.rs"]
mod support;

mod dynamics;
mod model_files;
mod robots;
