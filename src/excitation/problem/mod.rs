//! What is asked: a robot, a Fourier series, a criterion, constraints.

mod checks;
mod information;
mod rest;
mod spec;

pub use spec::{Criterion, Form, Given, Knowledge, ProblemSpec, Start};

use self::checks::{
    harmonic_problems, knowledge_problems, limit_problems, noise_problems, series_problems, size_problem, start_position,
};
use super::path::TorqueSet;
use super::space::SpaceSet;
use crate::dynamics::Chain;
use crate::model::{ModelError, Robot};
use crate::parameters::{BaseParameters, Layout};
use crate::trajectory::sample_count;
use nalgebra::DMatrix;

/// A checked problem with all that follows from it.
#[derive(Debug, Clone)]
pub struct Problem {
    spec: ProblemSpec,
    start_position: Vec<f64>,
    layout: Layout,
    base: BaseParameters,
    chain: Chain,
    samples: usize,
    torque: Option<TorqueSet>,
    space: Option<SpaceSet>,
    /// Where a motion with free start scales from, if the middle of the ranges is not allowed.
    elsewhere: Option<Vec<f64>>,
    /// Sum of all that is given, over all columns.
    given: Option<DMatrix<f64>>,
}

impl Problem {
    /// # Errors
    /// Every field that is wrong, as pointers into the excitation document, with the remedy.
    pub fn new(spec: ProblemSpec) -> Result<Self, ModelError> {
        let mut found = Vec::new();
        series_problems(&spec, &mut found);
        harmonic_problems(&spec, &mut found);
        limit_problems(&spec, &mut found);
        let start_position = start_position(&spec, &mut found);
        noise_problems(&spec, &mut found);
        let layout = Layout::standard(&spec.robot);
        let base = BaseParameters::exact(&spec.robot);
        let torque = TorqueSet::new(&spec, &layout, &base, &mut found);
        let space = SpaceSet::new(&spec, &mut found);
        if !found.is_empty() {
            return Err(ModelError(found));
        }
        let chain = Chain::new(&spec.robot);
        let samples = sample_count(1.0 / spec.fundamental_hz, spec.sample_rate_hz);
        let all = base.len() + spec.knowledge.added.as_ref().map_or(0, |a| a.0.count());
        size_problem(samples, spec.robot.joint_count(), all, spec.order)?;
        knowledge_problems(&spec, all)?;
        let mut problem = Self {
            spec,
            start_position,
            layout,
            base,
            chain,
            samples,
            torque,
            space,
            elsewhere: None,
            given: None,
        };
        problem.elsewhere = problem.another_rest();
        problem.given = problem.sum_of_given();
        problem.look_for_nesting();
        Ok(problem)
    }

    /// The robot that moves.
    pub fn robot(&self) -> &Robot {
        &self.spec.robot
    }

    /// What was asked for.
    pub fn spec(&self) -> &ProblemSpec {
        &self.spec
    }

    /// Standard parameters of the robot, in order.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Base parameters of the robot.
    pub fn base(&self) -> &BaseParameters {
        &self.base
    }

    /// The robot's chain for dynamics.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Columns of all that is estimated: base parameters, then parameters of effects.
    pub fn columns(&self) -> usize {
        self.base.len() + self.spec.knowledge.added.as_ref().map_or(0, |a| a.0.count())
    }

    /// The harmonics of a joint, ascending.
    pub(super) fn harmonics_of(&self, joint: usize) -> Vec<usize> {
        let all = || (1..=self.spec.order).collect();
        self.spec.harmonics.as_ref().map_or_else(all, |h| h[joint].clone())
    }

    /// Whether any limit binds the joints together along the path.
    pub(super) fn has_path_limits(&self) -> bool {
        self.torque.is_some() || self.space.is_some()
    }

    pub(super) fn space(&self) -> Option<&SpaceSet> {
        self.space.as_ref()
    }

    /// Torque limits with the model that predicts torques.
    pub(super) fn torque(&self) -> Option<&TorqueSet> {
        self.torque.as_ref()
    }

    /// Standard deviation of the torque noise of every joint, as asked or one unit.
    pub fn torque_noise(&self) -> Vec<f64> {
        self.spec
            .torque_noise
            .clone()
            .unwrap_or_else(|| vec![1.0; self.spec.robot.joint_count()])
    }

    /// Samples in one period.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Position at the start [rad or m], one per joint.
    pub fn start_position(&self) -> &[f64] {
        &self.start_position
    }
}
