//! What is asked: a robot, a Fourier series, a criterion, constraints.

use super::added::{Added, Course};
use super::moves::{random_numbers, random_start};
use super::path::{TorqueLimits, TorqueSet};
use super::postures::Postures;
use super::rivals::Rivals;
use super::space::{SpaceLimits, SpaceSet};
use super::variables::Variables;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks, inverse_dynamics_batch};
use crate::model::{FieldProblem, ModelError, Robot};
use crate::parameters::{BaseParameters, Layout};
use crate::trajectory::{FourierSeries, Trajectory, sample_count};
use nalgebra::DMatrix;

/// What makes one trajectory better than another; all are functions of the Gram matrix `M = Y_bᵀ Y_b`, the columns of effects beside those of
/// `Y_b` where there are any, and are minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// `cond(Y_b) = sqrt(λ_max / λ_min)`, the paper's (13).
    ConditionNumber,
    /// The condition number after scaling every column of Y_b to length one: does not depend on units.
    ScaledConditionNumber,
    /// `det(M)^(−1/(2b))`: the geometric mean of the standard deviations along the principal directions.
    DOptimality,
    /// `sqrt(tr(M⁻¹)/b)`: the root-mean-square standard deviation of the base parameters.
    AOptimality,
    /// `sqrt(tr(M⁻¹ C)/n)`, C the mean of `Y_bᵀ Y_b` over random states inside the limits: the expected torque-prediction error.
    IOptimality,
    /// One over the root of the expected evidence between two explanations of a residual ([`super::Rivals`]), in the worse of the two cases.
    RivalEvidence,
}

impl Criterion {
    /// Whether it is a ratio of singular values, which has kinks where they meet.
    pub fn is_condition_number(self) -> bool {
        matches!(self, Self::ConditionNumber | Self::ScaledConditionNumber)
    }
}

/// How limits on the series become constraints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// (14d)–(14g): triangle-inequality bounds and boxes on the coefficients. Sufficient, not necessary.
    Paper,
    /// The true extremes over time, certified between the samples.
    Exact,
}

/// Where the motion starts; it starts and ends at rest without acceleration either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At the start position (14c).
    Zero,
    /// Anywhere: the robot moves there first. The mean position of every joint becomes a variable.
    Free,
}

/// What is known already, whose information is added to that of the new trajectory.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A trajectory that has been or will be recorded, so many periods of it, with the noise of the problem.
    Motion { series: FourierSeries, periods: f64 },
    /// `WᵀW` over all columns, rows over their noise.
    Information(DMatrix<f64>),
}

/// What the information matrix holds beside one period of `Y_b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Knowledge {
    /// Columns of effects beside the regressor's.
    pub added: Option<Added>,
    /// Two of the effects, for [`Criterion::RivalEvidence`].
    pub rivals: Option<Rivals>,
    pub given: Vec<Given>,
    /// Periods of the new trajectory that will be recorded.
    pub periods: f64,
}

impl Default for Knowledge {
    fn default() -> Self {
        Self {
            added: None,
            rivals: None,
            given: Vec::new(),
            periods: 1.0,
        }
    }
}

/// A request as it was made; [`Problem::new`] checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemSpec {
    pub robot: Robot,
    pub order: usize,
    /// Harmonics that every joint has, from 1 to `order`; for `None` all of them.
    pub harmonics: Option<Vec<Vec<usize>>>,
    pub fundamental_hz: f64,
    pub sample_rate_hz: f64,
    pub criterion: Criterion,
    pub form: Form,
    pub start: Start,
    /// Position of every joint at the start [rad or m]; for `None` zero where the limits allow it, else the middle of the range.
    pub start_position: Option<Vec<f64>>,
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies and the optimality criteria; for
    /// `None` one unit on every joint.
    pub torque_noise: Option<Vec<f64>>,
    /// Limits on the torques that the robot's prior parameters predict.
    pub torque: Option<TorqueLimits>,
    /// What the arm keeps off.
    pub space: Option<SpaceLimits>,
    pub knowledge: Knowledge,
}

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

