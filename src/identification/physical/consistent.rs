//! Least squares over physically consistent parameters: a semidefinite programme.

use super::blas::single_threaded_blas;
use super::margins::box_margins;
use super::plausible::pull_back_metric;
use super::{ActiveBound, Constraint, FitEnding, FitObjective, LinkScale, PhysicalFit, bound_margins, margins, priors};
use crate::model::{LinkBounds, LinkPrior, Robot};
use crate::parameters::{Inertial, Layout, ParameterKind};
use crate::spatial::LinkInertia;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector, Matrix3};

/// What to ask beyond consistency.
#[derive(Debug, Clone, PartialEq)]
pub struct ConsistentOptions {
    /// Weight of the pull towards the prior body, the divergence between the two (Lee, Wensing & Park 2019), in units of one
    /// noise variance; the largest one where `most_shift` is finite.
    pub prior_weight: f64,
    /// How far the pull may move the base parameters, root mean square in their standard deviations: the weight is lowered until
    /// it does. Infinite takes `prior_weight` as it is.
    pub most_shift: f64,
    /// Where the centre of mass of every link may be, in its own frame: lowest and highest along x, y, z (m). Empty for anywhere.
    /// Stated [bounds](Self::bounds) of a link take the place of its box.
    pub boxes: Vec<[[f64; 2]; 3]>,
    /// Per link; empty for none. Bounds on the inertia about the centre of mass have no convex form and are left to the nonlinear
    /// problem.
    pub bounds: Vec<LinkBounds>,
    /// Least eigenvalue of the pseudo-inertia, as a fraction of the prior link's mass and radius of gyration.
    pub least_eigenvalue: f64,
    /// Least viscous friction [N m s/rad or N s/m]; the paper asks for 0.1.
    pub least_viscous: f64,
    /// What makes ten numbers a body.
    pub cone: Cone,
}

/// What makes ten numbers a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cone {
    /// The 4 × 4 pseudo-inertia is positive definite: full consistency, triangle inequality of the principal moments included.
    #[default]
    PseudoInertia,
    /// The 6 × 6 inertia `[[I, S(h)ᵀ], [S(h), m E]]` is (Sousa & Cortesão 2014): positive mass and positive definite inertia
    /// about the centre of mass, the paper's (10c), and no more.
    SpatialInertia,
}

/// A weight of one is a prior whose standard deviation is the link's own size. A link thicker than its prior, a thin rod, is many
/// deviations away from it all the same; with that weight, friction was 1.4 of its standard deviations off (rms) instead of 1.0.
/// A shift of 0.3 adds 5 % to the error of a parameter. Bodies below a ten-thousandth of their prior cannot be simulated in steps
/// of a millisecond.
impl Default for ConsistentOptions {
    fn default() -> Self {
        Self {
            prior_weight: 1.0,
            most_shift: 0.3,
            boxes: Vec::new(),
            bounds: Vec::new(),
            least_eigenvalue: 1e-4,
            least_viscous: 0.0,
            cone: Cone::PseudoInertia,
        }
    }
}

/// Minimises the weighted residual plus the pull towards priors, subject to a positive definite pseudo-inertia of every link,
/// friction that is not negative, and the bounds. Of the bodies that fit equally well, it is the most plausible one.
///
/// Variables and cones are scaled by the priors, so that all are of order one.
///
/// # Panics
/// When the objective is not one of `robot`.
pub fn fit_consistent(robot: &Robot, objective: &FitObjective, options: &ConsistentOptions) -> PhysicalFit {
    let options = &with_least_pull(robot, objective, options);
    let solved = solve(robot, objective, options, None);
    let layout = Layout::standard(robot);
    let mut margins = margins(&layout, &solved.values);
    margins.extend(bound_margins(robot, &layout, &options.bounds, &solved.values));
    margins.extend(box_margins(&layout, options, &solved.values));
    let fit = objective.fit(&solved.values);
    let cost = |&(link, constraint): &Label| {
        let without = solve(robot, objective, options, Some((link, constraint)));
        let least = objective.fit(&without.values).cost.max(f64::MIN_POSITIVE);
        ActiveBound {
            link,
            constraint,
            cost_percent: 100.0 * ((fit.cost / least).sqrt() - 1.0).max(0.0),
        }
    };
    PhysicalFit {
        active: solved.active.iter().map(cost).collect(),
        fit,
        margins,
        values: solved.values,
        ending: solved.ending,
        iterations: solved.iterations,
    }
}

