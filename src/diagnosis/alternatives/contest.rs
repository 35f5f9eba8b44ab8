//! The rivals of one effect.

use crate::diagnosis::report::Rival;
use crate::regression::Term;
use nalgebra::DVector;

/// The other effects that the data do not exclude in the place of one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Contest {
    pub rivals: Vec<Rival>,
    /// Of every rival its fitted term, and the base parameters beside it.
    pub fitted: Vec<(Term, DVector<f64>)>,
    pub note: Option<String>,
}