/// More harmonics than any controller's bandwidth carries; keeps accidental requests from asking for hours.
const HIGHEST_ORDER: usize = 50;
/// Numbers in the observation matrix: beyond this one evaluation takes so long that a search learns nothing and cannot stop within a
/// second. The iiwa 14 has room for 12,500 samples, a period of 10 s at more than 1 kHz.
const LARGEST_MATRIX: usize = 5_000_000;

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
        size_problem(samples, spec.robot.joint_count(), all)?;
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

    /// Columns of all that is estimated: base parameters, then parameters of effects.
    pub fn columns(&self) -> usize {
        self.base.len() + self.spec.knowledge.added.as_ref().map_or(0, |a| a.0.count())
    }

    /// What the search adds to the information of a motion; `None` where nothing is.
    ///
    /// Between rivals it is what is known of all other parameters: else the best motion could be one that tells them apart only beside the data so
    /// far, and whatever changed between the two recordings would pass for one of them.
    pub(super) fn known_before(&self) -> Option<DMatrix<f64>> {
        match self.spec.criterion {
            Criterion::RivalEvidence => self.given.is_some().then(|| self.given_of_others()),
            _ => self.given.clone(),
        }
    }

    /// What is given with the two rivals taken out by their Schur complement; zero where nothing is given.
    pub(super) fn given_of_others(&self) -> DMatrix<f64> {
        let size = self.columns();
        let mut left = DMatrix::zeros(size, size);
        let (Some(given), Some(rivals)) = (&self.given, &self.spec.knowledge.rivals) else {
            return left;
        };
        let base = self.base.len();
        let of_rivals = |c: &usize| {
            *c >= base && (rivals.finding.columns.contains(&(c - base)) || rivals.rival.columns.contains(&(c - base)))
        };
        let (two, others): (Vec<usize>, Vec<usize>) = (0..size).partition(of_rivals);
        let part = |rows: &[usize], columns: &[usize]| given.select_rows(rows).select_columns(columns);
        let cross = part(&others, &two);
        let inverse = pseudo_inverse(&part(&two, &two));
        let rest = part(&others, &others) - &cross * inverse * cross.transpose();
        for (r, &row) in others.iter().enumerate() {
            others
                .iter()
                .enumerate()
                .for_each(|(c, &column)| left[(row, column)] = rest[(r, c)]);
        }
        left
    }

    /// `WᵀW` of all that is known already; `None` where nothing is.
    pub(super) fn given(&self) -> Option<&DMatrix<f64>> {
        self.given.as_ref()
    }

    /// Whether one rival is a special case of the other: nothing of it is left over on any motion, two random ones for example.
    fn look_for_nesting(&mut self) {
        let Some(rivals) = &self.spec.knowledge.rivals else { return };
        let variables = Variables::new(self);
        let series = (0..2).map(|index| variables.series(&random_start(&variables, &mut random_numbers(0, 0, index))));
        let grams: Vec<DMatrix<f64>> = series.map(|s| self.information_of(&s)).collect();
        let nested = rivals.nested_on(&grams, self.base.len());
        if let Some(rivals) = &mut self.spec.knowledge.rivals {
            rivals.nested = nested;
        }
    }

    fn sum_of_given(&self) -> Option<DMatrix<f64>> {
        let information = |given: &Given| match given {
            Given::Motion { series, periods } => self.information_of(series) * *periods,
            Given::Information(matrix) => matrix.clone(),
        };
        self.spec.knowledge.given.iter().map(information).reduce(|a, b| a + b)
    }

    /// `[Y_b, C]` of one period on the asked samples, with the true sign; rows go joint by joint within a sample.
    pub(super) fn observation_matrix(&self, series: &FourierSeries) -> DMatrix<f64> {
        self.rows_along(&series.sample(self.spec.sample_rate_hz), 1.0 / self.spec.sample_rate_hz, true)
    }

    /// The same along any motion.
    pub(super) fn rows_along(&self, motion: &Motion, interval: f64, periodic: bool) -> DMatrix<f64> {
        let columns = ColumnSet::new(&self.spec.robot, &self.layout, &self.base.kept);
        let mut rows = RowBlocks::new(&columns, motion.samples());
        rows.fill(&self.chain, &columns, motion, Coulomb::Sign);
        let y_b = rows.observation_matrix(&columns);
        let Some(added) = &self.spec.knowledge.added else { return y_b };
        let course = Course {
            motion,
            interval,
            periodic,
            coulomb: Coulomb::Sign,
        };
        let beside = added.observation_matrix(&course);
        let mut all = y_b.resize_horizontally(self.columns(), 0.0);
        all.columns_mut(self.base.len(), beside.ncols()).copy_from(&beside);
        all
    }

    /// `WᵀW` of one period of a series, every row over the noise of its joint.
    pub(super) fn information_of(&self, series: &FourierSeries) -> DMatrix<f64> {
        let noise = self.torque_noise();
        let mut rows = self.observation_matrix(series);
        for (r, mut row) in rows.row_iter_mut().enumerate() {
            row /= noise[r % noise.len()];
        }
        rows.tr_mul(&rows)
    }

    /// The harmonics of a joint, ascending.
    pub(super) fn harmonics_of(&self, joint: usize) -> Vec<usize> {
        let all = || (1..=self.spec.order).collect();
        self.spec.harmonics.as_ref().map_or_else(all, |h| h[joint].clone())
    }

    pub fn robot(&self) -> &Robot {
        &self.spec.robot
    }

    pub fn spec(&self) -> &ProblemSpec {
        &self.spec
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn base(&self) -> &BaseParameters {
        &self.base
    }

    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Why no motion at all is possible, if so: a joint that starts on its limit would have to leave it.
    pub fn no_room(&self) -> Option<String> {
        let joints = self.spec.robot.joints().iter().enumerate();
        let mut stuck = joints.filter(|(j, joint)| {
            let rest = self.rest_position(*j);
            joint.limits.position.is_some_and(|[low, high]| rest <= low || rest >= high)
        });
        stuck.next().map(|(_, joint)| {
            format!(
                "joint `{}` starts on its position limit and has nowhere to go: choose another start_position, or start: free",
                joint.name
            )
        })
        .or_else(|| {
            let alike = self.spec.criterion == Criterion::RivalEvidence
                && self.spec.knowledge.rivals.as_ref().is_some_and(|r| r.nested == [true, true]);
            alike.then(|| "the two rivals make the same torques on any motion of this arm, once the other parameters are fitted: no motion tells them apart".into())
        })
        .or_else(|| {
            let reasons: Vec<String> = self.too_heavy_at_rest().into_iter().chain(self.too_near_at_rest()).collect();
            (!reasons.is_empty()).then(|| format!("{}; {}", reasons.join("; "), Postures::of(self).in_words(self)))
        })
    }

    /// For a free start whose middle of the ranges is not allowed: a posture that is, if there is one.
    fn another_rest(&self) -> Option<Vec<f64>> {
        let stuck = self.too_heavy_at_rest().is_some() || self.too_near_at_rest().is_some();
        let searched = self.spec.start == Start::Free && stuck;
        searched.then(|| Postures::of(self).best).flatten()
    }

    /// The first joint that exceeds its torque limit by holding the arm still, in words.
    fn too_heavy_at_rest(&self) -> Option<String> {
        let limits = self.torque.as_ref()?;
        let joints = self.spec.robot.joint_count();
        let prior = self.layout.prior(&self.spec.robot)?;
        // Just moving, one way and the other: friction is there as soon as anything moves.
        let still = Motion::from_fn(joints, 2, |j, s| [self.rest_position(j), [-1e-9, 1e-9][s], 0.0]);
        let torques = inverse_dynamics_batch(&self.chain, &self.layout, prior.as_slice(), &still, Coulomb::Sign);
        let at = |j: usize| torques[j * still.stride()].abs().max(torques[j * still.stride() + 1].abs());
        let joint = (0..joints).find(|&j| at(j) >= limits.allowed[j])?;
        Some(format!(
            "joint `{}` needs {:.4} to hold the arm where the motion starts and to begin to move, and constraints.torque allows {:.4} N m or N: choose another \
             start_position, a smaller safety_factor or larger limits",
            self.spec.robot.joints()[joint].name,
            at(joint),
            limits.allowed[joint]
        ))
    }

    /// The pair that is too near before anything has moved, in words.
    fn too_near_at_rest(&self) -> Option<String> {
        let set = self.space.as_ref()?;
        let (pair, distance) = set.nearest(self.robot(), &|j| self.rest_position(j))?;
        (distance <= set.clearance).then(|| {
            format!(
                "where the motion starts, the link of joint `{}` is {:.4} m from `{}`, and constraints.space asks for more than {} m: choose another \
                 start_position, a smaller clearance, or add the pair to self_collision.ignore if it always touches",
                self.robot().joints()[pair.link].name,
                distance,
                pair.name,
                set.clearance
            )
        })
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

    /// Where the coefficients of `joint` scale from: the start position, or the middle of the range when the start is free, or where limits along
    /// the path do not allow that another posture that they do.
    pub fn rest_position(&self, joint: usize) -> f64 {
        if let Some(rest) = &self.elsewhere {
            return rest[joint];
        }
        match (self.spec.start, self.spec.robot.joints()[joint].limits.position) {
            (Start::Free, Some([low, high])) => 0.5 * (low + high),
            _ => self.start_position[joint],
        }
    }

    /// Position at the start [rad or m], one per joint.
    pub fn start_position(&self) -> &[f64] {
        &self.start_position
    }
}

fn positive(pointer: &str, value: f64, unit: &str, found: &mut Vec<FieldProblem>) -> bool {
    let good = value.is_finite() && value > 0.0;
    if !good {
        found.push(FieldProblem::new(
            pointer,
            format!("is {value}; it must be a positive number of {unit}"),
        ));
    }
    good
}

fn series_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let fundamental = positive("/fourier/fundamental_hz", spec.fundamental_hz, "Hz", found);
    let rate = positive("/sample_rate_hz", spec.sample_rate_hz, "Hz", found);
    if spec.order < 2 {
        found.push(
            FieldProblem::new(
                "/fourier/order",
                format!("is {}: rest at the start leaves nothing free below order 2", spec.order),
            )
            .with_hint("use 5 as in the paper, at least 2"),
        );
    } else if spec.order > HIGHEST_ORDER {
        found.push(FieldProblem::new(
            "/fourier/order",
            format!("is {}, the highest accepted is {HIGHEST_ORDER}", spec.order),
        ));
    }
    if !(fundamental && rate) {
        return;
    }
    let samples = sample_count(1.0 / spec.fundamental_hz, spec.sample_rate_hz);
    if samples <= 2 * spec.order {
        found.push(
            FieldProblem::new(
                "/fourier/order",
                format!(
                    "{} harmonics need more than {} samples per period, there are {samples}",
                    spec.order,
                    2 * spec.order
                ),
            )
            .with_hint("raise sample_rate_hz, lower the order or the fundamental"),
        );
    }
}

