//! Masses are positive and lie along the arm: which of two opposite directions has them so.

use super::form::Form;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, Coulomb, Motion, forward_kinematics, inverse_dynamics_batch};
use crate::model::Robot;
use crate::parameters::{Inertial, Layout, ParameterKind};
use nalgebra::{DVector, Vector3};

/// Bodies to hold a fitted gravity against.
pub(crate) struct Bodies<'a> {
    robot: &'a Robot,
    layout: Layout,
    /// Standard parameters: those declared, or unit masses half-way between the joints.
    expected: DVector<f64>,
    motion: Motion,
}

impl<'a> Bodies<'a> {
    pub fn new(robot: &'a Robot, logs: &[(&Motion, &[Vec<f64>])]) -> Self {
        let layout = Layout::standard(robot);
        let all: usize = logs.iter().map(|(m, _)| m.samples()).sum();
        let step = (all / SETTINGS.mounting.postures).max(1);
        let at: Vec<(usize, usize)> = logs
            .iter()
            .enumerate()
            .flat_map(|(i, (m, _))| (0..m.samples()).step_by(step).map(move |s| (i, s)))
            .collect();
        Self {
            robot,
            expected: layout.prior(robot).unwrap_or_else(|| half_way(robot, &layout)),
            layout,
            motion: Motion::from_fn(robot.joint_count(), at.len(), |j, k| logs[at[k].0].0.get(j, at[k].1)),
        }
    }

    /// −1 … 1: the cosine between the gravity torques of the fitted and of the expected bodies under this direction, turned round
    /// where the fit has friction that drives and inertia below zero (all torques have the opposite sign then).
    pub fn vote(&self, form: &Form, direction: Vector3<f64>, signs: &[f64]) -> f64 {
        let values = form.values(direction, signs);
        let mut phi = vec![0.0; self.layout.len()];
        for (&at, &v) in form.kept.iter().zip(values.iter()) {
            if matches!(self.layout.parameters()[at].kind, ParameterKind::Inertial(_)) {
                phi[at] = v;
            }
        }
        let turned = self.robot.with_gravity(direction * self.robot.gravity().norm());
        let cosine = cosine(
            &self.at_rest(&turned, &phi),
            &self.at_rest(&turned, self.expected.as_slice()),
            &self.motion,
            &form.weight,
        );
        cosine * self.sense(form, &phi, &values)
    }

    /// Torques of gravity alone.
    fn at_rest(&self, robot: &Robot, phi: &[f64]) -> Vec<f64> {
        let still = Motion::from_fn(robot.joint_count(), self.motion.samples(), |j, s| {
            [self.motion.get(j, s)[0], 0.0, 0.0]
        });
        let mut frictionless = phi.to_vec();
        for (at, parameter) in self.layout.parameters().iter().enumerate() {
            if !matches!(parameter.kind, ParameterKind::Inertial(_)) {
                frictionless[at] = 0.0;
            }
        }
        inverse_dynamics_batch(&Chain::new(robot), &self.layout, &frictionless, &still, Coulomb::Sign)
    }

    /// +1, or −1 where friction drives and kinetic energy is below zero.
    fn sense(&self, form: &Form, phi: &[f64], values: &DVector<f64>) -> f64 {
        let n = self.robot.joint_count();
        let momentum = {
            let moved = Motion::from_fn(n, self.motion.samples(), |j, s| {
                let [q, qd, _] = self.motion.get(j, s);
                [q, 0.0, qd]
            });
            let weightless = self.robot.with_gravity(Vector3::zeros());
            inverse_dynamics_batch(&Chain::new(&weightless), &self.layout, phi, &moved, Coulomb::Sign)
        };
        let (mut energy, mut friction) = ((0.0, 0.0), (0.0, 0.0));
        let add = |to: &mut (f64, f64), v: f64| *to = (to.0 + v, to.1 + v.abs());
        for s in 0..self.motion.samples() {
            let own = |j: usize| form.own(values, &self.layout, j);
            let speed = |j: usize| self.motion.get(j, s)[1];
            let carried = |j: usize| (momentum[j * self.motion.stride() + s] + own(j)[0] * speed(j)) * speed(j);
            add(&mut energy, (0..n).map(carried).sum());
            let lost = |j: usize| own(j)[1] * speed(j).powi(2) + own(j)[2] * speed(j).abs();
            (0..n).for_each(|j| add(&mut friction, lost(j)));
        }
        let share = |(sum, size): (f64, f64)| if size > 0.0 { sum / size } else { 0.0 };
        if share(energy) + share(friction) < -0.5 { -1.0 } else { 1.0 }
    }
}

/// Unit masses half-way between a joint and the next; that of the last link in its joint.
fn half_way(robot: &Robot, layout: &Layout) -> DVector<f64> {
    let mut phi = DVector::zeros(layout.len());
    let n = robot.joint_count();
    let poses = forward_kinematics(robot, &vec![0.0; n]);
    for link in 0..n {
        phi[layout.inertial(link, Inertial::M)] = 1.0;
        let Some(next) = poses.get(link + 1) else { continue };
        let centre = poses[link].rotation.transpose() * (next.translation - poses[link].translation) * 0.5;
        for (which, value) in [Inertial::MX, Inertial::MY, Inertial::MZ].into_iter().zip(centre.iter()) {
            phi[layout.inertial(link, which)] = *value;
        }
    }
    phi
}

/// Of the torques `a` and `b` along `motion`, every joint weighed.
fn cosine(a: &[f64], b: &[f64], motion: &Motion, weight: &[f64]) -> f64 {
    let mut sums = [0.0; 3];
    for (j, w) in weight.iter().enumerate() {
        for s in 0..motion.samples() {
            let at = j * motion.stride() + s;
            let (x, y) = (a[at] * w, b[at] * w);
            [x * y, x * x, y * y].iter().zip(&mut sums).for_each(|(v, s)| *s += v);
        }
    }
    let size = (sums[1] * sums[2]).sqrt();
    if size > 0.0 { sums[0] / size } else { 0.0 }
}
