//! What a joint may do.

/// Limits of one joint, SI units. `None` means that nothing is known, hence nothing is constrained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Lowest and highest position [rad or m].
    pub position: Option<[f64; 2]>,
    /// Largest speed in either direction [rad/s or m/s].
    pub velocity: Option<f64>,
    /// Largest acceleration in either direction [rad/s² or m/s²].
    pub acceleration: Option<f64>,
    /// Largest jerk in either direction [rad/s³ or m/s³].
    pub jerk: Option<f64>,
    /// Largest torque or force in either direction [N·m or N].
    pub effort: Option<f64>,
}

impl Limits {
    pub fn unlimited() -> Self {
        Self {
            position: None,
            velocity: None,
            acceleration: None,
            jerk: None,
            effort: None,
        }
    }

    /// Every problem these limits have, as `(field, what is wrong)`.
    pub(super) fn problems(&self) -> Vec<(&'static str, LimitProblem)> {
        let mut found = Vec::new();
        if let Some([low, high]) = self.position {
            if !low.is_finite() || !high.is_finite() {
                found.push(("position", LimitProblem::NotFinite));
            } else if low >= high {
                found.push(("position", LimitProblem::WrongWayRound { low, high }));
            }
        }
        let magnitudes = [
            ("velocity", self.velocity),
            ("acceleration", self.acceleration),
            ("jerk", self.jerk),
            ("effort", self.effort),
        ];
        for (field, value) in magnitudes {
            match value {
                Some(v) if !v.is_finite() => found.push((field, LimitProblem::NotFinite)),
                Some(v) if v <= 0.0 => found.push((field, LimitProblem::NotPositive(v))),
                _ => {}
            }
        }
        found
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LimitProblem {
    NotFinite,
    WrongWayRound { low: f64, high: f64 },
    NotPositive(f64),
}