/// Weight of a pull that decides only what the log leaves open: a ten-thousandth of a noise variance.
const LEAST_WEIGHT: f64 = 1e-4;

/// Halvings of the range of the weight's logarithm: four of 1e-4 to 1 end within a factor of 1.8 below the largest weight
/// allowed.
const WEIGHT_STEPS: usize = 4;

/// The options with the largest weight of the pull whose cost in fit, `ΔᵀHΔ` for a shift Δ of parameters with information H,
/// allows no more than `most_shift` (discrepancy principle, Morozov 1966). The constraints' own cost does not count: it is in the
/// fit without pull too.
fn with_least_pull(robot: &Robot, objective: &FitObjective, options: &ConsistentOptions) -> ConsistentOptions {
    let weighted = |prior_weight: f64| ConsistentOptions {
        prior_weight,
        ..options.clone()
    };
    if options.most_shift.is_infinite() || options.prior_weight <= LEAST_WEIGHT {
        return options.clone();
    }
    let cost = |weight: f64| objective.fit(&solve(robot, objective, &weighted(weight), None).values).cost;
    let most = cost(LEAST_WEIGHT) + options.most_shift.powi(2) * objective.map.nrows() as f64;
    if cost(options.prior_weight) <= most {
        return options.clone();
    }
    let (mut low, mut high) = (LEAST_WEIGHT.ln(), options.prior_weight.ln());
    for _ in 0..WEIGHT_STEPS {
        let middle = 0.5 * (low + high);
        if cost(middle.exp()) <= most {
            low = middle
        } else {
            high = middle
        }
    }
    weighted(low.exp())
}

/// Cost that no parameters within the constraints of `options` are below: the dual objective of the programme, which bounds it
/// whatever the primal solution lacks in precision, and in any case the cost without constraints. Infinite where the constraints
/// contradict each other. The pull towards priors must be zero to bound the cost alone.
pub fn lower_bound(robot: &Robot, objective: &FitObjective, options: &ConsistentOptions) -> f64 {
    let solved = solve(robot, objective, options, None);
    match solved.ending {
        FitEnding::Infeasible => f64::INFINITY,
        FitEnding::Converged | FitEnding::Stalled => solved.dual_cost.max(objective.unconstrained()),
        _ => objective.unconstrained(),
    }
}

/// A link and what holds it.
type Label = (usize, Constraint);

struct Solved {
    values: Vec<f64>,
    /// Constraints that hold the solution.
    active: Vec<Label>,
    ending: FitEnding,
    iterations: u32,
    /// Bound on the cost, pull included, from the dual.
    dual_cost: f64,
}

/// `without` leaves one constraint out.
fn solve(robot: &Robot, objective: &FitObjective, options: &ConsistentOptions, without: Option<Label>) -> Solved {
    let layout = Layout::standard(robot);
    assert!(
        objective.len() >= layout.len(),
        "the objective is over the robot's standard parameters"
    );
    let links = priors(robot);
    let scale = variable_scale(&layout, &links, objective);
    let (p, q) = cost(&layout, &links, objective, &scale, options.prior_weight);
    // Seen from the unconstrained minimum the cost is what the constraints add to it, and the solver's tolerance a tolerance of
    // that: noise may be a ten-thousandth of the torque, its square would be lost beside the whole.
    let center = unconstrained_minimum(&p, &q);
    let slope = &q + &p * &center;
    let constraints = constraints(robot, &layout, &links, &scale, options, without);
    let matrix = constraints.dense();
    let right = DVector::from_column_slice(&constraints.right) - &matrix * &center;
    let settings = DefaultSettings {
        verbose: false,
        max_iter: 200,
        ..DefaultSettings::default()
    };
    let all = compressed(&matrix, |_, _| true);
    single_threaded_blas();
    let mut solver = DefaultSolver::new(
        &upper(&p),
        slope.as_slice(),
        &all,
        right.as_slice(),
        &constraints.cones,
        settings,
    )
    .expect("dimensions fit by construction");
    solver.solve();
    let values: Vec<f64> = (0..scale.len())
        .map(|i| (center[i] + solver.solution.x[i]) * scale[i])
        .collect();
    let unscaled: Vec<f64> = (0..scale.len()).map(|i| center[i] * scale[i]).collect();
    Solved {
        values,
        active: constraints.active(&solver.solution.s, &solver.solution.z),
        ending: match solver.solution.status {
            SolverStatus::Solved => FitEnding::Converged,
            SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => FitEnding::Stalled,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => FitEnding::Infeasible,
            _ => FitEnding::BudgetExhausted,
        },
        iterations: solver.solution.iterations,
        dual_cost: objective.fit(&unscaled).cost + cost_size(objective) * solver.solution.obj_val_dual,
    }
}

