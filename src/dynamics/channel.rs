//! What is measured beside positions and torques.

use std::sync::Arc;

/// A further quantity along a motion: a temperature, a pressure, a current.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name in formulas, as the request has it.
    pub name: Arc<str>,
    /// Unit of the values, as the request has it.
    pub unit: Arc<str>,
    /// One value per sample, in that unit.
    pub values: Arc<[f64]>,
}

impl Channel {
    /// From its name, its unit and one value per sample.
    pub fn new(name: &str, unit: &str, values: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            values: values.into(),
        }
    }

    /// The same quantity over other samples.
    pub fn with(&self, values: &[f64]) -> Self {
        Self {
            values: values.into(),
            ..self.clone()
        }
    }
}
