//! The constraints (10b), (10c), (10d) on μ, with derivatives and margins.

use super::variables::{ENTRIES, Variables};
use super::{PaperOptions, Triangle};
use crate::identification::physical::{Constraint, ConstraintMargin};
use crate::model::{Axis, LinkBounds};
use crate::parameters::ParameterKind;
use nalgebra::{DMatrix, Matrix3};

/// `Σ a μ ≥ right`.
struct Row {
    link: usize,
    constraint: Constraint,
    terms: Vec<(usize, f64)>,
    right: f64,
    /// What a violation is measured in.
    unit: f64,
}

/// A tensor that must stay definite.
#[derive(Clone, Copy, PartialEq)]
enum Definite {
    /// The inertia itself: (10c).
    Inertia,
    /// `½ tr(I) E − I`: the triangle inequality of the principal moments, which implies (10c).
    SecondMoment,
}

pub(super) struct Limits {
    rows: Vec<Row>,
    definite: Option<Definite>,
    links: usize,
    /// First of the six inertia entries of every link.
    inertia: Vec<usize>,
}

/// Smallest part of the trace that an eigenvalue of a definite tensor may be: a body a hundredth as thick as it is long.
const THINNEST: f64 = 1e-4;
/// Linear constraints are kept by this much, in their units, so that a solver that exceeds them by as much still meets them.
const TOLERANCE: f64 = 1e-9;
/// What an eigenvalue may be short of its least: half of that, so that bodies stay bodies. Where constraints are curved a solver
/// comes from outside, and would never arrive at a tolerance of rounding.
const EIGENVALUE_TOLERANCE: f64 = 0.5 * THINNEST;
/// Products of inertia up to this part of the least diagonal entry leave a matrix that is definite by its dominant diagonal.
const DOMINATED: f64 = 0.5;
/// Least mass (10c), as a part of a rod's in the link's place: zero itself has no centre of mass.
const LEAST_MASS: f64 = 1e-3;

/// Entries of the diagonal among the six.
const DIAGONAL: [usize; 3] = [0, 3, 5];
const PRODUCTS: [usize; 3] = [1, 2, 4];

impl Limits {
    pub fn new(variables: &Variables, options: &PaperOptions) -> Self {
        let mut limits = Self {
            rows: Vec::new(),
            definite: match options.triangle {
                Triangle::Principal => Some(Definite::SecondMoment),
                _ if options.gazebo && options.product_ratio.is_some_and(|r| r < DOMINATED) => None,
                _ => Some(Definite::Inertia),
            },
            links: variables.links,
            inertia: (0..variables.links).map(|k| variables.first(k) + 4).collect(),
        };
        for link in 0..variables.links {
            limits.masses_and_friction(variables, options, link);
            if options.gazebo || options.triangle == Triangle::Diagonal {
                limits.diagonal(variables, options, link);
            }
            if let Some(bounds) = options.bounds.get(link) {
                limits.bounds(variables, bounds, link);
            }
        }
        limits
    }

    fn push(&mut self, variables: &Variables, link: usize, constraint: Constraint, terms: Vec<(usize, f64)>, right: f64) {
        let unit = variables.scale[terms[0].0];
        self.rows.push(Row {
            link,
            constraint,
            terms,
            right,
            unit,
        });
    }

    fn masses_and_friction(&mut self, variables: &Variables, options: &PaperOptions, link: usize) {
        let mass = variables.first(link);
        let least = LEAST_MASS * variables.scale[mass];
        self.push(variables, link, Constraint::Mass, vec![(mass, 1.0)], least);
        if let Some(at) = variables.friction(link, ParameterKind::Viscous) {
            self.push(variables, link, Constraint::Viscous, vec![(at, 1.0)], options.least_viscous);
        }
        if let Some(at) = variables.friction(link, ParameterKind::Coulomb) {
            self.push(variables, link, Constraint::Coulomb, vec![(at, 1.0)], 0.0);
        }
    }

