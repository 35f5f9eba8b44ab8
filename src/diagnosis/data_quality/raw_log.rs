//! A log as recorded.

/// A log as recorded: rows in the order of the file, before anything is repaired.
#[derive(Debug, Clone, PartialEq)]
pub struct RawLog {
    /// (s); empty where the log has none.
    pub time: Vec<f64>,
    /// Per joint.
    pub q: Vec<Vec<f64>>,
    /// Per joint.
    pub tau: Vec<Vec<f64>>,
}
