//! From a log to motion and torque on one grid.
//!
//! 1. The period is taken from the request, or from the data ([`detect_period`]); the stretch that really repeats is cut into
//!    whole periods, whose mean is kept and whose scatter is the noise, measured without any model ([`Scatter`]).
//! 2. Derivatives: a log that repeats is a Fourier series, which is cut where it sinks into the noise and differentiated exactly.
//!    A log that does not is low-pass filtered without delay and differenced.
//! 3. Torque and regressor columns then go through one and the same [`RowFilter`].

mod autocorrelation;
mod average;
mod cutoff;
mod error;
pub mod filter;
mod fourier_fit;
mod keep_peaks;
mod log;
mod motion_error;
mod options;
mod period;
mod prepare;
mod prepared;
mod row_filter;
pub(crate) mod spectrum;
mod torque_column;

pub use average::{Periods, Scatter};
pub use cutoff::signal_cutoff;
pub use error::PreprocessError;
pub use keep_peaks::keep_peaks;
pub use log::Log;
pub use motion_error::MotionError;
pub use options::{Choice, FilterSpec, Method, Period, PreprocessOptions};
pub use period::detect_period;
pub use prepare::{prepare, prepare_until};
pub use prepared::PreparedLog;
pub use row_filter::RowFilter;
pub use torque_column::Exclusion;
pub(crate) use torque_column::{exclusions, resolution, rounded_alike, step_of};
