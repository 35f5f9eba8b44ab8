//! A measured record, uniform in time: what reading a file gives and preprocessing takes.

use crate::dynamics::Channel;

/// Positions and torques of all joints at a uniform rate. Every inner vector has the same length N.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The file's name, or whatever the user calls it.
    pub name: String,
    /// Sampling rate (Hz).
    pub rate_hz: f64,
    /// Time of the first sample on the log's own clock (s).
    pub start_s: f64,
    /// Per joint [rad or m].
    pub q: Vec<Vec<f64>>,
    /// Per joint [rad/s or m/s], where the log has velocities.
    pub qd: Option<Vec<Vec<f64>>>,
    /// Per joint [N m or N].
    pub tau: Vec<Vec<f64>>,
    /// False where a gap in the record had to be bridged: the values there are interpolated and are not data.
    pub usable: Vec<bool>,
    /// Further quantities; none where the request names none.
    pub channels: Vec<Channel>,
}

impl Log {
    /// Number of joints n.
    pub fn joints(&self) -> usize {
        self.q.len()
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.usable.len()
    }

    /// Samples over the rate (s).
    pub fn duration_s(&self) -> f64 {
        self.samples() as f64 / self.rate_hz
    }

    /// The part of the log in `range` of samples.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Self {
        let cut = |columns: &[Vec<f64>]| columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        Self {
            name: self.name.clone(),
            rate_hz: self.rate_hz,
            start_s: self.start_s + range.start as f64 / self.rate_hz,
            q: cut(&self.q),
            qd: self.qd.as_deref().map(cut),
            tau: cut(&self.tau),
            usable: self.usable[range.clone()].to_vec(),
            channels: self.channels.iter().map(|c| c.with(&c.values[range.clone()])).collect(),
        }
    }
}
