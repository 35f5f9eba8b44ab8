//! The paper's third and fourth validation trajectories: fifth-order polynomials through way-points.

use super::Trajectory;

/// From way-point to way-point with `10 s³ − 15 s⁴ + 6 s⁵`, s = t/T: at rest, without acceleration, at every way-point.
///
/// The paper prints the end point `D^k` as the factor of the polynomial; reaching `D^k` from `D^{k−1}` takes their difference, as
/// here.
#[derive(Debug, Clone, PartialEq)]
pub struct QuinticWayPoints {
    /// K + 1 positions of n joints [rad or m].
    way_points: Vec<Vec<f64>>,
    /// Times of the way-points (s), from 0.
    times: Vec<f64>,
}

impl QuinticWayPoints {
    /// `way_points`: K + 1 rows of n; `durations`: K positive lengths (s).
    ///
    /// # Panics
    /// When there is no segment, counts do not fit, or a duration is not positive.
    pub fn new(way_points: Vec<Vec<f64>>, durations: &[f64]) -> Self {
        assert!(
            !durations.is_empty() && way_points.len() == durations.len() + 1,
            "K + 1 way-points for K durations"
        );
        assert!(durations.iter().all(|&d| d > 0.0), "durations are positive");
        assert!(
            way_points.iter().all(|w| w.len() == way_points[0].len()),
            "every way-point has all joints"
        );
        let mut times = vec![0.0];
        times.extend(durations.iter().scan(0.0, |t, d| {
            *t += d;
            Some(*t)
        }));
        Self { way_points, times }
    }
}

impl Trajectory for QuinticWayPoints {
    fn joints(&self) -> usize {
        self.way_points[0].len()
    }

    fn duration(&self) -> f64 {
        *self.times.last().expect("at least one segment")
    }

    fn state(&self, joint: usize, t: f64) -> [f64; 3] {
        let last = self.times.len() - 2;
        let k = self.times.partition_point(|&start| start <= t).saturating_sub(1).min(last);
        let length = self.times[k + 1] - self.times[k];
        let s = ((t - self.times[k]) / length).clamp(0.0, 1.0);
        let from = self.way_points[k][joint];
        let step = self.way_points[k + 1][joint] - from;
        [
            from + step * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
            step * 30.0 * s * s * (1.0 - s) * (1.0 - s) / length,
            step * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (length * length),
        ]
    }
}