    fn diagonal(&mut self, variables: &Variables, options: &PaperOptions, link: usize) {
        let first = self.inertia[link];
        let at = |entry: usize| first + entry;
        if options.triangle != Triangle::None {
            for longest in DIAGONAL {
                let sign = |e: usize| if e == longest { -1.0 } else { 1.0 };
                let terms = DIAGONAL.map(|e| (at(e), sign(e))).to_vec();
                self.push(variables, link, Constraint::DiagonalTriangle, terms, 0.0);
            }
        }
        if !options.gazebo {
            return;
        }
        for e in DIAGONAL {
            self.push(
                variables,
                link,
                Constraint::LeastMoment,
                vec![(at(e), 1.0)],
                options.least_moment,
            );
        }
        let slender = options.slender.get(link).copied().flatten().map(|axis| match axis {
            Axis::X => DIAGONAL[0],
            Axis::Y => DIAGONAL[1],
            Axis::Z => DIAGONAL[2],
        });
        // About the slender axis the moment is the least: the other comparisons follow from that.
        let smallest = match slender.filter(|_| options.slender_ratio.is_some_and(|r| r >= 1.0)) {
            Some(along) => vec![along],
            None => DIAGONAL.to_vec(),
        };
        for &small in &smallest {
            for large in DIAGONAL.into_iter().filter(|&e| e != small) {
                if let Some(ratio) = options.moment_ratio {
                    let terms = vec![(at(small), ratio), (at(large), -1.0)];
                    self.push(variables, link, Constraint::MomentRatio, terms, 0.0);
                }
                if let Some(ratio) = options.slender_ratio.filter(|_| slender == Some(small)) {
                    let terms = vec![(at(large), 1.0), (at(small), -ratio)];
                    self.push(variables, link, Constraint::SlenderAxis, terms, 0.0);
                }
            }
            for (product, sign) in PRODUCTS.into_iter().flat_map(|p| [(p, 1.0), (p, -1.0)]) {
                if let Some(ratio) = options.product_ratio {
                    let terms = vec![(at(small), ratio), (at(product), sign)];
                    self.push(variables, link, Constraint::ProductsOfInertia, terms, 0.0);
                }
            }
        }
    }

    fn bounds(&mut self, variables: &Variables, bounds: &LinkBounds, link: usize) {
        let first = variables.first(link);
        let mut between = |constraint, at: usize, bound: Option<[f64; 2]>| {
            if let Some([low, high]) = bound {
                self.push(variables, link, constraint, vec![(at, 1.0)], low);
                self.push(variables, link, constraint, vec![(at, -1.0)], -high);
            }
        };
        between(Constraint::BoundMass, first, bounds.mass);
        for (axis, bound) in bounds.center_of_mass.iter().flatten().enumerate() {
            between(Constraint::BoundCenterOfMass, first + 1 + axis, Some(*bound));
        }
        for (entry, bound) in bounds.inertia.iter().enumerate() {
            between(Constraint::BoundInertia, first + 4 + entry, *bound);
        }
        if let Some(at) = variables.friction(link, ParameterKind::Viscous) {
            between(Constraint::BoundViscous, at, bounds.viscous);
        }
        if let Some(at) = variables.friction(link, ParameterKind::Coulomb) {
            between(Constraint::BoundCoulomb, at, bounds.coulomb);
        }
    }

    pub fn len(&self) -> usize {
        self.rows.len() + if self.definite.is_some() { 3 * self.links } else { 0 }
    }

    /// What every constraint may be exceeded by.
    pub fn tolerances(&self) -> Vec<f64> {
        let mut tolerances = vec![TOLERANCE; self.rows.len()];
        tolerances.resize(self.len(), EIGENVALUE_TOLERANCE);
        tolerances
    }

    /// g(μ) ≤ 0, each in its own unit; the rows of the Jacobian by *scaled* variables (μ = scale ∘ s) where they are wanted.
    pub fn evaluate(&self, mu: &[f64], scale: &[f64], out: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        if let Some(j) = jacobian.as_deref_mut() {
            j.fill(0.0);
        }
        for (i, row) in self.rows.iter().enumerate() {
            let left: f64 = row.terms.iter().map(|&(at, a)| a * mu[at]).sum();
            out[i] = (row.right - left) / row.unit + TOLERANCE;
            if let Some(j) = jacobian.as_deref_mut() {
                row.terms.iter().for_each(|&(at, a)| j[(i, at)] -= a * scale[at] / row.unit);
            }
        }
        let Some(definite) = self.definite else { return };
        for (link, &first) in self.inertia.iter().enumerate() {
            let at = self.rows.len() + 3 * link;
            let values = eigenvalues(definite, &mu[first..first + 6], scale[first]);
            for (k, (value, gradient)) in values.into_iter().enumerate() {
                out[at + k] = -value;
                if let Some(j) = jacobian.as_deref_mut() {
                    (0..6).for_each(|e| j[(at + k, first + e)] = -gradient[e] * scale[first + e]);
                }
            }
        }
    }

