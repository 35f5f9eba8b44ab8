//! Effects that are made of the model's own torque: how they change with the base parameters.
//!
//! `tau_j = Y_j β + (C(tau) c)_j`, so that row j changes with β by `Y_j + Σ_i ∂(C c)_j/∂tau_i Y_i`, sample by sample; the torque
//! is the rigid one, or that of the declared model with friction. Without the second part a fit is not that of least squares, and
//! its covariance takes the columns of the effect for known, when they are as uncertain as β (Seber & Wild 1989, chapter 2): a
//! cubic part of a torque came out five stated deviations off.

use super::dataset::{ShapedRows, Stretch};
use super::model::{AugmentedModel, Term};
use crate::dynamics::{Chain, ColumnSet, Coulomb, RowBlocks};
use crate::effects::Scene;
use crate::parameters::{Layout, ParameterKind};
use crate::regression::settings::SETTINGS;
use std::collections::BTreeMap;

/// `∂(C c)_row/∂tau_source` over the samples, by the rigid torque alone or by that of the declared model.
struct Slope {
    row: usize,
    source: usize,
    rigid: bool,
    values: Vec<f64>,
}

impl AugmentedModel {
    /// Whether an effect changes with the base parameters.
    pub(crate) fn reads_torques(&self) -> bool {
        self.terms.iter().any(reads_torques)
    }

    /// Adds to the derivatives by the base parameters what they have through the effects that read torques.
    pub(crate) fn push_torque_derivatives(&self, jacobian: &mut ShapedRows, stretch: &Stretch, scene: &Scene, gain: &[f64]) {
        let terms = self.terms.iter().filter(|t| reads_torques(t));
        let slopes: Vec<Slope> = terms.flat_map(|t| slopes(t, scene)).collect();
        if slopes.is_empty() {
            return;
        }
        let layout = Layout::standard(scene.robot);
        let chain = Chain::new(scene.robot);
        let samples = scene.motion.samples();
        let batch = (SETTINGS.regressor_numbers / (samples * scene.robot.joint_count()).max(1)).max(1);
        let is_rigid = |at: usize| matches!(layout.parameters()[self.base.kept[at]].kind, ParameterKind::Inertial(_));
        for (first, part) in self.base.kept.chunks(batch).enumerate().map(|(i, part)| (i * batch, part)) {
            let set = ColumnSet::new(scene.robot, &layout, part);
            let mut rows = RowBlocks::new(&set, samples);
            rows.fill(&chain, &set, scene.motion, Coulomb::Sign);
            for slope in &slopes {
                let columns = rows
                    .block(slope.source)
                    .chunks_exact(rows.stride())
                    .zip(set.row(slope.source));
                let read = columns.filter(|(_, at)| !slope.rigid || is_rigid(first + **at));
                let through = |(column, at): (&[f64], &usize)| {
                    let values = column.iter().zip(&slope.values).map(|(y, s)| y * s * gain[slope.row]);
                    (first + at, values.collect())
                };
                jacobian[slope.row].extend(stretch.shaped_with(read.map(through)));
            }
        }
    }
}

fn reads_torques(term: &Term) -> bool {
    term.effect.reads_torques() && !term.is_distortion() && term.coefficients.iter().any(|c| *c != 0.0)
}

/// Slopes of one term by the torque of every joint, those that are zero left out. Differences are taken over a millionth of the
/// largest torque, which is far above its rounding and far below the curvature of any effect.
fn slopes(term: &Term, scene: &Scene) -> Vec<Slope> {
    let mut found = Vec::new();
    for source in 0..scene.robot.joint_count() {
        let largest = scene.declared[source].iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let step = 1e-6 * largest.max(1e-6);
        for rigid in [true, false] {
            let up = torque(term, scene, (source, rigid, step));
            let down = torque(term, scene, (source, rigid, -step));
            let slope = |((row, u), d): ((usize, Vec<f64>), Vec<f64>)| Slope {
                row,
                source,
                rigid,
                values: u.iter().zip(d).map(|(u, d)| (u - d) / (2.0 * step)).collect(),
            };
            let slopes = up.into_iter().zip(down.into_values()).map(slope);
            found.extend(slopes.filter(|s| s.values.iter().any(|v| *v != 0.0)));
        }
    }
    found
}