/// Size of every variable: of the prior for inertial parameters, of the unconstrained fit's own order for the rest.
fn variable_scale(layout: &Layout, links: &[LinkPrior], objective: &FitObjective) -> DVector<f64> {
    DVector::from_fn(objective.len(), |i, _| match layout.parameters().get(i) {
        Some(parameter) => {
            let LinkScale { mass, length } = LinkScale::from_link(&links[parameter.link]);
            match parameter.kind {
                ParameterKind::Inertial(Inertial::M) => mass,
                ParameterKind::Inertial(Inertial::MX | Inertial::MY | Inertial::MZ) => mass * length,
                ParameterKind::Inertial(_) => mass * length * length,
                // Friction and offsets are of the order of a newton metre; they are determined by the log in any case.
                _ => 1.0,
            }
        }
        None => 1.0,
    })
}

/// Minimum of `½ xᵀPx + qᵀx`, of least norm where P is singular.
pub(super) fn unconstrained_minimum(p: &DMatrix<f64>, q: &DVector<f64>) -> DVector<f64> {
    let eigen = p.clone().symmetric_eigen();
    // Rounding of a matrix of this size is 1e-14 of its largest eigenvalue.
    let least = 1e-13 * eigen.eigenvalues.amax();
    let along = eigen.eigenvectors.tr_mul(q);
    let steps = DVector::from_fn(q.len(), |i, _| {
        if eigen.eigenvalues[i] > least {
            -along[i] / eigen.eigenvalues[i]
        } else {
            0.0
        }
    });
    &eigen.eigenvectors * steps
}

/// `½ xᵀPx + qᵀx` over scaled variables, in units of the unconstrained cost.
fn cost(
    layout: &Layout,
    links: &[LinkPrior],
    objective: &FitObjective,
    scale: &DVector<f64>,
    weight: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let (h, g, _) = objective.quadratic();
    let n = scale.len();
    let mut p = DMatrix::from_fn(n, n, |r, c| 2.0 * h[(r, c)] * scale[r] * scale[c]);
    let mut q = DVector::from_fn(n, |i, _| -2.0 * g[i] * scale[i]);
    for (link, prior) in links.iter().enumerate() {
        let metric = pull_back_metric(prior) * weight;
        let body = DVector::from_column_slice(&prior.inertia.about_origin().parameters());
        let slope = &metric * &body;
        let at = Inertial::ALL.map(|which| layout.inertial(link, which));
        for (r, &row) in at.iter().enumerate() {
            q[row] -= slope[r] * scale[row];
            for (c, &column) in at.iter().enumerate() {
                p[(row, column)] += metric[(r, c)] * scale[row] * scale[column];
            }
        }
    }
    let size = cost_size(objective);
    (p / size, q / size)
}

/// What costs are measured in: the unconstrained one, kept from zero.
fn cost_size(objective: &FitObjective) -> f64 {
    objective
        .unconstrained()
        .max(1e-12 * objective.torque_square())
        .max(f64::MIN_POSITIVE)
}

/// Rows `A x + s = b`, s in the cones.
#[derive(Default)]
struct Constraints {
    rows: Vec<Vec<(usize, f64)>>,
    right: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    /// Of every row, and whether it is one of a cone of matrices.
    labels: Vec<(Label, bool)>,
    /// What is left out.
    without: Option<Label>,
    variables: usize,
}

impl Constraints {
    /// `Σ coefficient x ≥ least`.
    fn at_least(&mut self, label: Label, coefficients: &[(usize, f64)], least: f64) {
        if self.without != Some(label) {
            self.row(label, false, coefficients, least);
        }
    }

