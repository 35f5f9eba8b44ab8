//! The declared model with effects added: what it predicts, and how that changes with every parameter.

use super::Stretch;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::effects::{Column, Effect, Kind, Scene, Span, World};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout, ParameterKind};
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

/// An effect with its values.
#[derive(Clone)]
pub struct Term {
    pub effect: &'static dyn Effect,
    pub form: usize,
    pub joints: Vec<usize>,
    /// Of the columns.
    pub coefficients: Vec<f64>,
    /// Shape parameters, or the parameters of a distortion.
    pub shape: Vec<f64>,
    /// How many of the shape parameters are estimated, from the first.
    pub free_shapes: usize,
    /// Where each of them may lie.
    pub bounds: Vec<[f64; 2]>,
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}[{}]{:?} c={:?} s={:?}",
            self.effect.code(),
            self.form,
            self.joints,
            self.coefficients,
            self.shape
        )
    }
}

impl Term {
    pub(crate) fn is_distortion(&self) -> bool {
        self.effect.kind() == Kind::Distortion
    }

    /// Number of estimated parameters.
    pub fn parameters(&self) -> usize {
        self.coefficients.len() + self.free_shapes
    }

    /// Whether joints, coefficients and shapes are as many as the effect has on this robot.
    pub fn is_complete(&self, robot: &Robot) -> bool {
        let place = self.effect.places(robot).contains(&self.joints);
        let bounded = self.bounds.len() >= self.free_shapes && self.free_shapes <= self.shape.len();
        if self.is_distortion() {
            return place && bounded && self.coefficients.is_empty() && self.shape.len() == self.effect.steps().len();
        }
        let span = Span {
            range: 1.0,
            speed: 1.0,
            interval: 1e-3,
        };
        let spans = vec![span; robot.joint_count()];
        let still = Motion::zeros(robot.joint_count(), 2);
        let rest = vec![vec![0.0; 2]; robot.joint_count()];
        let scene = Scene {
            robot,
            motion: &still,
            rigid: &rest,
            declared: &rest,
            interval: span.interval,
            periodic: false,
            coulomb: Coulomb::Sign,
        };
        place
            && bounded
            && self.shape.len() == self.effect.shapes(self.form, &self.joints, &spans).len()
            && self.coefficients.len() == self.effect.columns(self.form, &scene, &self.joints, &self.shape).len()
    }
}

/// Base parameters and effects.
#[derive(Debug, Clone)]
pub struct AugmentedModel {
    pub robot: Robot,
    pub base: BaseParameters,
    /// Values of the base parameters.
    pub values: DVector<f64>,
    pub terms: Vec<Term>,
}

/// A model's rows over one stretch.
pub(crate) struct Evaluated {
    /// The motion after all distortions.
    pub motion: Motion,
    /// n × M, shaped.
    pub torque: Vec<Vec<f64>>,
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
    pub gain: Vec<f64>,
    /// Per joint, `(parameter, values)` of every column that is not zero there; shaped.
    pub jacobian: ShapedRows,
}

/// Per joint, `(parameter, values over the rows)` of every column that is not zero there.
pub(crate) type ShapedRows = Vec<Vec<(usize, Vec<f64>)>>;

impl AugmentedModel {
    /// The declared model with all parameters zero.
    pub fn declared(robot: &Robot) -> Self {
        // A base that is not level makes parameters of the first links act that gravity along their axes hides; their columns are zero
        // until a tilt is in the model.
        let anyhow = Rotation3::from_euler_angles(0.1, 0.07, 0.0) * robot.gravity();
        let base = BaseParameters::exact(&robot.with_gravity(anyhow));
        let values = DVector::zeros(base.len());
        Self {
            robot: robot.clone(),
            base,
            values,
            terms: Vec::new(),
        }
    }

    /// Number of estimated parameters.
    pub fn parameters(&self) -> usize {
        self.values.len() + self.terms.iter().map(Term::parameters).sum::<usize>()
    }

    /// First parameter of term `at` in the order of [`Self::vector`].
    pub fn offset_of(&self, at: usize) -> usize {
        self.values.len() + self.terms[..at].iter().map(Term::parameters).sum::<usize>()
    }

    /// All parameters: base, then per term the coefficients and the free shapes.
    pub fn vector(&self) -> DVector<f64> {
        let mut all: Vec<f64> = self.values.iter().copied().collect();
        for term in &self.terms {
            all.extend(&term.coefficients);
            all.extend(&term.shape[..term.free_shapes]);
        }
        DVector::from_vec(all)
    }

