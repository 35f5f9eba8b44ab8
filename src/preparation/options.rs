//! What can be asked of preprocessing.

use crate::model::readable;

impl PreprocessOptions {
    /// For a log of perhaps another trajectory, such as a validation log: a stated period is expected and not imposed.
    pub fn for_other_log(&self) -> Self {
        let period = match self.period {
            Period::Known { period_s, order } => Period::Expected { period_s, order },
            other => other,
        };
        Self { period, ..self.clone() }
    }
}

/// How a log becomes rows of the observation matrix. The default decides everything from the data and says why.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PreprocessOptions {
    /// What is known of the period.
    pub period: Period,
    /// How derivatives are made.
    pub method: Method,
    /// Zero-phase low-pass on positions before differences are taken (not used by the Fourier fit).
    pub position_filter: Option<FilterSpec>,
    /// Zero-phase low-pass on torques; with [`Method::ParallelFilter`] on every regressor column as well.
    pub torque_filter: Option<FilterSpec>,
    /// Highest cut-off of the row filter of a log that does not repeat, where no filter is given (Hz): that of the logs that a
    /// model is made from, for those that it is held against. What the fit never saw is no error of the model.
    pub band_hz: Option<f64>,
    /// Time dropped at both ends of a record that was filtered and does not repeat (s).
    pub discard_edges_s: Option<f64>,
    /// Every how-manieth row is kept.
    pub decimation: Option<usize>,
    /// Speed below which a joint's rows are left out, because the sign of its velocity is not known there [rad/s or m/s].
    pub dead_zone: Option<f64>,
}

/// The paper's chain (section 4.3): average over periods, order 20 at 2 Hz on positions, order 12 at 1.6 Hz on torques, central
/// differences.
impl PreprocessOptions {
    /// The published preparation (section 4.3) of a log of this period.
    pub fn paper(period_s: f64) -> Self {
        Self {
            period: Period::Known { period_s, order: None },
            method: Method::Paper,
            ..Self::default()
        }
    }
}

/// What is known of the period of a log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Period {
    /// From the positions' autocorrelation.
    #[default]
    Detect,
    /// Stated by the request or by the excitation, whose highest harmonic is `order`.
    Known {
        /// The period (s).
        period_s: f64,
        /// Highest harmonic of the excitation, where known.
        order: Option<usize>,
    },
    /// That of another log of the same request: taken where this one repeats with it, else found, and no error where there is
    /// none.
    Expected {
        /// The period (s).
        period_s: f64,
        /// Highest harmonic of the excitation, where known.
        order: Option<usize>,
    },
    /// The log is taken as one stretch.
    None,
}

/// How velocities and accelerations are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Fourier fit where the log repeats, parallel filter otherwise.
    #[default]
    Automatic,
    /// Average over periods, derivatives from the harmonics that stand above the noise, torque as it is.
    FourierFit,
    /// One zero-phase filter for torque and every regressor column alike (Gautier's parallel filtering), then decimation.
    ParallelFilter,
    /// See [`PreprocessOptions::paper`].
    Paper,
}

/// Butterworth, run forwards and backwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterSpec {
    /// Order of the Butterworth filter.
    pub order: usize,
    /// Frequency at which half of the power is left (Hz).
    pub cutoff_hz: f64,
}

/// One decision of preprocessing, for the answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// What was chosen.
    pub what: &'static str,
    /// The choice.
    pub value: String,
    /// The reason.
    pub why: String,
}

impl Choice {
    /// A choice with its reason.
    pub fn new(what: &'static str, value: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            what,
            value: readable(value),
            why: readable(why),
        }
    }
}
