//! How well an effect can be seen at all: the size of what it adds beside the noise, after the base parameters have hidden what
//! they can.

use crate::bench::*;
use dynident::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use dynident::model::Robot;
use dynident::parameters::{BaseParameters, Layout};
use dynident::simulate::{Experiment, Noise, simulate};
use dynident::trajectory::Trajectory;
use nalgebra::{DMatrix, DVector};

/// One motion of the published arm, and what its base parameters can hide there.
pub struct Sight<'a> {
    robot: &'a Robot,
    phi: &'a [f64],
    seed: u64,
    noise: Vec<f64>,
    /// Orthonormal columns over the rows of all joints, one joint after the other, in units of their noise.
    hidden: DMatrix<f64>,
}

const PERIODS: usize = 6;

impl<'a> Sight<'a> {
    pub fn new(robot: &'a Robot, phi: &'a [f64], seed: u64) -> Self {
        let noise = noise_levels(robot.joint_count());
        let excitation = wide_excitation(robot, seed);
        let samples = (excitation.duration() * RATE) as usize;
        let motion = Motion::from_fn(robot.joint_count(), samples, |j, s| excitation.state(j, s as f64 / RATE));
        let base = BaseParameters::exact(robot);
        let set = ColumnSet::new(robot, &Layout::standard(robot), &base.kept);
        let mut rows = RowBlocks::new(&set, samples);
        rows.fill(&Chain::new(robot), &set, &motion, Coulomb::Sign);
        let mut w = DMatrix::zeros(samples * robot.joint_count(), set.len());
        for j in 0..robot.joint_count() {
            for (values, &at) in rows.block(j).chunks_exact(rows.stride()).zip(set.row(j)) {
                (0..samples).for_each(|s| w[(j * samples + s, at)] = values[s] / noise[j]);
            }
        }
        Self {
            robot,
            phi,
            seed,
            noise,
            hidden: w.qr().q(),
        }
    }

    /// Root of the sum of squares that the effect adds beyond the reach of the base parameters, in units of the noise: the mean
    /// over the periods and what they do apart from it.
    pub fn at(&self, hidden: &Hidden, size: f64) -> f64 {
        let (n, quiet) = (self.robot.joint_count(), Noise::white(vec![0.0; self.robot.joint_count()]));
        let excitation = wide_excitation(self.robot, self.seed);
        let run = |effects: &[_]| {
            simulate(&Experiment {
                robot: self.robot,
                parameters: self.phi,
                trajectory: &excitation,
                periods: PERIODS as f64,
                rate_hz: RATE,
                effects,
                noise: &quiet,
                seed: 0,
            })
            .tau
        };
        let (with, without) = (run(&[hidden.at(size)]), run(&[]));
        let samples = with[0].len() / PERIODS;
        let value = |j: usize, s: usize| (with[j][s] - without[j][s]) / self.noise[j];
        let mean = |j: usize, s: usize| (0..PERIODS).map(|p| value(j, p * samples + s)).sum::<f64>() / PERIODS as f64;
        let average = DVector::from_fn(n * samples, |i, _| mean(i / samples, i % samples));
        let apart: f64 = (0..n)
            .flat_map(|j| (0..PERIODS * samples).map(move |s| (j, s)))
            .map(|(j, s)| (value(j, s) - average[j * samples + s % samples]).powi(2))
            .sum();
        let free = &average - &self.hidden * self.hidden.tr_mul(&average);
        (PERIODS as f64 * free.norm_squared() + apart).sqrt()
    }

    /// The size at which it adds `wanted`, or the largest sensible one. What is added goes nearly with the size.
    pub fn size_for(&self, hidden: &Hidden, wanted: f64) -> f64 {
        let mut size = 1.0;
        for _ in 0..3 {
            size = (size * wanted / self.at(hidden, size).max(1e-9)).min(hidden.largest());
        }
        size
    }
}
