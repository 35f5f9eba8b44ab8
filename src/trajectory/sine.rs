//! The paper's second validation trajectory: a sum of sines with free frequencies.

use super::Trajectory;

/// `q_i(t) = Σ_l a_il sin(b_il t)`.
#[derive(Debug, Clone, PartialEq)]
pub struct SineSeries {
    /// `(amplitude [rad or m], angular frequency [rad/s])` of every term of every joint.
    pub terms: Vec<Vec<(f64, f64)>>,
    /// Length (s).
    pub duration: f64,
}

impl Trajectory for SineSeries {
    fn joints(&self) -> usize {
        self.terms.len()
    }

    fn duration(&self) -> f64 {
        self.duration
    }

    fn state(&self, joint: usize, t: f64) -> [f64; 3] {
        self.terms[joint].iter().fold([0.0; 3], |[q, qd, qdd], &(amplitude, w)| {
            let (s, c) = (w * t).sin_cos();
            [q + amplitude * s, qd + amplitude * w * c, qdd - amplitude * w * w * s]
        })
    }
}
