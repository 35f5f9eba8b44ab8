//! The motion of a stored design.

use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde::Deserialize;

/// What of a design makes its motion.
#[derive(Deserialize)]
pub struct Motion {
    coefficients: Option<Sides>,
    offset: Option<Vec<f64>>,
    fundamental_hz: f64,
    pub sample_rate_hz: f64,
}

#[derive(Deserialize)]
struct Sides {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
}

impl Motion {
    /// `None` where the search ended without a trajectory.
    pub fn series(self) -> Option<FourierSeries> {
        let matrix = |rows: Vec<Vec<f64>>| {
            let columns = rows.first().map_or(0, Vec::len);
            DMatrix::from_row_iterator(rows.len(), columns, rows.into_iter().flatten())
        };
        let Sides { a, b } = self.coefficients?;
        Some(FourierSeries {
            fundamental_hz: self.fundamental_hz,
            a: matrix(a),
            b: matrix(b),
            offset: self.offset?,
        })
    }
}