/// Torque of a term per joint, where the rigid (or declared) torque of a joint is another by so much.
fn torque(term: &Term, scene: &Scene, (source, rigid, by): (usize, bool, f64)) -> BTreeMap<usize, Vec<f64>> {
    let read = if rigid { scene.rigid } else { scene.declared };
    let mut moved = read.to_vec();
    moved[source].iter_mut().for_each(|v| *v += by);
    let there = match rigid {
        true => Scene { rigid: &moved, ..*scene },
        false => Scene {
            declared: &moved,
            ..*scene
        },
    };
    let mut sum: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    let columns = term.effect.columns(term.form, &there, &term.joints, &term.shape);
    for (column, c) in columns.into_iter().zip(&term.coefficients) {
        for (j, values) in column.rows {
            let own = sum.entry(j).or_insert_with(|| vec![0.0; values.len()]);
            own.iter_mut().zip(values).for_each(|(t, v)| *t += c * v);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use crate::dynamics::Motion;
    use crate::effects::by_code;
    use crate::regression::motion_error::tests::two_links;
    use crate::regression::{AugmentedModel, Stretch, Term};

    fn term(code: &str, joints: &[usize], coefficient: f64) -> Term {
        Term {
            effect: by_code(code).unwrap().into(),
            joints: joints.to_vec(),
            ..Term::constant(joints[0], coefficient)
        }
    }

    /// Crosstalk reads the declared torque of another joint, load-dependent friction the size of the rigid torque of its own.
    #[test]
    fn prop_derivatives_by_base_parameters_are_differences_of_the_torque() {
        let wave = |j: usize, s: usize| 0.3 + std::f64::consts::TAU * s as f64 / (40.0 + 9.0 * j as f64);
        let motion = Motion::from_fn(2, 200, |j, s| {
            [wave(j, s).sin(), 2.0 * wave(j, s).cos(), -4.0 * wave(j, s).sin()]
        });
        let stretch = Stretch::of_motion(motion, 0.01, false);
        let mut model = AugmentedModel::declared(&two_links());
        let count = model.values.len();
        (0..count).for_each(|at| model.values[at] = 0.5 + 0.3 * at as f64);
        model.terms = vec![
            term("torque_crosstalk", &[0, 1], 0.2),
            term("load_dependent_friction", &[1], 0.1),
            term("torque_gain", &[0], 0.0),
        ];
        model.terms[2].coefficients.clear();
        model.terms[2].shape = vec![0.1];
        model.terms[2].free_shapes = 1;
        model.terms[2].bounds = vec![[-1.0, 1.0]];
        let derivatives = model.evaluate(&stretch, Some(&model.base_rows(&stretch))).jacobian;
        for at in 0..count {
            // Torques of the order of 10, rounded to 1e-15 of that, over steps of 1e-5.
            let side = |by: f64| {
                let mut moved = model.clone();
                moved.values[at] += by;
                moved.predict(&stretch)
            };
            let (up, down) = (side(1e-5), side(-1e-5));
            for (j, columns) in derivatives.iter().enumerate() {
                let mut difference_seen = false;
                for s in 0..200 {
                    let own: f64 = columns.iter().filter(|c| c.0 == at).map(|c| c.1[s]).sum();
                    let difference = (up[j][s] - down[j][s]) / 2e-5;
                    assert!(
                        (own - difference).abs() < 1e-8 * (1.0 + difference.abs()),
                        "parameter {at} joint {j} sample {s}: {own} {difference}"
                    );
                    difference_seen |= difference != 0.0;
                }
                // The crosstalk brings every parameter of the second joint to the first.
                assert!(difference_seen || j == 1, "parameter {at} shows on the first joint");
            }
        }
    }
}
