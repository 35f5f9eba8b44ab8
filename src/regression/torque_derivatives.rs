//! Effects that are made of the torque of their own joint: how they change with the base parameters.
//!
//! `tau_j = Y_j β + (C(tau_j) c)_j`, so that row j changes with β by `Y_j (1 + ∂(C c)_j/∂tau_j)`, sample by sample; the torque is
//! the rigid one, or that of the declared model with friction. Without the second part a fit is not that of least squares, and
//! its covariance takes the columns of the effect for known, when they are as uncertain as β (Seber & Wild 1989, chapter 2): a
//! cubic part of a torque came out five stated deviations off.
//!
//! The torque of another joint is taken for known: its own row says more of it. With that part too, crosstalk into a joint of
//! little noise has a say in the parameters of the other joint, right or wrong: on a measured LBR Med 7 the held-out error of A1
//! rose by a third, and deviations of crosstalk on virtual logs were the same.

use super::dataset::{ShapedRows, Stretch};
use super::jacobian::summed;
use super::model::{AugmentedModel, Term};
use crate::effects::{Scene, World};
use crate::parameters::{Layout, ParameterKind};

/// `∂(C c)_j/∂tau_j` over the samples, by the rigid torque alone or by that of the declared model.
struct Slope {
    joint: usize,
    rigid: bool,
    values: Vec<f64>,
}

impl AugmentedModel {
    /// Whether an effect is made of the torque of its joint.
    pub(crate) fn reads_own_torques(&self) -> bool {
        self.terms.iter().any(reads_own_torque)
    }

    /// Adds to the derivatives by the base parameters what they have through the effects that read the torque of their joint.
    pub(crate) fn push_torque_derivatives(&self, jacobian: &mut ShapedRows, stretch: &Stretch, scene: &Scene, world: &World) {
        let terms = self.terms.iter().filter(|t| reads_own_torque(t));
        let slopes: Vec<Slope> = terms.flat_map(|t| slopes(t, scene)).collect();
        if slopes.is_empty() {
            return;
        }
        let layout = Layout::standard(scene.robot);
        let is_rigid = |at: usize| matches!(layout.parameters()[self.base.kept[at]].kind, ParameterKind::Inertial(_));
        self.for_batches(scene.robot, world.motions(), |first, set, rows| {
            for slope in &slopes {
                let columns = rows.block(slope.joint).chunks_exact(rows.stride()).zip(set.row(slope.joint));
                let read = columns.filter(|(_, at)| !slope.rigid || is_rigid(first + **at));
                let through = |(column, at): (&[f64], &usize)| {
                    let values = column.iter().zip(&slope.values).map(|(y, s)| y * s * world.gain[slope.joint]);
                    (first + at, values.collect())
                };
                jacobian[slope.joint].extend(stretch.shaped_with(read.map(through)));
            }
        });
    }
}

fn reads_own_torque(term: &Term) -> bool {
    term.effect.reads_torques() && term.joints.len() == 1 && term.coefficients.iter().any(|c| *c != 0.0)
}

/// Slopes of one term by both torques, those that are zero left out. Differences are taken over a millionth of the largest
/// torque, which is far above its rounding and far below the curvature of any effect.
fn slopes(term: &Term, scene: &Scene) -> Vec<Slope> {
    let joint = term.joints[0];
    let largest = scene.declared[joint].iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let step = 1e-6 * largest.max(1e-6);
    let by = |rigid: bool| {
        let (up, down) = (torque(term, scene, rigid, step), torque(term, scene, rigid, -step));
        Slope {
            joint,
            rigid,
            values: up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * step)).collect(),
        }
    };
    let both = [true, false].map(by).into_iter();
    both.filter(|s| s.values.iter().any(|v| *v != 0.0)).collect()
}

/// Torque of a term on its joint, where the rigid (or declared) torque of the joint is another by so much.
fn torque(term: &Term, scene: &Scene, rigid: bool, by: f64) -> Vec<f64> {
    let joint = term.joints[0];
    let mut moved = if rigid { scene.rigid } else { scene.declared }.to_vec();
    moved[joint].iter_mut().for_each(|v| *v += by);
    let there = match rigid {
        true => Scene { rigid: &moved, ..*scene },
        false => Scene {
            declared: &moved,
            ..*scene
        },
    };
    let columns = term.effect.columns(term.form, &there, &term.joints, &term.shape);
    summed(columns, &term.coefficients).remove(&joint).unwrap_or_default()
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

    /// Saturation reads the declared torque of its joint, load-dependent friction the size of the rigid one.
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
            term("torque_saturation", &[0], 0.002),
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
                for s in 0..200 {
                    let own: f64 = columns.iter().filter(|c| c.0 == at).map(|c| c.1[s]).sum();
                    let difference = (up[j][s] - down[j][s]) / 2e-5;
                    assert!(
                        (own - difference).abs() < 1e-8 * (1.0 + difference.abs()),
                        "parameter {at} joint {j} sample {s}: {own} {difference}"
                    );
                }
            }
        }
    }
}