    fn row(&mut self, label: Label, matrix: bool, coefficients: &[(usize, f64)], least: f64) {
        self.rows.push(coefficients.iter().map(|&(i, v)| (i, -v)).collect());
        self.right.push(-least);
        self.labels.push((label, matrix));
    }

    /// What holds the solution: of single rows those whose multiplier is above the slack (one of the two is zero), of matrices
    /// those on whose multiplier more rests than the solver's tolerance.
    fn active(&self, slack: &[f64], multipliers: &[f64]) -> Vec<Label> {
        let mut found: Vec<Label> = Vec::new();
        for (((label, matrix), s), z) in self.labels.iter().zip(slack).zip(multipliers) {
            let holds = if *matrix { z.abs() > 1e-6 } else { z > s };
            if holds && !found.contains(label) {
                found.push(*label);
            }
        }
        found
    }

    fn dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.rows.len(), self.variables);
        for (r, row) in self.rows.iter().enumerate() {
            row.iter().for_each(|&(c, v)| dense[(r, c)] += v);
        }
        dense
    }
}

fn constraints(
    robot: &Robot,
    layout: &Layout,
    links: &[LinkPrior],
    scale: &DVector<f64>,
    options: &ConsistentOptions,
    without: Option<Label>,
) -> Constraints {
    let mut found = Constraints {
        variables: scale.len(),
        without,
        ..Constraints::default()
    };
    for (i, parameter) in layout.parameters().iter().enumerate() {
        match parameter.kind {
            ParameterKind::Viscous => {
                let label = (parameter.link, Constraint::Viscous);
                found.at_least(label, &[(i, scale[i])], options.least_viscous);
            }
            ParameterKind::Coulomb => found.at_least((parameter.link, Constraint::Coulomb), &[(i, scale[i])], 0.0),
            ParameterKind::Inertial(_) => {}
        }
    }
    for (link, bounds) in options.bounds.iter().enumerate() {
        bound_rows(robot, layout, link, bounds, scale, &mut found);
    }
    for (link, sides) in boxes(options) {
        let turn = Matrix3::identity();
        center_rows(layout, (link, Constraint::CenterOfMassBox), &turn, sides, scale, &mut found);
    }
    if !found.rows.is_empty() {
        found.cones.push(SupportedConeT::NonnegativeConeT(found.rows.len()));
    }
    for (link, prior) in links.iter().enumerate() {
        if without == Some((link, Constraint::PseudoInertia)) {
            continue;
        }
        let LinkScale { mass, length } = LinkScale::from_link(prior);
        let (unit, matrix): (Vec<f64>, LinkMatrix) = match options.cone {
            Cone::PseudoInertia => (vec![length, length, length, 1.0], |body| {
                DMatrix::from_fn(4, 4, |r, c| body.pseudo_inertia()[(r, c)])
            }),
            Cone::SpatialInertia => (vec![length, length, length, 1.0, 1.0, 1.0], spatial_inertia),
        };
        cone_rows(layout, link, mass, &unit, matrix, scale, options.least_eigenvalue, &mut found);
    }
    found
}

/// A symmetric matrix that is linear in the parameters of a link.
type LinkMatrix = fn(&LinkInertia) -> DMatrix<f64>;

fn spatial_inertia(body: &LinkInertia) -> DMatrix<f64> {
    let mut whole = DMatrix::zeros(6, 6);
    let moment = body.first_moment.cross_matrix();
    whole.view_mut((0, 0), (3, 3)).copy_from(&body.inertia);
    whole.view_mut((3, 0), (3, 3)).copy_from(&moment);
    whole.view_mut((0, 3), (3, 3)).copy_from(&moment.transpose());
    (3..6).for_each(|i| whole[(i, i)] = body.mass);
    whole
}

