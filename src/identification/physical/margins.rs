//! How far a parameter set is from every limit of what is physical.

use crate::parameters::{Layout, ParameterKind};

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
    /// Viscous friction not negative.
    Viscous,
    /// Coulomb friction not negative.
    Coulomb,
    /// A stated bound, in the unit of what it bounds.
    Bound,
}

impl Constraint {
    pub fn code(self) -> &'static str {
        match self {
            Self::Mass => "mass_positive",
            Self::PseudoInertia => "pseudo_inertia_positive_definite",
            Self::PrincipalMoment => "principal_moments_positive",
            Self::TriangleInequality => "principal_moments_triangle",
            Self::Viscous => "viscous_not_negative",
            Self::Coulomb => "coulomb_not_negative",
            Self::Bound => "bound",
        }
    }
}

/// Positive where the constraint holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstraintMargin {
    /// From 0.
    pub link: usize,
    pub constraint: Constraint,
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