    /// The least margin of every constraint of every link, in the unit of what it constrains.
    pub fn margins(&self, mu: &[f64]) -> Vec<ConstraintMargin> {
        let mut found: Vec<ConstraintMargin> = Vec::new();
        for row in &self.rows {
            let margin = row.terms.iter().map(|&(at, a)| a * mu[at]).sum::<f64>() - row.right;
            match found
                .iter_mut()
                .find(|m| m.link == row.link && m.constraint == row.constraint)
            {
                Some(known) => known.margin = known.margin.min(margin),
                None => found.push(ConstraintMargin {
                    link: row.link,
                    constraint: row.constraint,
                    margin,
                }),
            }
        }
        found
    }
}

/// Eigenvalues of `M/tr M` less ε, and their derivatives by xx, xy, xz, yy, yz, zz of the inertia: `dλ = v·dM v` for unit
/// eigenvectors v. `size` is the inertia's natural size. (Leading minors are smooth where eigenvalues cross, but thin bodies make
/// them products of small numbers, on which a solver stalls.)
fn eigenvalues(definite: Definite, entries: &[f64], size: f64) -> [(f64, [f64; 6]); 3] {
    let inertia = Matrix3::new(
        entries[0], entries[1], entries[2], entries[1], entries[3], entries[4], entries[2], entries[4], entries[5],
    );
    let m = match definite {
        Definite::Inertia => inertia,
        Definite::SecondMoment => Matrix3::identity() * (0.5 * inertia.trace()) - inertia,
    };
    // On its way a solver may step to where the trace is negative: the other constraints lead it back.
    let trace = m.trace().max(1e-6 * size);
    let eigen = m.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.map(|k| {
        let (value, v) = (eigen.eigenvalues[k], eigen.eigenvectors.column(k));
        // By M: d(λ/t) = v vᵀ/t − λ E/t²; then by I.
        let by_m = v * v.transpose() / trace - Matrix3::identity() * (value / (trace * trace));
        let by_i = match definite {
            Definite::Inertia => by_m,
            Definite::SecondMoment => Matrix3::identity() * (0.5 * by_m.trace()) - by_m,
        };
        let entries = ENTRIES.map(|(r, c)| by_i[(r, c)] * if r == c { 1.0 } else { 2.0 });
        (value / trace - THINNEST, entries)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_eigenvalues_have_their_derivatives() {
        let entries = [0.03, 0.002, -0.001, 0.04, 0.003, 0.025];
        for definite in [Definite::Inertia, Definite::SecondMoment] {
            let exact = eigenvalues(definite, &entries, 0.1);
            for e in 0..6 {
                let h = 1e-7;
                let (mut up, mut down) = (entries, entries);
                (up[e], down[e]) = (up[e] + h, down[e] - h);
                let (up, down) = (eigenvalues(definite, &up, 0.1), eigenvalues(definite, &down, 0.1));
                for k in 0..3 {
                    let difference = (up[k].0 - down[k].0) / (2.0 * h);
                    // Values are of order one and their third derivatives of 1/0.02³: rounding 1e-16/h and h² of that stay below.
                    assert!((difference - exact[k].1[e]).abs() < 1e-6, "{k} {e}");
                }
            }
        }
    }

    #[test]
    fn prop_eigenvalues_tell_bodies_from_others() {
        let positive = |entries: [f64; 6]| eigenvalues(Definite::SecondMoment, &entries, 0.1).iter().all(|m| m.0 > 0.0);
        assert!(positive([0.03, 0.0, 0.0, 0.03, 0.0, 0.01]));
        assert!(!positive([0.05, 0.0, 0.0, 0.02, 0.0, 0.02]), "0.05 > 0.02 + 0.02 is no body");
        // Diagonal entries that meet the triangle inequality, principal moments that do not.
        assert!(!positive([0.04, 0.012, 0.0, 0.03, 0.0, 0.012]));
    }
}
