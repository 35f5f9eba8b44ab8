//! One file per resource: handlers with their documentation; `common` is what they share of that.

pub mod archive;
pub mod common;
pub mod effects;
pub mod excitation;
pub mod health;
pub mod identify;
pub mod inspect;
pub mod jobs;
pub mod motion;
pub mod query;
pub mod report;
pub mod results;
pub mod robots;
