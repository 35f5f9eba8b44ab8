//! Base parameters: the smallest set that determines the torques.

use super::{Expression, Layout, exact};
use crate::model::Robot;
use nalgebra::{DMatrix, DVector};

/// The base parameters `pi_b = K pi`, `Y = Y_b K` with `Y_b = Y[:, kept]` (the paper's (7)).
#[derive(Debug, Clone, PartialEq)]
pub struct BaseParameters {
    /// Standard parameters that stay, ascending: the columns of Y that make Y_b.
    pub kept: Vec<usize>,
    /// b × p; the identity in the columns of `kept`.
    pub map: DMatrix<f64>,
    /// `MYR2` where others are regrouped into MY2, `MX2` where none is.
    pub names: Vec<String>,
    /// What each stands for, in standard parameters.
    pub expressions: Vec<Expression>,
    /// SI units.
    pub units: Vec<&'static str>,
}

impl BaseParameters {
    /// In closed form from the kinematics (Gautier & Khalil 1990): the coefficients are products of lengths, sines and cosines of
    /// the robot description.
    pub fn exact(robot: &Robot) -> Self {
        let layout = Layout::standard(robot);
        let nulls = exact::null_vectors(robot, &layout);
        Self::from_nulls(&layout, nulls)
    }

    /// Eliminates from the last parameter to the first: a parameter goes when a null vector ends in it.
    fn from_nulls(layout: &Layout, mut nulls: DMatrix<f64>) -> Self {
        // Entries are sums of a few products of lengths and cosines: rounding is 1e-16 of the largest. The smallest length that
        // means something, 1 µm, squared, is 1e-12.
        let tolerance = 1e-13 * nulls.amax().max(1.0);
        let mut ending_in = vec![None; layout.len()];
        let mut next = 0;
        for column in (0..layout.len()).rev() {
            let rows = nulls.nrows();
            let Some(pivot) = (next..rows).max_by(|&a, &b| nulls[(a, column)].abs().total_cmp(&nulls[(b, column)].abs())) else {
                break;
            };
            if nulls[(pivot, column)].abs() <= tolerance {
                (next..rows).for_each(|r| nulls[(r, column)] = 0.0);
                continue;
            }
            nulls.swap_rows(pivot, next);
            let scale = nulls[(next, column)];
            nulls.row_mut(next).iter_mut().for_each(|v| *v /= scale);
            let reference = nulls.row(next).into_owned();
            for r in (0..rows).filter(|&r| r != next) {
                let factor = nulls[(r, column)];
                if factor != 0.0 {
                    nulls
                        .row_mut(r)
                        .iter_mut()
                        .zip(reference.iter())
                        .for_each(|(v, p)| *v -= factor * p);
                }
            }
            ending_in[column] = Some(next);
            next += 1;
        }
        let kept: Vec<usize> = (0..layout.len()).filter(|&c| ending_in[c].is_none()).collect();
        let mut map = DMatrix::zeros(kept.len(), layout.len());
        for (row, &c) in kept.iter().enumerate() {
            map[(row, c)] = 1.0;
        }
        for (column, null) in ending_in.iter().enumerate().filter_map(|(c, n)| n.map(|n| (c, n))) {
            for (row, &c) in kept.iter().enumerate() {
                let v = -nulls[(null, c)];
                map[(row, column)] = if v.abs() <= tolerance { 0.0 } else { v };
            }
        }
        Self::new(layout, kept, map)
    }

    fn new(layout: &Layout, kept: Vec<usize>, map: DMatrix<f64>) -> Self {
        let expressions: Vec<_> = (0..kept.len())
            .map(|row| {
                let terms = (0..layout.len()).filter(|&c| map[(row, c)] != 0.0);
                // The parameter that gives the name comes first, whatever its number.
                let own = kept[row];
                let order = std::iter::once(own).chain(terms.filter(|&c| c != own));
                Expression::new(order.map(|c| (map[(row, c)], layout.parameters()[c])).collect())
            })
            .collect();
        let names = kept
            .iter()
            .zip(&expressions)
            .map(|(&c, e)| {
                let parameter = layout.parameters()[c];
                let regrouped = if e.terms().len() > 1 { "R" } else { "" };
                format!("{}{regrouped}{}", parameter.symbol(), parameter.link + 1)
            })
            .collect();
        let units = kept.iter().map(|&c| layout.unit(c)).collect();
        Self {
            kept,
            map,
            names,
            expressions,
            units,
        }
    }

    /// Number of base parameters b.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// `pi_b = K pi`.
    pub fn project(&self, phi: &[f64]) -> DVector<f64> {
        &self.map * DVector::from_column_slice(phi)
    }
}

/// The same by rank-revealing elimination of an observation matrix, and how clear the decision was.
#[derive(Debug, Clone, PartialEq)]
pub struct NumericBase {
    /// The base parameters.
    pub base: BaseParameters,
    /// Smallest part of a kept column that the columns before it cannot make, relative to the column.
    pub weakest_kept: f64,
    /// Largest such part of a column that was dropped.
    pub strongest_dropped: f64,
}

/// Base parameters from the observation matrix W (rows × p) of a motion: a column stays unless the columns before it make it.
///
/// Gram-Schmidt with reorthogonalisation from the first column on, so that the choice is Khalil's; the map solves
/// `W = W_b K`. Columns whose own part is below `relative_tolerance` are dropped.
pub fn numeric_base(layout: &Layout, w: &DMatrix<f64>, relative_tolerance: f64) -> NumericBase {
    let p = layout.len();
    assert_eq!(w.ncols(), p, "one column per standard parameter");
    let largest = (0..p).map(|c| w.column(c).norm()).fold(0.0, f64::max);
    let mut directions: Vec<DVector<f64>> = Vec::new();
    let (mut kept, mut weakest_kept, mut strongest_dropped) = (Vec::new(), f64::INFINITY, 0.0f64);
    for c in 0..p {
        let mut rest = w.column(c).into_owned();
        let norm = rest.norm();
        for _ in 0..2 {
            for d in &directions {
                let along = d.dot(&rest);
                rest.axpy(-along, d, 1.0);
            }
        }
        // A column of rounding errors has no direction of its own either.
        let own = if norm <= relative_tolerance * largest {
            0.0
        } else {
            rest.norm() / norm
        };
        if own > relative_tolerance {
            weakest_kept = weakest_kept.min(own);
            directions.push(rest.normalize());
            kept.push(c);
        } else {
            strongest_dropped = strongest_dropped.max(own);
        }
    }
    let basis = w.select_columns(&kept);
    let qr = basis.qr();
    let projected = qr.q().transpose() * w;
    let mut map = projected;
    qr.r().solve_upper_triangular_mut(&mut map);
    // Rounding of the solution: tolerance-sized coefficients are zeros.
    map.apply(|v| *v = if v.abs() < relative_tolerance { 0.0 } else { *v });
    NumericBase {
        base: BaseParameters::new(layout, kept, map),
        weakest_kept,
        strongest_dropped,
    }
}
