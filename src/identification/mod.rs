//! From measured motion and torque to the parameters of the robot.
//!
//! ```text
//! Log ── prepare ──▶ PreparedLog ── Observation::new ──▶ rows per joint ── estimate ──▶ Estimate
//! ```
//!
//! [`prepare`] averages periods, takes derivatives and measures the noise; [`Observation`] is the paper's (8), one block per joint,
//! to which further columns may be added ([`Observation::push_column`]); [`estimate`] solves (9) and says how far the answer can be
//! trusted.

mod cancel;
mod explained;
pub mod filter;
mod least_squares;
mod log;
mod noise;
mod normal;
mod observation;
pub mod physical;
pub mod preprocess;
mod quality;
mod robust;
mod solution;
mod tail;
mod thin;
mod validation;

pub use cancel::{CancelFlag, Cancelled};
pub use explained::{Explained, explained};
pub(crate) use explained::{folds_both_ways, folds_in_time, shares, with_constant};
pub use least_squares::{Estimate, Estimator, JointFit, estimate};
pub use log::Log;
pub use noise::NoiseSpectrum;
pub use normal::{JointNormal, normal_equations};
pub use observation::{JointRows, Observation};
pub use preprocess::{PreparedLog, PreprocessOptions, prepare, prepare_until, signal_cutoff};
pub use quality::{Quality, Verdict, quality};
pub use solution::{RANK_TOLERANCE, Solution};
pub(crate) use tail::{chi_square_tail, f_tail};
pub use thin::keep_peaks;
pub use validation::{PredictionSeries, Validation, predictions, validate};
