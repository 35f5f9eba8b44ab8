//! How far a parameter set is from every limit of what is physical.

use super::consistent::{ConsistentOptions, boxes};
use crate::model::{LinkBounds, Robot};
use crate::parameters::{Layout, ParameterKind};

/// What makes parameters those of a body, or was asked of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Constraint {
    /// Mass above zero (kg).
    Mass,
    /// Smallest eigenvalue of the pseudo-inertia, scaled to a dimensionless matrix by the link's mass and radius of gyration.
    PseudoInertia,
    /// Smallest principal moment about the centre of mass [kg m²].
    PrincipalMoment,
    /// Sum of the two smaller principal moments less the largest [kg m²].
    TriangleInequality,
    /// Viscous friction not negative, or not below what was asked for.
    Viscous,
    /// Coulomb friction not negative.
    Coulomb,
    /// Sum of two diagonal entries of the inertia about the centre of mass less the third [kg m²].
    DiagonalTriangle,
    /// The stated multiple of the smallest diagonal entry less the largest [kg m²].
    MomentRatio,
    /// A diagonal entry across a slender link less the stated multiple of that along it [kg m²].
    SlenderAxis,
    /// The stated part of the smallest diagonal entry less the largest product of inertia [kg m²].
    ProductsOfInertia,
    /// The smallest diagonal entry less the least that was asked for [kg m²].
    LeastMoment,
    /// Distance of the centre of mass from the sides of the box around the link, the least (m).
    CenterOfMassBox,
    /// Stated bounds, in the unit of what they bound.
    BoundMass,
    /// A bound on the centre of mass.
    BoundCenterOfMass,
    /// A bound on the inertia about the centre of mass.
    BoundInertia,
    /// A bound on viscous friction.
    BoundViscous,
    /// A bound on Coulomb friction.
    BoundCoulomb,
}

impl Constraint {
    /// Name in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::Mass => "mass_positive",
            Self::PseudoInertia => "pseudo_inertia_positive_definite",
            Self::PrincipalMoment => "principal_moments_positive",
            Self::TriangleInequality => "principal_moments_triangle",
            Self::Viscous => "viscous_not_negative",
            Self::Coulomb => "coulomb_not_negative",
            Self::DiagonalTriangle => "diagonal_moments_triangle",
            Self::MomentRatio => "moment_ratio",
            Self::SlenderAxis => "slender_axis",
            Self::ProductsOfInertia => "products_of_inertia",
            Self::LeastMoment => "least_moment",
            Self::CenterOfMassBox => "center_of_mass_box",
            Self::BoundMass => "bound_mass",
            Self::BoundCenterOfMass => "bound_center_of_mass",
            Self::BoundInertia => "bound_inertia",
            Self::BoundViscous => "bound_viscous",
            Self::BoundCoulomb => "bound_coulomb",
        }
    }
}

/// Positive where the constraint holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstraintMargin {
    /// From 0.
    pub link: usize,
    /// Which constraint.
    pub constraint: Constraint,
    /// What is left to it: in its own unit (kg, kg m², N·m s/rad, N·m), of the pseudo-inertia as a fraction.
    pub margin: f64,
}

/// Margins of physical consistency of every link, from standard parameters in the order of `layout`.
pub fn margins(layout: &Layout, values: &[f64]) -> Vec<ConstraintMargin> {
    let mut found = Vec::new();
    for link in 0..layout.len() / layout.per_link() {
        let body = layout.link_inertia(values, link);
        let mut push = |constraint, margin| {
            found.push(ConstraintMargin {
                link,
                constraint,
                margin,
            })
        };
        push(Constraint::Mass, body.mass);
        if let Some(physical) = body.physical() {
            let mut moments: Vec<f64> = physical.inertia.symmetric_eigenvalues().iter().copied().collect();
            moments.sort_by(f64::total_cmp);
            push(Constraint::PrincipalMoment, moments[0]);
            push(Constraint::TriangleInequality, moments[0] + moments[1] - moments[2]);
            let (mass, length) = (body.mass.abs(), (body.inertia.trace().abs() / (2.0 * body.mass.abs())).sqrt());
            let mut pseudo = body.pseudo_inertia();
            let unit = [length, length, length, 1.0];
            for r in 0..4 {
                for c in 0..4 {
                    pseudo[(r, c)] /= mass * unit[r] * unit[c];
                }
            }
            push(Constraint::PseudoInertia, pseudo.symmetric_eigenvalues().min());
        }
        for (at, parameter) in layout.parameters().iter().enumerate().filter(|(_, p)| p.link == link) {
            match parameter.kind {
                ParameterKind::Viscous => push(Constraint::Viscous, values[at]),
                ParameterKind::Coulomb => push(Constraint::Coulomb, values[at]),
                ParameterKind::Inertial(_) => {}
            }
        }
    }
    found
}

/// A constraint that holds the solution, and what the fit would gain without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveBound {
    /// From 0.
    pub link: usize,
    /// Which constraint.
    pub constraint: Constraint,
    /// By how much the root of the cost is above that of the best fit without this constraint, in percent.
    pub cost_percent: f64,
}

/// Margins of the boxes around the links; in the frames of the links.
pub(super) fn box_margins(layout: &Layout, options: &ConsistentOptions, values: &[f64]) -> Vec<ConstraintMargin> {
    let of = |(link, sides): (usize, &[[f64; 2]; 3])| {
        let body = layout.link_inertia(values, link);
        let center = body.first_moment / body.mass;
        let margins = sides.iter().zip(&center).map(|([low, high], c)| (c - low).min(high - c));
        ConstraintMargin {
            link,
            constraint: Constraint::CenterOfMassBox,
            margin: margins.fold(f64::INFINITY, f64::min),
        }
    };
    boxes(options).map(of).collect()
}

/// Margins of stated bounds, the least of every kind and link; in the frames of the description.
pub(super) fn bound_margins(robot: &Robot, layout: &Layout, bounds: &[LinkBounds], values: &[f64]) -> Vec<ConstraintMargin> {
    let within = |value: f64, [low, high]: [f64; 2]| (value - low).min(high - value);
    let mut found = Vec::new();
    for (link, bound) in bounds.iter().enumerate() {
        let body = layout.link_inertia(values, link);
        let friction = |kind: ParameterKind| layout.parameters().iter().position(|p| p.link == link && p.kind == kind);
        let center = robot.joints()[link].description_frame * body.first_moment / body.mass;
        let least_center = bound.center_of_mass.map(|ranges| {
            let margins = ranges.iter().zip(&center).map(|(&range, &c)| within(c, range));
            margins.fold(f64::INFINITY, f64::min)
        });
        let of = |at: Option<usize>, range: Option<[f64; 2]>| Some(within(values[at?], range?));
        let margins = [
            (Constraint::BoundMass, bound.mass.map(|range| within(body.mass, range))),
            (Constraint::BoundCenterOfMass, least_center),
            (Constraint::BoundViscous, of(friction(ParameterKind::Viscous), bound.viscous)),
            (Constraint::BoundCoulomb, of(friction(ParameterKind::Coulomb), bound.coulomb)),
        ];
        found.extend(margins.into_iter().filter_map(|(constraint, margin)| {
            Some(ConstraintMargin {
                link,
                constraint,
                margin: margin?,
            })
        }));
    }
    found
}
