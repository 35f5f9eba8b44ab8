//! Torque that is not the same all through a log, whatever the robot does: a level that drifts with time, or that differs from
//! period to period. No effect of the list is of that kind, so it is never a finding; it is a remainder that depends on `time` or
//! on `period`.
//!
//! Deviations of the periods from their mean need no model of the robot. A level of joint j is `g(t)` on its rows, with g one of
//! a few smooth courses over the log, or a constant of its own in every period. Both are held against the noise from row to row.

/// What a level goes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Along {
    Time,
    Period,
    /// Friction, which changes with time.
    FrictionOverTime,
}

impl Along {
    /// As in [`Remainder::depends_on`](super::Remainder::depends_on).
    pub fn name(self) -> &'static str {
        match self {
            Along::Time | Along::FrictionOverTime => "time",
            Along::Period => "period",
        }
    }
}

/// A level that is not the same all through the log, on one joint.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    pub joint: usize,
    pub along: Along,
    /// BIC difference: the decrease of the weighted sum of squares of the deviations, less what parameters and courses tried
    /// cost.
    pub evidence: f64,
    /// Chance of the gain without it, times the number of hypotheses tried.
    pub p_value: f64,
    /// Its torque without its mean over the log [N·m or N]; P × M.
    pub torque: Vec<Vec<f64>>,
}

impl Level {
    /// RMS over the log [N·m or N].
    pub fn rms(&self) -> f64 {
        let count = self.torque.iter().map(Vec::len).sum::<usize>().max(1);
        (self.torque.iter().flatten().map(|v| v * v).sum::<f64>() / count as f64).sqrt()
    }

    /// Takes the level out of the torque of its joint.
    pub fn take_out(&self, periods: &mut [Vec<Vec<f64>>]) {
        self.add(periods, -1.0);
    }

    /// What [`take_out`](Self::take_out) took.
    pub fn put_back(&self, periods: &mut [Vec<Vec<f64>>]) {
        self.add(periods, 1.0);
    }

    fn add(&self, periods: &mut [Vec<Vec<f64>>], factor: f64) {
        for (period, own) in periods.iter_mut().zip(&self.torque) {
            period[self.joint].iter_mut().zip(own).for_each(|(t, v)| *t += factor * v);
        }
    }
}