/// Of a positive semidefinite matrix scaled to a unit diagonal; directions below 1e-10 of the largest are those in which rivals are the same.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)] * scale[r] * scale[c]);
    let eigen = scaled.symmetric_eigen();
    let least = 1e-10 * eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|v| if v > least { 1.0 / v } else { 0.0 });
    let mut out = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
    for r in 0..out.nrows() {
        (0..out.ncols()).for_each(|c| out[(r, c)] *= scale[r] * scale[c]);
    }
    out
}

fn harmonic_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let Some(lists) = &spec.harmonics else { return };
    let joints = spec.robot.joint_count();
    if lists.len() != joints {
        let detail = format!("has {} lists, the robot has {joints} joints", lists.len());
        found.push(FieldProblem::new("/fourier/harmonics", detail));
    }
    for (i, list) in lists.iter().enumerate() {
        let ascending = list.windows(2).all(|w| w[0] < w[1]);
        let inside = list.iter().all(|l| (1..=spec.order).contains(l));
        if list.len() < 2 || !ascending || !inside {
            let detail = format!(
                "is {list:?}; a joint has at least two harmonics between 1 and the order, {}, ascending",
                spec.order
            );
            let hint = "rest at the start binds two of them together: with one harmonic nothing would move";
            found.push(FieldProblem::new(format!("/fourier/harmonics/{i}"), detail).with_hint(hint));
        }
    }
}