    /// The model with its parameters moved by `step`, shapes kept where they may lie.
    pub fn moved(&self, step: &DVector<f64>) -> Self {
        let mut there = self.clone();
        let b = self.values.len();
        there.values += step.rows(0, b);
        let mut at = b;
        for term in &mut there.terms {
            for c in &mut term.coefficients {
                *c += step[at];
                at += 1;
            }
            for i in 0..term.free_shapes {
                term.shape[i] = (term.shape[i] + step[at]).clamp(term.bounds[i][0], term.bounds[i][1]);
                at += 1;
            }
        }
        there
    }

    /// Torque of every joint over the rows of a stretch; n × M [N·m or N].
    pub fn predict(&self, stretch: &Stretch) -> Vec<Vec<f64>> {
        self.evaluate(stretch, None).torque
    }

    /// How the torque along a motion changes with every parameter of the effects, per joint: `(parameter, values over the samples)` of every column
    /// that is not zero there, parameters counted over the terms from 0 (coefficients, then free shapes) [N·m or N per unit of it]. For
    /// designing a motion that determines the effects beside the base parameters: their columns stand next to the regressor's. The columns of a
    /// distortion are those of the declared torque.
    ///
    /// `interval` is the time between samples (s); `periodic` says whether the sample after the last is the first.
    pub fn effect_columns(&self, motion: &Motion, interval: f64, periodic: bool) -> Vec<Vec<(usize, Vec<f64>)>> {
        let stretch = Stretch::of_motion(motion.clone(), interval, periodic);
        let nothing = vec![Vec::new(); self.robot.joint_count()];
        let base = self.values.len();
        let derivatives = self.evaluate(&stretch, Some(&nothing)).jacobian;
        let own = |columns: Vec<(usize, Vec<f64>)>| {
            let effects = columns.into_iter().filter(|(at, _)| *at >= base);
            effects.map(|(at, values)| (at - base, values)).collect()
        };
        derivatives.into_iter().map(own).collect()
    }

    /// Rows of the base parameters along the motion as measured.
    pub(crate) fn base_rows(&self, stretch: &Stretch) -> ShapedRows {
        let (set, rows) = self.fill(&self.robot, &stretch.motion);
        let shaped = |j: usize| {
            let blocks = rows.block(j).chunks_exact(rows.stride()).zip(set.row(j));
            blocks
                .map(|(values, &at)| (at, stretch.shaped(values[..rows.samples()].to_vec())))
                .collect()
        };
        (0..self.robot.joint_count()).map(shaped).collect()
    }

    fn fill(&self, robot: &Robot, motion: &Motion) -> (ColumnSet, RowBlocks) {
        let set = self.columns();
        let mut rows = RowBlocks::new(&set, motion.samples());
        rows.fill(&Chain::new(robot), &set, motion, Coulomb::Sign);
        (set, rows)
    }

    fn columns(&self) -> ColumnSet {
        ColumnSet::new(&self.robot, &Layout::standard(&self.robot), &self.base.kept)
    }

    /// Torque over the rows of a stretch, and, where the base parameters' rows along its undistorted motion are handed in, the derivatives.
    pub(crate) fn evaluate(&self, stretch: &Stretch, base: Option<&ShapedRows>) -> Evaluated {
        let plain = self.torques(&stretch.motion, &self.robot, None);
        let distorted = self.terms.iter().any(Term::is_distortion);
        let world = self.world(stretch, &plain, None);
        let robot = self.robot.with_gravity(world.gravity);
        let (mut jacobian, here) = match base {
            Some(rows) if !distorted => (rows.clone(), plain.clone()),
            Some(_) => {
                let (set, rows) = self.fill(&robot, &world.motion);
                let block = |j: usize| {
                    let blocks = rows.block(j).chunks_exact(rows.stride()).zip(set.row(j));
                    let scaled = |v: &f64| v * world.gain[j];
                    blocks
                        .map(|(values, &at)| (at, stretch.shaped(values[..rows.samples()].iter().map(scaled).collect())))
                        .collect()
                };
                let jacobian = (0..self.robot.joint_count()).map(block).collect();
                (jacobian, self.torques(&world.motion, &robot, Some((&set, &rows))))
            }
            None if distorted => (Vec::new(), self.torques(&world.motion, &robot, None)),
            None => (Vec::new(), plain.clone()),
        };
        let scene = Scene {
            robot: &robot,
            motion: &world.motion,
            rigid: &here.rigid,
            declared: &here.declared,
            interval: stretch.interval,
            periodic: stretch.periodic,
            coulomb: Coulomb::Sign,
        };
        let mut torque = here.declared.clone();
        for (t, term) in self.terms.iter().enumerate().filter(|(_, t)| !t.is_distortion()) {
            let columns = term.effect.columns(term.form, &scene, &term.joints, &term.shape);
            add_columns(&mut torque, &columns, &term.coefficients);
            if base.is_some() {
                let derivatives = shape_derivatives(term, &scene);
                push_columns(&mut jacobian, &columns, self.offset_of(t), stretch, &world.gain);
                let at = self.offset_of(t) + term.coefficients.len();
                push_columns(&mut jacobian, &derivatives, at, stretch, &world.gain);
            }
        }
        let gained = torque.into_iter().zip(&world.gain);
        let torque = gained
            .map(|(row, g)| stretch.shaped(row.into_iter().map(|v| v * g).collect()))
            .collect();
        if base.is_some() && distorted {
            let known = (&world.motion, world.gravity, &here.declared[..]);
            self.push_distortions(&mut jacobian, stretch, &plain, known);
        }
        Evaluated {
            motion: world.motion,
            torque,
            rigid: here.rigid,
            declared: here.declared,
            gain: world.gain,
            jacobian,
        }
    }

