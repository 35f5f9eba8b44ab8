//! A base parameter written out in standard parameters: `MY2 + MZ3 + 0.42 (M3 + M4 + M5 + M6 + M7)`.

use super::{Inertial, Parameter, ParameterKind};
use std::fmt;

/// A linear combination of standard parameters; the one that gives the name comes first.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    terms: Vec<(f64, Parameter)>,
}

impl Expression {
    /// `terms` with the parameter that gives the name first. The others follow as they are written by hand: inertias, first
    /// moments, masses, each by link.
    pub(super) fn new(mut terms: Vec<(f64, Parameter)>) -> Self {
        let rank = |p: &Parameter| match p.kind {
            ParameterKind::Inertial(Inertial::M) => 2,
            ParameterKind::Inertial(Inertial::MX | Inertial::MY | Inertial::MZ) => 1,
            _ => 0,
        };
        terms[1..].sort_by_key(|(_, p)| (rank(p), *p));
        Self { terms }
    }

    /// `(coefficient, parameter)`.
    pub fn terms(&self) -> &[(f64, Parameter)] {
        &self.terms
    }

    /// Parameters that share a coefficient to the digits shown, in order of first appearance.
    fn groups(&self) -> Vec<(f64, Vec<String>)> {
        let mut groups: Vec<(f64, Vec<String>)> = Vec::new();
        for (coefficient, parameter) in &self.terms {
            let shown = rounded(*coefficient);
            match groups.iter_mut().find(|(c, _)| *c == shown && shown.abs() != 1.0) {
                Some((_, names)) => names.push(parameter.name()),
                None => groups.push((shown, vec![parameter.name()])),
            }
        }
        groups
    }
}

/// Twelve significant digits: products of lengths given to a micrometre are exact in that, rounding is not shown.
fn rounded(v: f64) -> f64 {
    format!("{v:.11e}").parse().unwrap_or(v)
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (coefficient, names)) in self.groups().iter().enumerate() {
            match (i, *coefficient < 0.0) {
                (0, true) => write!(f, "-")?,
                (0, false) => {}
                (_, true) => write!(f, " - ")?,
                (_, false) => write!(f, " + ")?,
            }
            let magnitude = coefficient.abs();
            if magnitude != 1.0 {
                write!(f, "{magnitude} ")?;
            }
            match names.as_slice() {
                [one] => write!(f, "{one}")?,
                several => write!(f, "({})", several.join(" + "))?,
            }
        }
        Ok(())
    }
}