/// What is known already has to fit the columns; whoever hands it in made it for them.
fn knowledge_problems(spec: &ProblemSpec, columns: usize) -> Result<(), ModelError> {
    let knowledge = &spec.knowledge;
    let joints = spec.robot.joint_count();
    let mut found = Vec::new();
    for (i, given) in knowledge.given.iter().enumerate() {
        let fits = match given {
            Given::Motion { series, .. } => series.offset.len() == joints,
            Given::Information(matrix) => matrix.shape() == (columns, columns),
        };
        if !fits {
            let detail = "is of another robot or model: its joints or parameters are not those of this problem";
            found.push(FieldProblem::new(format!("/given/{i}"), detail));
        }
    }
    if spec.criterion == Criterion::RivalEvidence && knowledge.rivals.is_none() {
        let detail = "is missing: rival_evidence needs the two effects to tell apart";
        let hint = "give `model`, and in `rivals` a finding of it and one of the finding's rivals";
        found.push(FieldProblem::new("/rivals", detail).with_hint(hint));
    }
    if !(knowledge.periods.is_finite() && knowledge.periods >= 1.0) {
        found.push(FieldProblem::new(
            "/periods",
            format!("is {}; at least one period is recorded", knowledge.periods),
        ));
    }
    if found.is_empty() { Ok(()) } else { Err(ModelError(found)) }
}

