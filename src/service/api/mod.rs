//! One file per resource: handlers with their documentation.

pub mod excitation;
pub mod health;
pub mod identify;
pub mod jobs;
pub mod pages;
pub mod query;
pub mod results;
pub mod robots;
pub mod schemas;
