//! One effect, or several at once, beside a fitted model: normal equations by blocks of time.

use super::blocks::{Blocks, residual};
use crate::diagnosis::selection::{Scored, columns_of, reach};
use crate::regression::{Data, System, Whitened, transposed_product, width};
use nalgebra::{DMatrix, DVector};

/// Effects that come together, with their columns.
pub(crate) struct Contender<'a> {
    pub members: Vec<&'a Scored>,
    pub columns: Whitened,
    /// Joints that the columns reach.
    pub joints: Vec<usize>,
    /// What the fit to all blocks makes of the columns in the model's coordinates, `Hᵀ Jᵀ C`. In what follows columns are without
    /// that part, `C − J H a`: what the model holds already is no matter of the contender, and may be nearly all of it.
    pub(super) along: DMatrix<f64>,
    /// `CᵀC` of the whole columns.
    pub(super) whole: DMatrix<f64>,
    /// Of every block: the model's coordinates times the columns, the columns times themselves, and times the residual.
    pub(super) cross: Vec<DMatrix<f64>>,
    pub(super) own: Vec<DMatrix<f64>>,
    pub(super) right: Vec<DVector<f64>>,
    /// Sum of `own`.
    pub(super) open: DMatrix<f64>,
}

impl<'a> Contender<'a> {
    pub fn of(data: &Data, system: &System, blocks: &Blocks, members: Vec<&'a Scored>) -> Self {
        let shape = |s: &Scored| match s.term.is_distortion() {
            true => Vec::new(),
            false => s.term.shape.clone(),
        };
        let each = members
            .iter()
            .map(|s| columns_of(data, system, &s.candidate, &[shape(s)]))
            .collect::<Vec<_>>();
        Self::with_columns(system, blocks, members, side_by_side(&each))
    }

    pub fn with_columns(system: &System, blocks: &Blocks, members: Vec<&'a Scored>, columns: Whitened) -> Self {
        let joints = system.model.robot.joint_count();
        let mut reached: Vec<usize> = members.iter().flat_map(|s| reach(&s.candidate, joints)).collect();
        reached.sort_unstable();
        reached.dedup();
        let size = blocks.root.ncols();
        let k = width(&columns);
        let (mut cross, mut own, mut right) = (Vec::new(), Vec::new(), Vec::new());
        for (time, rows) in blocks.times.iter().zip(&blocks.rows) {
            let (mut c, mut o, mut r) = (DMatrix::zeros(size, k), DMatrix::zeros(k, k), DVector::zeros(k));
            for (j, m) in &columns[time.stretch] {
                let m = m.rows(time.rows.start, time.rows.len()).into_owned();
                c += transposed_product(&rows[*j], &m);
                o += transposed_product(&m, &m);
                r += m.tr_mul(&residual(system, time, *j));
            }
            cross.push(c);
            own.push(o);
            right.push(r);
        }
        let total = |parts: &[DMatrix<f64>]| parts.iter().fold(DMatrix::zeros(parts[0].nrows(), k), |sum, m| sum + m);
        let (along, whole) = (total(&cross), total(&own));
        for b in 0..cross.len() {
            let inside = &blocks.inside[b] * &along;
            let through = transposed_product(&along, &cross[b]);
            own[b] += transposed_product(&along, &inside) - &through - through.transpose();
            right[b] -= along.tr_mul(&blocks.gradient[b]);
            cross[b] -= inside;
        }
        Self {
            open: total(&own),
            members,
            columns,
            joints: reached,
            along,
            whole,
            cross,
            own,
            right,
        }
    }

    /// Parameters that the members cost: a shape each beside the rank of the columns.
    pub fn cost(&self) -> usize {
        self.members.iter().map(|s| s.cost).sum()
    }
}

/// Columns of several candidates as those of one.
pub(crate) fn side_by_side(each: &[Whitened]) -> Whitened {
    let widths: Vec<usize> = each.iter().map(width).collect();
    let all: usize = widths.iter().sum();
    let stretch = |s: usize| {
        let mut joints: Vec<usize> = each.iter().flat_map(|e| e[s].iter().map(|(j, _)| *j)).collect();
        joints.sort_unstable();
        joints.dedup();
        let joint = |j: usize| {
            let rows = each
                .iter()
                .flat_map(|e| &e[s])
                .find(|(own, _)| *own == j)
                .map_or(0, |(_, m)| m.nrows());
            let mut whole = DMatrix::zeros(rows, all);
            let mut from = 0;
            for (columns, k) in each.iter().zip(&widths) {
                if let Some((_, m)) = columns[s].iter().find(|(own, _)| *own == j) {
                    whole.columns_mut(from, *k).copy_from(m);
                }
                from += k;
            }
            (j, whole)
        };
        joints.into_iter().map(joint).collect()
    };
    (0..each.first().map_or(0, Vec::len)).map(stretch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_columns_side_by_side_stay_on_their_joints() {
        let on = |joint: usize, values: &[f64]| vec![vec![(joint, DMatrix::from_column_slice(2, values.len() / 2, values))]];
        let all = side_by_side(&[on(3, &[1.0, 2.0]), on(1, &[3.0, 4.0, 5.0, 6.0]), on(3, &[7.0, 8.0])]);
        let joints: Vec<usize> = all[0].iter().map(|(j, _)| *j).collect();
        assert_eq!(joints, [1, 3]);
        assert_eq!(
            all[0][0].1,
            DMatrix::from_column_slice(2, 4, &[0.0, 0.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0])
        );
        assert_eq!(
            all[0][1].1,
            DMatrix::from_column_slice(2, 4, &[1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 7.0, 8.0])
        );
    }
}