fn size_problem(samples: usize, joints: usize, parameters: usize) -> Result<(), ModelError> {
    let row_size = joints * parameters.max(1);
    if samples.saturating_mul(row_size) <= LARGEST_MATRIX {
        return Ok(());
    }
    let detail = format!(
        "gives {samples} samples per period, the most for this robot is {}",
        LARGEST_MATRIX / row_size
    );
    let hint = "some hundred samples per harmonic are enough: lower the rate, or raise the fundamental";
    Err(ModelError(vec![FieldProblem::new("/sample_rate_hz", detail).with_hint(hint)]))
}

fn limit_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    for (i, joint) in spec.robot.joints().iter().enumerate() {
        let l = &joint.limits;
        if l.velocity.is_none() && l.acceleration.is_none() && l.jerk.is_none() && l.position.is_none() {
            found.push(
                FieldProblem::new(
                    format!("/robot/joints/{i}/limits"),
                    format!("joint `{}` has no limit on its motion", joint.name),
                )
                .with_hint("give at least its velocity limit: without one the best trajectory is infinitely fast"),
            );
        }
    }
}

fn noise_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let Some(noise) = &spec.torque_noise else { return };
    let joints = spec.robot.joint_count();
    if noise.len() != joints {
        found.push(FieldProblem::new(
            "/torque_noise",
            format!("has {} values, the robot has {joints} joints", noise.len()),
        ));
    }
    for (i, &v) in noise.iter().enumerate() {
        positive(&format!("/torque_noise/{i}"), v, "N m or N", found);
    }
}

/// Zero, or the middle of the range where zero leaves less than a tenth of the range on one side.
fn default_start(limits: Option<[f64; 2]>) -> f64 {
    match limits {
        Some([low, high]) if low.max(-high) > -0.1 * (high - low) => 0.5 * (low + high),
        _ => 0.0,
    }
}

fn start_position(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) -> Vec<f64> {
    let joints = spec.robot.joints();
    let Some(given) = &spec.start_position else {
        return joints.iter().map(|j| default_start(j.limits.position)).collect();
    };
    if given.len() != joints.len() {
        let detail = format!("has {} values, the robot has {} joints", given.len(), joints.len());
        found.push(FieldProblem::new("/constraints/start_position", detail));
        return given.clone();
    }
    for (i, (joint, &q)) in joints.iter().zip(given).enumerate() {
        let pointer = format!("/constraints/start_position/{i}");
        if !q.is_finite() {
            found.push(FieldProblem::new(pointer, "is not finite"));
        } else if let Some([low, high]) = joint.limits.position
            && !(low <= q && q <= high)
        {
            let detail = format!(
                "is {q}, not inside the position limits [{low}, {high}] of joint `{}`",
                joint.name
            );
            found.push(FieldProblem::new(pointer, detail));
        }
    }
    given.clone()
}
