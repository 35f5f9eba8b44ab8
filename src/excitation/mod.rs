//! Excitation trajectories: the Fourier series that makes all base parameters visible, within every limit.
//!
//! [`Problem`] is what is asked, [`search`] solves it, [`Design`] is the answer. The paper's section 3.3 and (12)–(14),
//! corrected.

mod added;
mod backoff;
mod course;
mod criterion;
mod descent;
mod eigen;
mod epoch;
mod evaluator;
mod extremes;
mod gauge;
mod margins;
mod moves;
mod path;
mod pool;
mod postures;
mod problem;
mod report;
mod rivals;
mod run_in;
mod search;
mod space;
mod symmetry;
mod torque_proof;
mod variables;
mod workspace;

pub use added::{Added, AddedColumn, AddedColumns, Course};
pub use backoff::{Backoff, FirstRun, first_run};
pub use criterion::Criteria;
pub use margins::{Margin, Quantity, margins};
pub use path::{DEFAULT_SAFETY_FACTOR, TorqueLimits};
pub use pool::Point;
pub use problem::{Criterion, Form, Given, Knowledge, Problem, ProblemSpec, Start};
pub use report::{Design, Outcome, Predicted, RivalReport, StartReport, assess};
pub use rivals::{ExpectedEvidence, Hypothesis, Rivals};
pub use run_in::{LONGEST_RUN_IN_S, NoRun, RunSpec, run_in, run_out};
pub use search::{Control, Found, Halt, Progress, SearchOptions, random_design, search, search_from};
pub use space::{Clearance, DEFAULT_CLEARANCE_M, HalfSpace, Obstacle, SelfCollision, SpaceLimits};
