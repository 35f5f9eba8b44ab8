//! The paper's nonlinear problem (10a–d): least squares over masses, centres of mass, inertias about them and friction.
//!
//! Not convex: π(μ) of (4) has products of mass and centre of mass. Solved from many starts by sequential quadratic programming
//! with exact derivatives; how far the best of them can be from the global minimum is known from a convex relaxation
//! ([`lower_bound`]), which leaves out what has no convex form and keeps the rest.
//!
//! Variables are whitened: in `μ = μ₀ + T y` with `T Tᵀ = (JᵀHJ + ρE)⁻¹` at μ₀ the cost is a sphere to first order, which the
//! solver's first guess of the Hessian then is too. A few rounds of that take tens of evaluations where plain variables take
//! thousands.

mod limits;
mod variables;

use super::{Cone, ConsistentOptions, FitEnding, FitObjective, PhysicalFit, PhysicalLink, lower_bound, margins, rod_prior};
use crate::model::{Axis, LinkBounds, LinkPrior, Robot};
use crate::solver::{Ending, StopRule, minimize_subject_to};
use limits::Limits;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use variables::Variables;

/// Which triangle inequality the moments of inertia meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Triangle {
    /// Of the principal moments: what a body of positive density has, and what simulators check.
    #[default]
    Principal,
    /// Of the diagonal of the tensor, the paper's (10d).
    Diagonal,
    /// Of neither.
    None,
}

/// What to ask of the nonlinear fit.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperOptions {
    /// (10b), per link; empty for none.
    pub bounds: Vec<LinkBounds>,
    /// Per link the axis of the description's frame along which it is long; empty for none.
    pub slender: Vec<Option<Axis>>,
    /// Whether (10d) holds besides (10c).
    pub gazebo: bool,
    /// How the triangle inequalities of the moments of inertia are imposed.
    pub triangle: Triangle,
    /// Least viscous friction [N m s/rad or N s/m].
    pub least_viscous: f64,
    /// Least diagonal entry of an inertia [kg m²] (10d).
    pub least_moment: f64,
    /// Most that the largest diagonal entry of an inertia may be of the smallest (10d); `None` for no limit.
    pub moment_ratio: Option<f64>,
    /// Least that diagonal entries across a slender link are of the one along it (10d); `None` for no limit.
    pub slender_ratio: Option<f64>,
    /// Most that products of inertia may be of the smallest diagonal entry (10d); `None` for no limit.
    pub product_ratio: Option<f64>,
    /// Local solves.
    pub starts: usize,
    /// Of the random starts.
    pub seed: u64,
}

/// The paper's numbers, except for the triangle inequality, which is that of the principal moments.
impl Default for PaperOptions {
    fn default() -> Self {
        Self {
            bounds: Vec::new(),
            slender: Vec::new(),
            gazebo: true,
            triangle: Triangle::Principal,
            least_viscous: 0.1,
            least_moment: 1e-4,
            moment_ratio: Some(100.0),
            slender_ratio: Some(3.0),
            product_ratio: Some(0.1),
            starts: 8,
            seed: 1,
        }
    }
}

/// The answer to (10a–d).
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFit {
    /// The best of all starts; its ending says whether the constraints could be met.
    pub fit: PhysicalFit,
    /// μ link by link, in the frames of the description.
    pub links: Vec<PhysicalLink>,
    /// Cost that no parameters which meet the constraints can be below.
    pub lower_bound: f64,
    /// Fit over that of the lower bound, less one: 0.01 is at most 1 % worse than the global minimum.
    pub gap: f64,
    /// Every start and how it ended.
    pub starts: Vec<StartFit>,
}

/// One local solve.
#[derive(Debug, Clone, PartialEq)]
pub struct StartFit {
    /// `rods`, `robot`, `consistent` or `random`.
    pub from: &'static str,
    /// Value of the objective.
    pub cost: f64,
    /// Whether every constraint is met.
    pub feasible: bool,
    /// Evaluations of the objective.
    pub evaluations: u32,
    /// How the solver ended.
    pub ending: FitEnding,
}

