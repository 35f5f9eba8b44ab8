//! Columns that stand beside the regressor's: of effects the declared model lacks.
//!
//! What they are is the business of whoever hands them in ([`AddedColumns`]); here they join `Y_b` in the Gram matrix, and its
//! derivative is taken back through them to the motion. Columns of one sample's state are differenced variable by variable, all
//! samples at once; columns that look at other samples are differenced coefficient by coefficient of the series.

mod beside;
#[cfg(test)]
mod tests;

pub(super) use beside::Beside;

use crate::dynamics::{Coulomb, Motion};
use std::fmt::Debug;
use std::sync::Arc;

/// One stretch of motion that columns are evaluated along.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a> {
    /// The motion of the candidate trajectory.
    pub motion: &'a Motion,
    /// Time between samples (s).
    pub interval: f64,
    /// Whether the sample after the last is the first.
    pub periodic: bool,
    /// How the sign of friction is taken at reversals.
    pub coulomb: Coulomb,
}

/// The torque per unit of one parameter: rows of the joints named, zero on all others.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedColumn {
    /// From 0.
    pub at: usize,
    /// `(joint, value at every sample)` [N·m or N per unit of the parameter].
    pub rows: Vec<(usize, Vec<f64>)>,
}

/// A source of columns, in groups that are evaluated together.
pub trait AddedColumns: Debug + Send + Sync {
    /// Columns of all groups.
    fn count(&self) -> usize;

    /// Groups of columns, each computed in one go.
    fn groups(&self) -> usize;

    /// The columns of a group along `course`.
    fn columns(&self, group: usize, course: &Course) -> Vec<AddedColumn>;

    /// Joints whose motion changes the columns of a group.
    fn joints(&self, group: usize) -> Vec<usize>;

    /// Whether a sample's values depend on that sample's state alone.
    fn is_local(&self, group: usize) -> bool;
}

/// A shared source of columns; equal when it is the same one.
#[derive(Debug, Clone)]
pub struct Added(pub Arc<dyn AddedColumns>);

impl PartialEq for Added {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Added {
    /// Every column along a motion.
    pub(super) fn along(&self, course: &Course) -> Vec<AddedColumn> {
        (0..self.0.groups()).flat_map(|g| self.0.columns(g, course)).collect()
    }
}