/// Mass and centre of mass between their bounds, in the frame of the description: `m low ≤ (R h)_axis ≤ m high`.
fn bound_rows(robot: &Robot, layout: &Layout, link: usize, bounds: &LinkBounds, scale: &DVector<f64>, found: &mut Constraints) {
    let mass = layout.inertial(link, Inertial::M);
    if let Some([low, high]) = bounds.mass {
        found.at_least((link, Constraint::BoundMass), &[(mass, scale[mass])], low);
        found.at_least((link, Constraint::BoundMass), &[(mass, -scale[mass])], -high);
    }
    if let Some(sides) = &bounds.center_of_mass {
        let turn = robot.joints()[link].description_frame;
        center_rows(layout, (link, Constraint::BoundCenterOfMass), &turn, sides, scale, found);
    }
    for (kind, bound, constraint) in [
        (ParameterKind::Viscous, bounds.viscous, Constraint::BoundViscous),
        (ParameterKind::Coulomb, bounds.coulomb, Constraint::BoundCoulomb),
    ] {
        let at = layout.parameters().iter().position(|p| p.link == link && p.kind == kind);
        if let (Some(at), Some([low, high])) = (at, bound) {
            found.at_least((link, constraint), &[(at, scale[at])], low);
            found.at_least((link, constraint), &[(at, -scale[at])], -high);
        }
    }
}

/// Boxes of the links whose centre of mass has no stated bounds.
pub(super) fn boxes(options: &ConsistentOptions) -> impl Iterator<Item = (usize, &[[f64; 2]; 3])> {
    let stated = |link: usize| options.bounds.get(link).is_some_and(|b| b.center_of_mass.is_some());
    options.boxes.iter().enumerate().filter(move |(link, _)| !stated(*link))
}

/// `m low ≤ (R h)_axis ≤ m high` along the three axes of the frame that `turn` leads to.
fn center_rows(
    layout: &Layout,
    label: Label,
    turn: &Matrix3<f64>,
    sides: &[[f64; 2]; 3],
    scale: &DVector<f64>,
    found: &mut Constraints,
) {
    let mass = layout.inertial(label.0, Inertial::M);
    for (axis, &[low, high]) in sides.iter().enumerate() {
        let along = |sign: f64, end: f64| -> Vec<(usize, f64)> {
            let moments = [Inertial::MX, Inertial::MY, Inertial::MZ].into_iter().enumerate();
            let moments = moments.map(|(k, which)| (layout.inertial(label.0, which), sign * turn[(axis, k)]));
            moments
                .chain([(mass, -sign * end)])
                .map(|(at, v)| (at, v * scale[at]))
                .collect()
        };
        found.at_least(label, &along(1.0, low), 0.0);
        found.at_least(label, &along(-1.0, high), 0.0);
    }
}

/// `T J T ⪰ least` for a symmetric matrix J that is linear in a link's parameters, with T making that of a body of the link's
/// size a matrix of order one. Upper triangle by columns, off-diagonal entries times √2, as the solver wants its cones.
#[allow(clippy::too_many_arguments)]
fn cone_rows(
    layout: &Layout,
    link: usize,
    mass: f64,
    unit: &[f64],
    matrix: LinkMatrix,
    scale: &DVector<f64>,
    least: f64,
    found: &mut Constraints,
) {
    let basis: Vec<_> = (0..10)
        .map(|k| {
            let mut parameters = [0.0; 10];
            parameters[k] = 1.0;
            matrix(&LinkInertia::from_parameters(&parameters))
        })
        .collect();
    for c in 0..unit.len() {
        for r in 0..=c {
            let factor = if r == c { 1.0 } else { std::f64::consts::SQRT_2 } / (mass * unit[r] * unit[c]);
            let row: Vec<_> = Inertial::ALL
                .iter()
                .map(|&which| (layout.inertial(link, which), factor * basis[which as usize][(r, c)]))
                .filter(|(_, v)| *v != 0.0)
                .map(|(i, v)| (i, v * scale[i]))
                .collect();
            found.row(
                (link, Constraint::PseudoInertia),
                true,
                &row,
                if r == c { least } else { 0.0 },
            );
        }
    }
    found.cones.push(SupportedConeT::PSDTriangleConeT(unit.len()));
}

fn upper(p: &DMatrix<f64>) -> CscMatrix<f64> {
    compressed(p, |r, c| r <= c)
}

fn compressed(dense: &DMatrix<f64>, wanted: impl Fn(usize, usize) -> bool) -> CscMatrix<f64> {
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for c in 0..dense.ncols() {
        for r in 0..dense.nrows() {
            if wanted(r, c) && dense[(r, c)] != 0.0 {
                rows.push(r);
                values.push(dense[(r, c)]);
            }
        }
        starts.push(rows.len());
    }
    CscMatrix::new(dense.nrows(), dense.ncols(), starts, rows, values)
}
