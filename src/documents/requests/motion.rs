//! What a robot looks like, and what a motion asks of it.

use super::robot::RobotOrName;
use crate::documents::Coefficients;
use serde::{Deserialize, Serialize};

/// A robot, and a Fourier series to move it by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MotionRequest {
    /// The robot, in full or by name.
    pub robot: RobotOrName,
    /// The trajectory; left out, the robot is described at rest.
    pub trajectory: Option<Series>,
    /// Samples of one period, its end included.
    #[cfg_attr(feature = "service", schema(default = 1000, minimum = 2, maximum = 20000))]
    pub samples: Option<u32>,
}

/// As in the answer of `POST /excitation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Series {
    /// Fundamental frequency (Hz).
    #[cfg_attr(feature = "service", schema(exclusive_minimum = 0))]
    pub fundamental_hz: f64,
    /// Fourier coefficients.
    pub coefficients: Coefficients,
    /// Constant part q0, one value per joint [rad or m].
    pub offset: Vec<f64>,
}
