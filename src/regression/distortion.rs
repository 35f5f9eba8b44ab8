//! Effects that distort motion, gravity or gains: the world as the model sees it, and how the torque changes with them.

use super::dataset::Stretch;
use super::declared_torque::Torques;
use super::jacobian::ShapedRows;
use super::model::{AugmentedModel, Term};
use crate::dynamics::{Coulomb, Motion};
use crate::effects::{Scene, World};
use crate::regression::settings::SETTINGS;
use nalgebra::Vector3;
use rayon::prelude::*;

/// A motion, gravity, and the declared torque that goes with them.
pub(crate) type KnownTorque<'a> = (&'a Motion, Vector3<f64>, &'a [Vec<f64>]);

impl AugmentedModel {
    pub(crate) fn push_distortions(&self, jacobian: &mut ShapedRows, stretch: &Stretch, plain: &Torques, known: KnownTorque) {
        let distortions: Vec<usize> = (0..self.terms.len()).filter(|&t| self.terms[t].is_distortion()).collect();
        let of = |&t: &usize| {
            let columns = self.distortion_columns(stretch, plain, &self.terms[t], Some(t), known);
            columns.into_par_iter().map(|rows| stretch.shaped(rows)).collect::<Vec<_>>()
        };
        let columns: Vec<_> = distortions.par_iter().map(of).collect();
        for (t, columns) in distortions.into_iter().zip(columns) {
            for (at, shaped) in columns.into_iter().enumerate().map(|(i, c)| (self.offset_of(t) + i, c)) {
                shaped.into_iter().enumerate().for_each(|(j, v)| jacobian[j].push((at, v)));
            }
        }
    }

    /// Derivative of the declared torque by every parameter of a distortion, n × N each, by central differences around its
    /// present value (zero for a distortion that is not in the model). Where the motion and gravity are those of `known`, so is
    /// the torque.
    pub(crate) fn distortion_columns(
        &self,
        stretch: &Stretch,
        plain: &Torques,
        term: &Term,
        at: Option<usize>,
        known: KnownTorque,
    ) -> Vec<Vec<Vec<f64>>> {
        // Without a filter, rows at a reversal are left out.
        let least = stretch
            .filter
            .as_ref()
            .map_or(0.0, |_| term.effect.least_step(stretch.interval));
        let steps: Vec<f64> = term.effect.steps().iter().map(|step| step.max(least)).collect();
        (0..steps.len())
            .into_par_iter()
            .map(|i| {
                let side = |sign: f64| {
                    let mut moved = term.clone();
                    moved.shape[i] += sign * steps[i];
                    let world = self.world_beside(stretch, plain, (at, &moved), known.0);
                    let mut tau = match (&world.motion, world.gravity) == (known.0, known.1) {
                        true => known.2.to_vec(),
                        false => {
                            self.torques(&world.motion, &self.robot.with_gravity(world.gravity), None)
                                .declared
                        }
                    };
                    tau.iter_mut()
                        .zip(&world.gain)
                        .for_each(|(row, g)| row.iter_mut().for_each(|v| *v *= g));
                    tau
                };
                let (up, down) = rayon::join(|| side(1.0), || side(-1.0));
                let difference =
                    |(u, d): (&Vec<f64>, &Vec<f64>)| u.iter().zip(d).map(|(u, d)| (u - d) / (2.0 * steps[i])).collect();
                up.iter().zip(&down).map(difference).collect()
            })
            .collect()
    }

    /// All distortions applied in turn; `changed` stands in for the term at that place, or comes on top. Where one depends on the
    /// load, the load is that of the distorted motion: an elastic joint bends by a few per cent of what its own bending changes,
    /// so that `load_rounds` are enough.
    ///
    /// Distortions that depend on the load come last, whatever the order of the terms: the late torque of an elastic arm is that
    /// of the earlier motion and of its load. Bending first would have a delay interpolate between bent states, whose velocities
    /// and accelerations are smoothed and do not belong to their positions: the difference would come back divided by the square
    /// of the sampling interval.
    pub(crate) fn world(&self, stretch: &Stretch, plain: &Torques, changed: Option<(Option<usize>, &Term)>) -> World {
        let list = self.distortions(changed);
        let mut world = self.distorted(stretch, plain, &list, &stretch.motion);
        // Around zero the derivative is that of the undistorted load.
        let bends =
            |t: &&&Term| t.effect.distorts_by_load() && t.shape.iter().zip(t.effect.steps()).any(|(v, h)| v.abs() > 1.5 * h);
        if list.iter().any(|t| bends(&t)) {
            for _ in 0..SETTINGS.load_rounds {
                let there = self.torques(&world.motion, &self.robot.with_gravity(world.gravity), None);
                world = self.distorted(stretch, &there, &list, &stretch.motion);
            }
        }
        world
    }

    /// The world with `changed`; `motion` is that of the model's world, which a change that keeps it need not bend again. Of a
    /// candidate beside the model, it is the measured one.
    fn world_beside(&self, stretch: &Stretch, plain: &Torques, changed: (Option<usize>, &Term), motion: &Motion) -> World {
        let mut list = self.distortions(Some(changed));
        let bends = |t: &&Term| !t.effect.keeps_motion() && (changed.0.is_none() || t.effect.distorts_by_load());
        if !changed.1.effect.keeps_motion() || list.iter().any(bends) {
            return self.world(stretch, plain, Some(changed));
        }
        list.retain(|t| t.effect.keeps_motion());
        self.distorted(stretch, plain, &list, motion)
    }

    /// The distortions with `changed`, those that depend on the load last.
    fn distortions<'a>(&'a self, changed: Option<(Option<usize>, &'a Term)>) -> Vec<&'a Term> {
        let mut list: Vec<&Term> = Vec::new();
        for (t, own) in self.terms.iter().enumerate().filter(|(_, t)| t.is_distortion()) {
            list.push(match changed {
                Some((Some(at), other)) if at == t => other,
                _ => own,
            });
        }
        if let Some((None, term)) = changed {
            list.push(term);
        }
        list.sort_by_key(|t| t.effect.distorts_by_load());
        list
    }

    /// The world that the distortions of a list make in turn, from `motion`, by the torques of the motion before.
    fn distorted(&self, stretch: &Stretch, before: &Torques, list: &[&Term], motion: &Motion) -> World {
        let mut world = World {
            motion: motion.clone(),
            gravity: self.robot.gravity(),
            gain: vec![1.0; self.robot.joint_count()],
        };
        let scene = Scene {
            robot: &self.robot,
            motion: &stretch.motion,
            rigid: &before.rigid,
            declared: &before.declared,
            interval: stretch.interval,
            periodic: stretch.periodic,
            coulomb: Coulomb::Sign,
        };
        for term in list {
            term.effect.distort(&scene, &term.joints, &term.shape, &mut world);
        }
        world
    }
}
