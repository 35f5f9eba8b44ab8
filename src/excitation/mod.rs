//! Excitation trajectories: the Fourier series that makes all base parameters visible, within every limit.
//!
//! [`Problem`] is what is asked, [`search`] solves it, [`Design`] is the answer. The paper's section 3.3 and (12)–(14), corrected.

mod course;
mod criterion;
mod descent;
mod epoch;
mod evaluator;
mod gauge;
mod margins;
mod moves;
mod path;
mod pool;
mod problem;
mod report;
mod search;
mod space;
mod symmetry;
mod variables;
mod workspace;

pub use criterion::Criteria;
pub use margins::{Margin, Quantity, margins};
pub use path::{DEFAULT_SAFETY_FACTOR, TorqueLimits};
pub use pool::Point;
pub use problem::{Criterion, Form, Problem, ProblemSpec, Start};
pub use report::{Design, Outcome, Predicted, StartReport, assess};
pub use search::{Control, Found, Halt, Progress, SearchOptions, search, search_from};
pub use space::{Clearance, DEFAULT_CLEARANCE_M, HalfSpace, Obstacle, SelfCollision, SpaceLimits};
