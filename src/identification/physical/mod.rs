//! Physical parameters: masses, centres of mass and inertias that a simulator accepts and that fit the log.
//!
//! Least squares determines base parameters; the standard parameters behind them are open along the null space of K, and the best
//! fit may be no body at all (the paper's Table 2 has negative inertias). Two ways to a model that is one:
//!
//! - [`fit_consistent`]: least squares over the standard parameters with the pseudo-inertia of every link positive definite
//!   (Traversaro et al. 2016, Wensing et al. 2018), its centre of mass about the link, and what the log leaves open as near to a
//!   prior body as can be (Lee, Wensing & Park 2019). Convex: the answer is the global one.
//! - [`fit_paper`]: the paper's (10a–d), nonlinear in mass, centre of mass and inertia about it, with bounds and the constraints
//!   that simulators like. [`lower_bound`] says how far it can be from its global minimum.

mod blas;
mod consistent;
mod margins;
mod objective;
mod paper;
mod plausible;
mod prior;

pub use crate::model::LinkBounds;
pub use consistent::{Cone, ConsistentOptions, fit_consistent, lower_bound};
use margins::bound_margins;
pub use margins::{ActiveBound, Constraint, ConstraintMargin, margins};
pub use objective::{FitObjective, FitRms};
pub use paper::{PaperFit, PaperOptions, StartFit, Triangle, fit_paper};
pub use plausible::link_boxes;
pub use prior::{LinkScale, priors, rod_prior};

use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use crate::spatial::PhysicalInertia;

/// A set of standard parameters that are a physical robot, and how well they fit.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicalFit {
    /// Standard parameters in the order of [`Layout::standard`], then any columns added to the observation (offsets).
    pub values: Vec<f64>,
    /// How well the bodies fit.
    pub fit: FitRms,
    /// What is left to every constraint.
    pub margins: Vec<ConstraintMargin>,
    /// Constraints that hold the solution of the convex problem, with their cost in fit.
    pub active: Vec<ActiveBound>,
    /// How the solver ended.
    pub ending: FitEnding,
    /// Iterations of the solver, over all starts.
    pub iterations: u32,
}

/// How a fit of bodies ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitEnding {
    /// At the optimum.
    Converged,
    /// Solved to a looser tolerance than asked for.
    Stalled,
    /// The iterations or the time were spent before.
    BudgetExhausted,
    /// No parameters meet all constraints.
    Infeasible,
    /// It was cancelled.
    Cancelled,
}

/// What simulators call one link: mass, centre of mass, inertia about it, friction of its joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalLink {
    /// Mass, centre of mass and inertia.
    pub inertia: PhysicalInertia,
    /// Viscous friction [N·m s/rad or N s/m].
    pub viscous: f64,
    /// Coulomb friction [N·m or N].
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

/// Which problem gives the physical parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FeasibleMethod {
    /// [`fit_consistent`].
    #[default]
    Consistent,
    /// [`fit_paper`].
    Paper,
    /// The consistent fit, with the paper's beside it.
    Both,
}

/// What to ask of physical parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FeasibleOptions {
    /// Which problems are solved.
    pub method: FeasibleMethod,
    /// Options of the convex problem.
    pub consistent: ConsistentOptions,
    /// Options of the published problem (10a-d).
    pub paper: PaperOptions,
}

impl FeasibleOptions {
    /// The defaults, with the bounds and slender axes of the robot's description.
    pub fn for_robot(robot: &Robot) -> Self {
        let bounds: Vec<LinkBounds> = robot.joints().iter().map(|j| j.bounds).collect();
        Self {
            method: FeasibleMethod::default(),
            consistent: ConsistentOptions {
                boxes: link_boxes(robot),
                bounds: bounds.clone(),
                ..ConsistentOptions::default()
            },
            paper: PaperOptions {
                bounds,
                slender: robot.joints().iter().map(|j| j.slender_axis).collect(),
                ..PaperOptions::default()
            },
        }
    }
}

/// Physical parameters as asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct FeasibleFit {
    /// Bodies of the convex problem.
    pub consistent: PhysicalFit,
    /// Bodies of the published problem, where it was asked for.
    pub paper: Option<PaperFit>,
    method: FeasibleMethod,
}

impl FeasibleFit {
    /// The parameters that make the model.
    pub fn model(&self) -> &PhysicalFit {
        match (&self.paper, self.method) {
            (Some(paper), FeasibleMethod::Paper) => &paper.fit,
            _ => &self.consistent,
        }
    }

    /// Which problems were solved.
    pub fn method(&self) -> FeasibleMethod {
        self.method
    }
}

/// Solves the problems that `options` ask for. The convex one is solved in any case: its answer is a start for the other.
pub fn fit_feasible(
    robot: &Robot,
    objective: &FitObjective,
    options: &FeasibleOptions,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> FeasibleFit {
    let consistent = fit_consistent(robot, objective, &options.consistent);
    let paper = (options.method != FeasibleMethod::Consistent)
        .then(|| fit_paper(robot, objective, &consistent, &options.paper, cancelled));
    FeasibleFit {
        consistent,
        paper,
        method: options.method,
    }
}
