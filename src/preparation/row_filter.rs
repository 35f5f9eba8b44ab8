//! What torque and regressor columns go through on their way into least squares.

use crate::preparation::filter::{LowPass, Padding, zero_phase_rows};

/// Filter, ends and decimation. Parallel filtering has the same filter in both places; the paper filters torque alone.
#[derive(Debug, Clone, PartialEq)]
pub struct RowFilter {
    /// What torques go through.
    pub torque: Option<LowPass>,
    /// What columns of the model go through.
    pub columns: Option<LowPass>,
    /// How the filters begin and end.
    pub padding: Padding,
    /// Samples dropped at both ends.
    pub edges: usize,
    /// Every how-manieth sample becomes a row; at least 1.
    pub decimation: usize,
}

impl RowFilter {
    /// Samples go into rows as they are.
    pub fn none() -> Self {
        Self {
            torque: None,
            columns: None,
            padding: Padding::Odd,
            edges: 0,
            decimation: 1,
        }
    }

    /// Whether every sample of a regressor column becomes a row as it is.
    pub fn takes_all(&self) -> bool {
        self.columns.is_none() && self.edges == 0 && self.decimation == 1
    }

    /// The samples that become rows, of a record of `samples`.
    pub fn rows(&self, samples: usize) -> impl ExactSizeIterator<Item = usize> + Clone + use<> {
        let edges = self.edges.min(samples / 2);
        (edges..samples - edges).step_by(self.decimation)
    }

    /// Rows of torque signals of N samples each.
    pub fn torque_rows(&self, signals: &[&[f64]]) -> Vec<Vec<f64>> {
        self.pass(self.torque.as_ref(), signals)
    }

    /// Rows of regressor or effect columns of N samples each.
    pub fn column_rows(&self, columns: &[&[f64]]) -> Vec<Vec<f64>> {
        self.pass(self.columns.as_ref(), columns)
    }

    fn pass(&self, filter: Option<&LowPass>, records: &[&[f64]]) -> Vec<Vec<f64>> {
        let Some(samples) = records.first().map(|x| x.len()) else {
            return Vec::new();
        };
        let rows = self.rows(samples);
        match filter {
            Some(filter) => zero_phase_rows(filter, records, self.padding, filter.settling_samples(), rows),
            None => records.iter().map(|x| rows.clone().map(|s| x[s]).collect()).collect(),
        }
    }
}
