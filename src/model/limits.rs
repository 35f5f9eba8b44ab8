//! What a joint may do.

use super::shortest;

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
    /// No limit on anything.
    pub fn unlimited() -> Self {
        Self {
            position: None,
            velocity: None,
            acceleration: None,
            jerk: None,
            effort: None,
        }
    }

    /// The limits without those that nobody meant, and what was dropped, in words.
    ///
    /// Programs that must write something where there is no limit write 1e16, 10000 rad or [0, 0]. What no joint can reach limits
    /// nothing. A position within reach but in degrees is left in place, so that it is refused. `is_of_file`: a URDF file, where
    /// zero and negative magnitudes stand for none too, and so does a speed beyond any joint's beside a position in radians.
    pub fn without_placeholders(self, is_revolute: bool, is_of_file: bool) -> (Self, Vec<String>) {
        let mut dropped = Vec::new();
        let mut kept = self;
        if let Some([low, high]) = self.position {
            let reached = low > -BEYOND_ANY_POSITION && high < BEYOND_ANY_POSITION;
            let outside = low <= -BEYOND_ANY_POSITION && high >= BEYOND_ANY_POSITION;
            if outside || (reached && is_of_file && low == 0.0 && high == 0.0) {
                kept.position = None;
                dropped.push(format!(
                    "the position limits [{}, {}] are taken as none",
                    said(low),
                    said(high)
                ));
            }
        }
        let top = if is_revolute && is_of_file {
            FASTEST_REVOLUTE
        } else {
            BEYOND_ANY_SPEED
        };
        let in_degrees = is_revolute
            && kept
                .position
                .is_some_and(|[low, high]| low.abs().max(high.abs()) > LARGEST_REVOLUTE);
        let mut drop = |name: &str, value: &mut Option<f64>, most: f64| {
            if let Some(v) = value.take_if(|v| *v >= most || (is_of_file && *v <= 0.0)) {
                dropped.push(format!("the {name} limit {} is taken as none", said(v)));
            }
        };
        if !in_degrees {
            drop("velocity", &mut kept.velocity, top);
        }
        drop("effort", &mut kept.effort, BEYOND_ANY_EFFORT);
        drop("acceleration", &mut kept.acceleration, BEYOND_ANY_ACCELERATION);
        drop("jerk", &mut kept.jerk, BEYOND_ANY_ACCELERATION);
        (kept, dropped)
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

/// A revolute joint that turns freely has ±2π, dress-pack windings reach a few turns; five turns (rad) are beyond any arm.
pub(super) const LARGEST_REVOLUTE: f64 = 31.5;
/// 40 rad/s (382 rev/min) is beyond any joint behind a gear.
pub(super) const FASTEST_REVOLUTE: f64 = 40.0;
/// 160 turns or a kilometre; the largest number in degrees on a data sheet is 720.
pub(super) const BEYOND_ANY_POSITION: f64 = 1000.0;
/// Three times the speed of sound (m/s).
const BEYOND_ANY_SPEED: f64 = 1000.0;
/// A hundred times the strongest joint of the largest industrial arms [N·m or N].
const BEYOND_ANY_EFFORT: f64 = 1e6;
/// [rad/s² or m/s²], and the same for jerk with its third power of time.
const BEYOND_ANY_ACCELERATION: f64 = 1e9;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LimitProblem {
    NotFinite,
    WrongWayRound { low: f64, high: f64 },
    NotPositive(f64),
}

/// A limit as a file has it; a file can say `inf`, which is said in words.
fn said(limit: f64) -> String {
    if limit.is_finite() {
        format!("{limit:?}")
    } else {
        shortest(limit)
    }
}
