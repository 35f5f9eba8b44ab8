//! Excitation trajectories.

mod criterion;
mod evaluator;
mod gauge;
mod margins;
mod problem;
mod report;
pub mod search;
mod solver;
mod workspace;
mod variables;
pub mod experiment;

pub use criterion::Criteria;
pub use problem::{Criterion, Form, Problem, ProblemSpec, Start};
