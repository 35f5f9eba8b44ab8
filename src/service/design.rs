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
    /// Names of the joints.
    #[serde(default)]
    pub joints: Vec<String>,
    /// Trajectories that complement the first.
    #[serde(default)]
    further: Vec<Further>,
}

#[derive(Deserialize)]
struct Further {
    coefficients: Sides,
    offset: Vec<f64>,
    fundamental_hz: f64,
}

#[derive(Deserialize)]
struct Sides {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
}

impl Motion {
    /// `None` where the search ended without a trajectory.
    pub fn series(self) -> Option<FourierSeries> {
        Some(series(self.coefficients?, self.offset?, self.fundamental_hz))
    }

    /// The trajectory at this place among those that complement each other.
    pub fn series_at(mut self, index: usize) -> Option<FourierSeries> {
        let Some(further) = index.checked_sub(1) else {
            return self.series();
        };
        (further < self.further.len()).then(|| {
            let Further {
                coefficients,
                offset,
                fundamental_hz,
            } = self.further.swap_remove(further);
            series(coefficients, offset, fundamental_hz)
        })
    }

    /// Trajectories in all.
    pub fn count(&self) -> usize {
        usize::from(self.coefficients.is_some()) + self.further.len()
    }
}

fn series(Sides { a, b }: Sides, offset: Vec<f64>, fundamental_hz: f64) -> FourierSeries {
    let matrix = |rows: Vec<Vec<f64>>| {
        let columns = rows.first().map_or(0, Vec::len);
        DMatrix::from_row_iterator(rows.len(), columns, rows.into_iter().flatten())
    };
    FourierSeries {
        fundamental_hz,
        a: matrix(a),
        b: matrix(b),
        offset,
    }
}
