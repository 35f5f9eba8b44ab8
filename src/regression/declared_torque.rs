//! The declared model along a motion: rows of the base parameters, and the rigid and declared torque.

use super::dataset::{ShapedRows, Stretch};
use super::model::AugmentedModel;
use crate::dynamics::{Chain, ColumnSet, Coulomb, RowBlocks};
use crate::effects::Motions;
use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use crate::regression::settings::SETTINGS;

/// Torques along a motion, n × N.
#[derive(Debug, Clone, Default)]
pub(crate) struct Torques {
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
}

impl AugmentedModel {
    /// Rows of the base parameters along the motion as measured.
    pub(crate) fn base_rows(&self, stretch: &Stretch) -> ShapedRows {
        let mut shaped: ShapedRows = vec![Vec::new(); self.robot.joint_count()];
        self.for_batches(&self.robot, Motions::stiff(&stretch.motion), |first, set, rows| {
            for (j, own) in shaped.iter_mut().enumerate() {
                let shaped = stretch.shaped_block(rows, j, set.row(j)).into_iter();
                own.extend(shaped.map(|(at, values)| (first + at, values)));
            }
        });
        shaped
    }

    /// Rows of some base parameters after others along a motion, as many at a time as a long log leaves room for; with the number
    /// of the first.
    pub(super) fn for_batches(&self, robot: &Robot, motions: Motions, mut each: impl FnMut(usize, &ColumnSet, &RowBlocks)) {
        let (layout, chain) = (Layout::standard(robot), Chain::new(robot));
        let batch = (SETTINGS.regressor_numbers / (motions.motors.samples() * robot.joint_count()).max(1)).max(1);
        for (i, part) in self.base.kept.chunks(batch).enumerate() {
            let set = ColumnSet::new(robot, &layout, part);
            let rows = filled(&chain, &set, motions);
            each(i * batch, &set, &rows);
        }
    }

    pub(crate) fn fill(&self, robot: &Robot, motions: Motions) -> (ColumnSet, RowBlocks) {
        let set = self.columns();
        let rows = filled(&Chain::new(robot), &set, motions);
        (set, rows)
    }

    fn columns(&self) -> ColumnSet {
        ColumnSet::new(&self.robot, &Layout::standard(&self.robot), &self.base.kept)
    }

    /// Rigid and declared torque along a motion, from rows where they are there already.
    pub(crate) fn torques(&self, motions: Motions, robot: &Robot, rows: Option<(&ColumnSet, &RowBlocks)>) -> Torques {
        let layout = Layout::standard(robot);
        let n = robot.joint_count();
        let mut phi = vec![0.0; layout.len()];
        self.base
            .kept
            .iter()
            .zip(self.values.iter())
            .for_each(|(&at, &v)| phi[at] = v);
        let inertial = |at: usize| matches!(layout.parameters()[at].kind, ParameterKind::Inertial(_));
        let rigid = match rows {
            Some((set, rows)) => (0..n)
                .map(|j| {
                    let mut sum = vec![0.0; rows.samples()];
                    let columns = rows.block(j).chunks_exact(rows.stride()).zip(set.row(j));
                    for (values, &at) in columns.filter(|(_, at)| inertial(self.base.kept[**at])) {
                        sum.iter_mut().zip(values).for_each(|(s, v)| *s += v * self.values[at]);
                    }
                    sum
                })
                .collect(),
            None => {
                let bare: Vec<f64> = phi
                    .iter()
                    .enumerate()
                    .map(|(at, &v)| if inertial(at) { v } else { 0.0 })
                    .collect();
                let links = motions.links;
                let flat = crate::dynamics::inverse_dynamics_batch(&Chain::new(robot), &layout, &bare, links, Coulomb::Sign);
                (0..n)
                    .map(|j| flat[j * links.stride()..j * links.stride() + links.samples()].to_vec())
                    .collect::<Vec<_>>()
            }
        };
        let mut declared: Vec<Vec<f64>> = rigid.clone();
        for (at, parameter) in layout
            .parameters()
            .iter()
            .enumerate()
            .filter(|(at, _)| phi[*at] != 0.0 && !inertial(*at))
        {
            let speeds = motions.motors.velocities(parameter.link);
            let column = |v: f64| {
                if parameter.kind == ParameterKind::Viscous {
                    v
                } else {
                    Coulomb::Sign.value(v)
                }
            };
            declared[parameter.link]
                .iter_mut()
                .zip(speeds)
                .for_each(|(t, &v)| *t += phi[at] * column(v));
        }
        Torques { rigid, declared }
    }
}

/// Rows of some columns along a motion: bodies by the links, friction by the motors.
fn filled(chain: &Chain, set: &ColumnSet, motions: Motions) -> RowBlocks {
    let mut rows = RowBlocks::new(set, motions.links.samples());
    rows.fill(chain, set, motions.links, Coulomb::Sign);
    if !std::ptr::eq(motions.motors, motions.links) {
        rows.fill_friction(set, motions.motors, Coulomb::Sign);
    }
    rows
}