    fn push_distortions(&self, jacobian: &mut ShapedRows, stretch: &Stretch, plain: &Torques, known: KnownTorque) {
        for (t, term) in self.terms.iter().enumerate().filter(|(_, t)| t.is_distortion()) {
            let columns = self.distortion_columns(stretch, plain, term, Some(t), known);
            for (i, rows) in columns.into_iter().enumerate() {
                let at = self.offset_of(t) + i;
                rows.into_iter()
                    .enumerate()
                    .for_each(|(j, v)| jacobian[j].push((at, stretch.shaped(v))));
            }
        }
    }

    /// Derivative of the declared torque by every parameter of a distortion, n × N each, by central differences around its present value
    /// (zero for a distortion that is not in the model). Where the motion and gravity are those of `known`, so is the torque.
    pub(crate) fn distortion_columns(
        &self,
        stretch: &Stretch,
        plain: &Torques,
        term: &Term,
        at: Option<usize>,
        known: KnownTorque,
    ) -> Vec<Vec<Vec<f64>>> {
        let steps = term.effect.steps();
        (0..steps.len())
            .map(|i| {
                let side = |sign: f64| {
                    let mut moved = term.clone();
                    moved.shape[i] += sign * steps[i];
                    let world = self.world(stretch, plain, Some((at, &moved)));
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
                let (up, down) = (side(1.0), side(-1.0));
                let difference =
                    |(u, d): (&Vec<f64>, &Vec<f64>)| u.iter().zip(d).map(|(u, d)| (u - d) / (2.0 * steps[i])).collect();
                up.iter().zip(&down).map(difference).collect()
            })
            .collect()
    }

    /// All distortions applied in turn; `changed` stands in for the term at that place, or comes on top. Where one depends on the load, the load
    /// is that of the distorted motion: an elastic joint bends by a few per cent of what its own bending changes, so that [`LOAD_ROUNDS`] are enough.
    fn world(&self, stretch: &Stretch, plain: &Torques, changed: Option<(Option<usize>, &Term)>) -> World {
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
        let mut world = self.distorted(stretch, &plain.rigid, &plain.declared, &list);
        // Around zero the derivative is that of the undistorted load.
        let bends =
            |t: &&&Term| t.effect.distorts_by_load() && t.shape.iter().zip(t.effect.steps()).any(|(v, h)| v.abs() > 1.5 * h);
        if list.iter().any(|t| bends(&t)) {
            for _ in 0..LOAD_ROUNDS {
                let there = self.torques(&world.motion, &self.robot.with_gravity(world.gravity), None);
                world = self.distorted(stretch, &there.rigid, &there.declared, &list);
            }
        }
        world
    }

    fn distorted(&self, stretch: &Stretch, rigid: &[Vec<f64>], declared: &[Vec<f64>], list: &[&Term]) -> World {
        let mut world = World {
            motion: stretch.motion.clone(),
            gravity: self.robot.gravity(),
            gain: vec![1.0; self.robot.joint_count()],
        };
        let scene = Scene {
            robot: &self.robot,
            motion: &stretch.motion,
            rigid,
            declared,
            interval: stretch.interval,
            periodic: stretch.periodic,
            coulomb: Coulomb::Sign,
        };
        for term in list {
            term.effect.distort(&scene, &term.joints, &term.shape, &mut world);
        }
        world
    }

    /// Rigid and declared torque along `motion`, from rows where they are there already.
    pub(crate) fn torques(&self, motion: &Motion, robot: &Robot, rows: Option<(&ColumnSet, &RowBlocks)>) -> Torques {
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
                let flat = crate::dynamics::inverse_dynamics_batch(&Chain::new(robot), &layout, &bare, motion, Coulomb::Sign);
                (0..n)
                    .map(|j| flat[j * motion.stride()..j * motion.stride() + motion.samples()].to_vec())
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
            let speeds = motion.velocities(parameter.link);
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

/// A motion, gravity, and the declared torque that goes with them.
pub(crate) type KnownTorque<'a> = (&'a Motion, Vector3<f64>, &'a [Vec<f64>]);

/// Each round leaves the few per cent of the one before: after two, 1e-4 of the bending.
const LOAD_ROUNDS: usize = 2;

/// Torques along a motion, n × N.
#[derive(Debug, Clone)]
pub(crate) struct Torques {
    pub rigid: Vec<Vec<f64>>,
    pub declared: Vec<Vec<f64>>,
}

fn add_columns(torque: &mut [Vec<f64>], columns: &[Column], coefficients: &[f64]) {
    for (column, &c) in columns.iter().zip(coefficients) {
        for (j, values) in &column.rows {
            torque[*j].iter_mut().zip(values).for_each(|(t, v)| *t += c * v);
        }
    }
}

fn push_columns(jacobian: &mut ShapedRows, columns: &[Column], at: usize, stretch: &Stretch, gain: &[f64]) {
    for (i, column) in columns.iter().enumerate() {
        for (j, values) in &column.rows {
            let gained = values.iter().map(|v| v * gain[*j]).collect();
            jacobian[*j].push((at + i, stretch.shaped(gained)));
        }
    }
}

/// `∂(C c)/∂shape` by central differences; a thousandth of the value is far above rounding and far below the curvature of any column.
pub(crate) fn shape_derivatives(term: &Term, scene: &Scene) -> Vec<Column> {
    (0..term.free_shapes)
        .map(|i| {
            let step = 1e-4 * term.shape[i].abs().max(1e-6);
            let torque = |sign: f64| {
                let mut shape = term.shape.clone();
                shape[i] += sign * step;
                let columns = term.effect.columns(term.form, scene, &term.joints, &shape);
                let mut sum = vec![vec![0.0; scene.samples()]; scene.robot.joint_count()];
                add_columns(&mut sum, &columns, &term.coefficients);
                (sum, columns)
            };
            let ((up, columns), (down, _)) = (torque(1.0), torque(-1.0));
            let mut rows: Vec<usize> = columns.iter().flat_map(|c| c.rows.iter().map(|r| r.0)).collect();
            rows.sort_unstable();
            rows.dedup();
            let values = |j: usize| up[j].iter().zip(&down[j]).map(|(u, d)| (u - d) / (2.0 * step)).collect();
            Column {
                rows: rows.into_iter().map(|j| (j, values(j))).collect(),
            }
        })
        .collect()
}

/// Standard deviations of what a term reports, from the covariance of its coefficients and free shapes.
pub(crate) fn reported(term: &Term, covariance: &DMatrix<f64>) -> Vec<(f64, f64)> {
    let k = term.coefficients.len();
    let point: Vec<f64> = term
        .coefficients
        .iter()
        .chain(&term.shape[..term.free_shapes])
        .copied()
        .collect();
    let at = |x: &[f64]| {
        let shape: Vec<f64> = x[k..].iter().chain(&term.shape[term.free_shapes..]).copied().collect();
        term.effect.reported(term.form, &x[..k], &shape)
    };
    let values = at(&point);
    let mut jacobian = DMatrix::zeros(values.len(), point.len());
    for c in 0..point.len() {
        // A thousandth of a standard deviation: the map is smooth over that.
        let step = (1e-3 * covariance[(c, c)].max(0.0).sqrt())
            .max(1e-9 * point[c].abs())
            .max(f64::MIN_POSITIVE);
        let mut there = point.clone();
        there[c] += step;
        at(&there)
            .iter()
            .enumerate()
            .for_each(|(r, v)| jacobian[(r, c)] = (v - values[r]) / step);
    }
    let spread = &jacobian * covariance * jacobian.transpose();
    values
        .iter()
        .enumerate()
        .map(|(r, &v)| (v, spread[(r, r)].max(0.0).sqrt()))
        .collect()
}
