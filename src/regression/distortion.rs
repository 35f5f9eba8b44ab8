//! Effects that distort motion, gravity or gains: the world as the model sees it, and how the torque changes with them.

use super::dataset::{ShapedRows, Stretch};
use super::declared_torque::Torques;
use super::model::{AugmentedModel, Term};
use super::present::KnownTorque;
use crate::dynamics::{Coulomb, Motion};
use crate::effects::{Scene, World};
use crate::regression::settings::SETTINGS;
use rayon::prelude::*;
use std::borrow::Cow;

impl AugmentedModel {
    pub(crate) fn push_distortions(&self, jacobian: &mut ShapedRows, stretch: &Stretch, plain: &Torques, known: KnownTorque) {
        let distortions: Vec<usize> = (0..self.terms.len()).filter(|&t| self.terms[t].is_distortion()).collect();
        let of = |&t: &usize| {
            let columns = self.distortion_columns(stretch, plain, &self.terms[t], Some(t), Some(known));
            columns.into_par_iter().map(|rows| stretch.shaped(rows)).collect::<Vec<_>>()
        };
        let columns: Vec<_> = distortions.par_iter().map(of).collect();
        for (t, columns) in distortions.into_iter().zip(columns) {
            for (at, shaped) in columns.into_iter().enumerate().map(|(i, c)| (self.offset_of(t) + i, c)) {
                shaped.into_iter().enumerate().for_each(|(j, v)| jacobian[j].push((at, v)));
            }
        }
    }

    /// Derivative of the declared torque by every parameter of a distortion, n × N each, by differences from its present value
    /// (zero for a distortion that is not in the model). `known` is the model's world with the distortion at that value; where
    /// motion and gravity are the same in another, so is the torque.
    pub(crate) fn distortion_columns(
        &self,
        stretch: &Stretch,
        plain: &Torques,
        term: &Term,
        at: Option<usize>,
        known: Option<KnownTorque>,
    ) -> Vec<Vec<Vec<f64>>> {
        // Without a filter, rows at a reversal are left out.
        let least = stretch
            .filter
            .as_ref()
            .map_or(0.0, |_| term.effect.least_step(stretch.interval));
        let steps: Vec<f64> = term.effect.steps().iter().map(|step| step.max(least)).collect();
        let torque = |term: &Term| {
            let world = self.world_beside(stretch, plain, (at, term), known.map(|k| &k.world.motion));
            let same = known.filter(|k| (world.motions(), world.gravity) == (k.world.motions(), k.world.gravity));
            let declared = match same {
                Some(known) => Cow::Borrowed(known.declared),
                None => {
                    let robot = self.robot.with_gravity(world.gravity);
                    Cow::Owned(self.torques(world.motions(), &robot, None).declared)
                }
            };
            gained(&declared, &world.gain)
        };
        let moved = |i: usize, by: f64| {
            let mut moved = term.clone();
            moved.shape[i] += by;
            torque(&moved)
        };
        let present = || known.map_or_else(|| torque(term), |k| gained(k.declared, &k.world.gain));
        // Of a smooth distortion, half of the differences are spared.
        let here = (!term.effect.is_differenced_both_ways()).then(present);
        (0..steps.len())
            .into_par_iter()
            .map(|i| match &here {
                Some(here) => quotient(&moved(i, steps[i]), here, steps[i]),
                None => {
                    let (up, down) = rayon::join(|| moved(i, steps[i]), || moved(i, -steps[i]));
                    quotient(&up, &down, 2.0 * steps[i])
                }
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
                let there = self.torques(world.motions(), &self.robot.with_gravity(world.gravity), None);
                world = self.distorted(stretch, &there, &list, &stretch.motion);
            }
        }
        world
    }

    /// The world with `changed`; `motion` is that of the model's world, where it is known: a change that keeps it need not bend
    /// it again, unless the load bends it.
    fn world_beside(
        &self,
        stretch: &Stretch,
        plain: &Torques,
        changed: (Option<usize>, &Term),
        motion: Option<&Motion>,
    ) -> World {
        let mut list = self.distortions(Some(changed));
        let by_load = list.iter().any(|t| t.effect.distorts_by_load());
        match motion.filter(|_| changed.1.effect.keeps_motion() && !by_load) {
            None => self.world(stretch, plain, Some(changed)),
            Some(motion) => {
                list.retain(|t| t.effect.keeps_motion());
                self.distorted(stretch, plain, &list, motion)
            }
        }
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
        let mut world = World::measured(motion, &self.robot);
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

/// Torques times the gain of every joint.
fn gained(torque: &[Vec<f64>], gain: &[f64]) -> Vec<Vec<f64>> {
    let row = |(row, g): (&Vec<f64>, &f64)| row.iter().map(|v| v * g).collect();
    torque.iter().zip(gain).map(row).collect()
}

/// `(up − down)/step`, joint by joint.
fn quotient(up: &[Vec<f64>], down: &[Vec<f64>], step: f64) -> Vec<Vec<f64>> {
    let row = |(u, d): (&Vec<f64>, &Vec<f64>)| u.iter().zip(d).map(|(u, d)| (u - d) / step).collect();
    up.iter().zip(down).map(row).collect()
}