/// Solves (10a–d) from `options.starts` starts: rods in the place of the links (the paper's), the robot's own priors, the
/// solution `consistent` of the convex problem, and rods of random size and place. The same options give the same answer on any
/// number of threads.
pub fn fit_paper(
    robot: &Robot,
    objective: &FitObjective,
    consistent: &PhysicalFit,
    options: &PaperOptions,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> PaperFit {
    let problem = Problem::new(robot, objective, options);
    let starts = problem.starts(robot, consistent, options);
    let descents: Vec<Descent> = starts
        .par_iter()
        .map(|(_, start)| problem.descend(start.clone(), cancelled))
        .collect();
    let rank = |d: &Descent| (d.violation > 0.0, if d.violation > 0.0 { d.violation } else { d.value });
    let best = descents
        .iter()
        .min_by(|a, b| rank(a).0.cmp(&rank(b).0).then(rank(a).1.total_cmp(&rank(b).1)))
        .expect("at least one start");
    let mu: Vec<f64> = best.s.component_mul(&problem.variables.scale).iter().copied().collect();
    let values: Vec<f64> = problem.variables.standard(&mu).iter().copied().collect();
    let fit = objective.fit(&values);
    let lower = lower_bound(robot, objective, &relaxation(options));
    let mut all = margins(&problem.variables.layout, &values);
    all.retain(|m| !problem.limits.margins(&mu).iter().any(|own| own.constraint == m.constraint));
    all.extend(problem.limits.margins(&mu));
    PaperFit {
        gap: (fit.cost / lower.max(f64::MIN_POSITIVE)).sqrt() - 1.0,
        lower_bound: lower,
        links: problem.variables.physical(&mu),
        fit: PhysicalFit {
            values,
            fit,
            margins: all,
            active: Vec::new(),
            ending: if best.violation > 0.0 {
                FitEnding::Infeasible
            } else {
                best.ending
            },
            iterations: descents.iter().map(|d| d.evaluations).sum(),
        },
        starts: starts
            .iter()
            .zip(&descents)
            .map(|((from, _), d)| StartFit {
                from,
                cost: d.value * problem.size,
                feasible: d.violation <= 0.0,
                evaluations: d.evaluations,
                ending: d.ending,
            })
            .collect(),
    }
}

/// The convex part of the constraints: with the principal moments' triangle inequality the pseudo-inertia is definite, without it
/// the 6 × 6 inertia of the body is.
fn relaxation(options: &PaperOptions) -> ConsistentOptions {
    ConsistentOptions {
        boxes: Vec::new(),
        prior_weight: 0.0,
        most_shift: f64::INFINITY,
        bounds: options.bounds.clone(),
        least_eigenvalue: 0.0,
        least_viscous: options.least_viscous,
        cone: match options.triangle {
            Triangle::Principal => Cone::PseudoInertia,
            _ => Cone::SpatialInertia,
        },
    }
}

/// Cost and constraints over scaled variables s, μ = scale ∘ s.
struct Problem {
    variables: Variables,
    limits: Limits,
    h: DMatrix<f64>,
    /// Minimum without constraints, over the standard parameters.
    center: DVector<f64>,
    least: f64,
    /// What the cost is measured in: its own value without constraints.
    size: f64,
}

#[derive(Debug, Clone)]
struct Descent {
    s: DVector<f64>,
    value: f64,
    violation: f64,
    evaluations: u32,
    ending: FitEnding,
}

/// Evaluations between two whitenings: enough to settle the active constraints, too few to wander with a stale metric.
const ROUND: u32 = 100;
/// Evaluations of the round after one that led nowhere.
const LONG_ROUND: u32 = 400;
const MOST_ROUNDS: usize = 10;
/// A relative gain of the cost that nobody sees: a thousandth of a per cent of the fit.
const SETTLED: f64 = 2e-5;
/// Curvature that every direction is given besides the cost's own: moving a parameter that the log says nothing of by its natural
/// size counts as changing the cost by half of itself.
const FLAT: f64 = 1.0;

impl Problem {
    fn new(robot: &Robot, objective: &FitObjective, options: &PaperOptions) -> Self {
        let variables = Variables::new(robot, objective.len());
        let (h, _, _) = objective.quadratic();
        let least = objective.unconstrained();
        Self {
            limits: Limits::new(&variables, options),
            center: objective.center(),
            size: least.max(1e-12 * objective.torque_square()).max(f64::MIN_POSITIVE),
            least,
            variables,
            h,
        }
    }

    /// Cost over its size, and the gradient by s: with φ = π(μ) the cost is `least + (φ − φ*)ᵀ H (φ − φ*)`.
    fn cost(&self, s: &DVector<f64>) -> (f64, DVector<f64>) {
        let mu = s.component_mul(&self.variables.scale);
        let off = self.variables.standard(mu.as_slice()) - &self.center;
        let along = &self.h * &off;
        let value = (self.least + off.dot(&along)) / self.size;
        let gradient = self.variables.pull_back(mu.as_slice(), &(along * (2.0 / self.size)));
        (value, gradient.component_mul(&self.variables.scale))
    }

    /// T with `T Tᵀ = (Jᵀ (2H/size) J + ρ E)⁻¹`, J = ∂π/∂s.
    fn whitener(&self, s: &DVector<f64>) -> DMatrix<f64> {
        let n = s.len();
        let mu = s.component_mul(&self.variables.scale);
        let mut jacobian = DMatrix::zeros(n, n);
        for i in 0..n {
            let mut unit = DVector::zeros(n);
            unit[i] = 1.0;
            let row = self
                .variables
                .pull_back(mu.as_slice(), &unit)
                .component_mul(&self.variables.scale);
            jacobian.row_mut(i).copy_from(&row.transpose());
        }
        let curvature = jacobian.transpose() * &self.h * &jacobian * (2.0 / self.size) + DMatrix::identity(n, n) * FLAT;
        // A Gram matrix and the identity, positive definite unless its numbers are beyond those of a double; the search then goes
        // without.
        let whitening = curvature
            .cholesky()
            .and_then(|c| c.l().transpose().solve_upper_triangular(&DMatrix::identity(n, n)));
        whitening.unwrap_or_else(|| DMatrix::identity(n, n))
    }

    fn descend(&self, start: Vec<f64>, cancelled: &dyn Fn() -> bool) -> Descent {
        let s = DVector::from_vec(start).component_div(&self.variables.scale);
        let mut found = Descent {
            s,
            value: f64::INFINITY,
            violation: f64::INFINITY,
            evaluations: 0,
            ending: FitEnding::BudgetExhausted,
        };
        let mut patience = ROUND;
        for _ in 0..MOST_ROUNDS {
            let round = self.round(&found.s, patience, cancelled);
            let evaluations = found.evaluations + round.evaluations;
            let (was, is) = (found.violation <= 0.0, round.violation <= 0.0);
            let better = if was {
                is && round.value < found.value
            } else {
                round.violation < found.violation
            };
            let settled = was && is && found.value - round.value <= SETTLED * round.value;
            let spent = round.ending == FitEnding::BudgetExhausted;
            if better {
                found = round;
            }
            found.evaluations = evaluations;
            found.ending = match cancelled() {
                true => FitEnding::Cancelled,
                false => FitEnding::Converged,
            };
            // Between feasible points a solver may need longer than one round; it is given that once.
            let longer = !better && spent && patience == ROUND;
            if cancelled() || (!better && !longer) || (better && settled) {
                return found;
            }
            patience = if longer { LONG_ROUND } else { ROUND };
        }
        found.ending = FitEnding::BudgetExhausted;
        found
    }

    /// One solve in whitened variables around `s`.
    fn round(&self, s: &DVector<f64>, evaluations: u32, cancelled: &dyn Fn() -> bool) -> Descent {
        let (n, m) = (s.len(), self.limits.len());
        let t = self.whitener(s);
        let place = |y: &[f64]| s + &t * DVector::from_column_slice(y);
        let mut objective = |y: &[f64], gradient: &mut [f64]| {
            if cancelled() {
                return None;
            }
            let (value, by_s) = self.cost(&place(y));
            gradient.copy_from_slice(t.tr_mul(&by_s).as_slice());
            Some(value)
        };
        let scale = self.variables.scale.as_slice();
        let mut by_s = DMatrix::zeros(m, n);
        let mut constraints = |y: &[f64], out: &mut [f64], jacobian: Option<&mut [f64]>| {
            let mu = place(y).component_mul(&self.variables.scale);
            match jacobian {
                None => self.limits.evaluate(mu.as_slice(), scale, out, None),
                Some(jacobian) => {
                    self.limits.evaluate(mu.as_slice(), scale, out, Some(&mut by_s));
                    // Row by row is the transpose, column by column.
                    let transposed = t.tr_mul(&by_s.transpose());
                    jacobian.copy_from_slice(transposed.as_slice());
                }
            }
        };
        let rule = StopRule {
            max_evaluations: evaluations,
            least_improvement: 0.1 * SETTLED,
        };
        let found = minimize_subject_to(
            &vec![0.0; n],
            rule,
            &mut objective,
            &mut constraints,
            &self.limits.tolerances(),
        );
        Descent {
            s: place(&found.x),
            value: found.value,
            violation: found.violation,
            evaluations: found.evaluations,
            ending: match found.ending {
                Ending::Interrupted => FitEnding::Cancelled,
                Ending::EvaluationsSpent => FitEnding::BudgetExhausted,
                _ => FitEnding::Converged,
            },
        }
    }

    fn starts(&self, robot: &Robot, consistent: &PhysicalFit, options: &PaperOptions) -> Vec<(&'static str, Vec<f64>)> {
        let phi = self.center.as_slice();
        let rods: Vec<LinkPrior> = (0..robot.joint_count()).map(|k| rod_prior(robot, k)).collect();
        let mut found = vec![("rods", self.variables.of_priors(&rods, phi))];
        let own: Option<Vec<LinkPrior>> = robot
            .joints()
            .iter()
            .map(|j| j.prior.filter(|p| p.inertia.mass > 0.0))
            .collect();
        found.extend(own.map(|priors| ("robot", self.variables.of_priors(&priors, phi))));
        if consistent.ending != FitEnding::Infeasible {
            found.extend(self.variables.of_standard(&consistent.values).map(|mu| ("consistent", mu)));
        }
        // The best known first, for those who ask for fewer starts than there are kinds.
        found.reverse();
        found.truncate(options.starts.max(1));
        for index in found.len()..options.starts {
            found.push(("random", self.random(&rods, phi, options.seed, index as u64)));
        }
        found
    }

    /// Rods whose masses and moments are off by a factor of about two, and whose centres by a quarter of the link's length.
    fn random(&self, rods: &[LinkPrior], phi: &[f64], seed: u64, index: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let mut spread = || rng.random_range(-1.0..1.0f64);
        let bodies: Vec<LinkPrior> = rods
            .iter()
            .map(|rod| {
                let length = super::LinkScale::from_link(rod).length;
                let mut body = *rod;
                let factor = (0.7 * spread()).exp();
                body.inertia.mass *= factor;
                body.inertia.inertia *= factor * (0.7 * spread()).exp();
                body.inertia
                    .center_of_mass
                    .iter_mut()
                    .for_each(|c| *c += 0.25 * length * spread());
                body
            })
            .collect();
        self.variables.of_priors(&bodies, phi)
    }
}
