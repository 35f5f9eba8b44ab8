//! Physical parameters: masses, centres of mass and inertias that a simulator accepts and that fit the log.
//!
//! Least squares determines base parameters; the standard parameters behind them are open along the null space of K, and the best fit
//! may be no body at all (the paper's Table 2 has negative inertias). [`fit_consistent`] is least squares over the standard parameters with
//! every link's pseudo-inertia positive definite, which is physical consistency in full and nothing beyond it (Traversaro et al. 2016,
//! Wensing et al. 2018). Convex: the answer is the global one.

mod consistent;
mod margins;
mod objective;
mod prior;

pub use consistent::{ConsistentOptions, LinkBounds, fit_consistent};
pub use margins::{Constraint, ConstraintMargin, margins};
pub use objective::{FitObjective, FitRms};
pub use prior::{LinkScale, priors, rod_prior};

use crate::parameters::{Layout, ParameterKind};
use crate::spatial::PhysicalInertia;

/// A set of standard parameters that are a physical robot, and how well they fit.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicalFit {
    /// Standard parameters in the order of [`Layout::standard`], then any columns added to the observation (offsets).
    pub values: Vec<f64>,
    pub fit: FitRms,
    pub margins: Vec<ConstraintMargin>,
    pub ending: FitEnding,
    /// Iterations of the solver, over all starts.
    pub iterations: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitEnding {
    Converged,
    /// Solved to a looser tolerance than asked for.
    Stalled,
    BudgetExhausted,
    /// No parameters meet all constraints.
    Infeasible,
    Cancelled,
}

/// What simulators call one link: mass, centre of mass, inertia about it, friction of its joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalLink {
    pub inertia: PhysicalInertia,
    pub viscous: f64,
    pub coulomb: f64,
}

impl PhysicalFit {
    /// Link by link; `None` where a mass is zero.
    pub fn links(&self, layout: &Layout) -> Option<Vec<PhysicalLink>> {
        physical_links(layout, &self.values)
    }
}

/// Standard parameters read link by link; `None` where a mass is zero.
pub fn physical_links(layout: &Layout, values: &[f64]) -> Option<Vec<PhysicalLink>> {
    let friction = |link: usize, kind: ParameterKind| {
        let at = layout.parameters().iter().position(|p| p.link == link && p.kind == kind);
        at.map_or(0.0, |at| values[at])
    };
    (0..layout.len() / layout.per_link())
        .map(|link| {
            Some(PhysicalLink {
                inertia: layout.link_inertia(values, link).physical()?,
                viscous: friction(link, ParameterKind::Viscous),
                coulomb: friction(link, ParameterKind::Coulomb),
            })
        })
        .collect()
}
