//! An augmented model as something to design for: columns of its effects along any motion, and what data already say of them.
//!
//! Columns are taken along the motion as commanded, one effect at a time: what the effects do to each other's columns is of
//! second order in their sizes. Sign changes that a distortion moves by a fraction of a sample are left out, as they are in an
//! identification.

use crate::dynamics::{Chain, inverse_dynamics_batch};
use crate::effects::{Motions, Reads, Scene, World};
use crate::excitation::{AddedColumn, AddedColumns, Course};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout, ParameterKind};
use crate::regression::{AugmentedModel, Term, pseudo_inverse, shape_derivatives};
use nalgebra::DMatrix;

/// Columns of effects for the excitation design: of every term its coefficients' columns, then the derivatives by its free shapes
/// (of a distortion by its parameters), at the values that the terms have.
#[derive(Debug, Clone)]
pub struct EffectColumns {
    robot: Robot,
    groups: Vec<Group>,
    count: usize,
}

/// One term, with the model that says what torque the arm carries.
#[derive(Debug, Clone)]
struct Group {
    term: Term,
    first: usize,
    /// Standard parameters without friction.
    rigid: Vec<f64>,
    /// Friction of every joint.
    viscous: Vec<f64>,
    coulomb: Vec<f64>,
}

/// Torques along a motion, n × N.
struct Carried {
    rigid: Vec<Vec<f64>>,
    declared: Vec<Vec<f64>>,
}

impl EffectColumns {
    /// `terms` with the model whose base parameters each was fitted beside.
    pub fn new(robot: &Robot, terms: &[(Term, &AugmentedModel)]) -> Self {
        let mut groups = Vec::new();
        let mut count = 0;
        for (term, model) in terms {
            groups.push(Group::new(robot, term, model, count));
            count += term.parameters();
        }
        Self {
            robot: robot.clone(),
            groups,
            count,
        }
    }
}

impl Group {
    fn new(robot: &Robot, term: &Term, model: &AugmentedModel, first: usize) -> Self {
        let layout = Layout::standard(robot);
        let mut rigid = vec![0.0; layout.len()];
        let kept = model.base.kept.iter().zip(model.values.iter());
        kept.for_each(|(&at, &value)| rigid[at] = value);
        let (mut viscous, mut coulomb) = (vec![0.0; robot.joint_count()], vec![0.0; robot.joint_count()]);
        for (at, parameter) in layout.parameters().iter().enumerate() {
            let friction = match parameter.kind {
                ParameterKind::Inertial(_) => continue,
                ParameterKind::Viscous => &mut viscous,
                ParameterKind::Coulomb => &mut coulomb,
            };
            friction[parameter.link] = std::mem::take(&mut rigid[at]);
        }
        Self {
            term: term.clone(),
            first,
            rigid,
            viscous,
            coulomb,
        }
    }

    /// Torques along a motion, with the signs of the velocities of `signs`.
    fn carried(&self, robot: &Robot, Motions { motors, links }: Motions, signs: &Course) -> Carried {
        let (chain, layout) = (Chain::new(robot), Layout::standard(robot));
        let flat = inverse_dynamics_batch(&chain, &layout, &self.rigid, links, signs.coulomb);
        let row = |j: usize| flat[j * links.stride()..j * links.stride() + links.samples()].to_vec();
        let rigid: Vec<Vec<f64>> = (0..links.joints()).map(row).collect();
        let mut declared = rigid.clone();
        for (j, row) in declared.iter_mut().enumerate() {
            let speeds = motors.velocities(j).iter().zip(signs.motion.velocities(j));
            row.iter_mut()
                .zip(speeds)
                .for_each(|(t, (&v, &sign))| *t += self.viscous[j] * v + self.coulomb[j] * signs.coulomb.value(sign));
        }
        Carried { rigid, declared }
    }

    fn scene<'a>(robot: &'a Robot, course: &Course<'a>, carried: &'a Carried) -> Scene<'a> {
        Scene {
            robot,
            motion: course.motion,
            rigid: &carried.rigid,
            declared: &carried.declared,
            interval: course.interval,
            periodic: course.periodic,
            coulomb: course.coulomb,
        }
    }

    fn additive(&self, robot: &Robot, course: &Course) -> Vec<AddedColumn> {
        let carried = match self.term.effect.reads() {
            // Nothing of it is looked at.
            Reads::OwnJoints => Carried {
                rigid: vec![Vec::new(); robot.joint_count()],
                declared: vec![Vec::new(); robot.joint_count()],
            },
            _ => self.carried(robot, Motions::stiff(course.motion), course),
        };
        let scene = Self::scene(robot, course, &carried);
        let term = &self.term;
        let mut columns = term.effect.columns(term.form, &scene, &term.joints, &term.shape);
        columns.extend(shape_derivatives(term, &scene));
        let numbered = columns.into_iter().enumerate();
        numbered
            .map(|(i, column)| AddedColumn {
                at: self.first + i,
                rows: column.rows,
            })
            .collect()
    }

    /// Central differences around the present values.
    fn distorted(&self, robot: &Robot, course: &Course) -> Vec<AddedColumn> {
        let steps = self.term.effect.steps();
        let of = |i: usize| {
            let side = |sign: f64| {
                let mut theta = self.term.shape.clone();
                theta[i] += sign * steps[i];
                self.torque_in(robot, course, &theta)
            };
            let (up, down) = (side(1.0), side(-1.0));
            let difference = |j: usize| {
                let pairs = up[j].iter().zip(&down[j]);
                (j, pairs.map(|(u, d)| (u - d) / (2.0 * steps[i])).collect())
            };
            AddedColumn {
                at: self.first + i,
                rows: (0..robot.joint_count()).map(difference).collect(),
            }
        };
        (0..steps.len()).map(of).collect()
    }

    /// Torque of the declared model in the world that the distortion makes.
    fn torque_in(&self, robot: &Robot, course: &Course, theta: &[f64]) -> Vec<Vec<f64>> {
        let carried = match self.term.effect.reads() {
            Reads::Course => self.carried(robot, Motions::stiff(course.motion), course),
            _ => Carried {
                rigid: Vec::new(),
                declared: Vec::new(),
            },
        };
        let mut world = World::measured(course.motion, robot);
        let scene = Self::scene(robot, course, &carried);
        self.term.effect.distort(&scene, &self.term.joints, theta, &mut world);
        let mut torque = self
            .carried(&robot.with_gravity(world.gravity), world.motions(), course)
            .declared;
        for (row, gain) in torque.iter_mut().zip(&world.gain) {
            row.iter_mut().for_each(|t| *t *= gain);
        }
        torque
    }
}

impl AddedColumns for EffectColumns {
    fn count(&self) -> usize {
        self.count
    }

    fn groups(&self) -> usize {
        self.groups.len()
    }

    fn columns(&self, group: usize, course: &Course) -> Vec<AddedColumn> {
        let group = &self.groups[group];
        if group.term.is_distortion() {
            group.distorted(&self.robot, course)
        } else {
            group.additive(&self.robot, course)
        }
    }

    fn joints(&self, group: usize) -> Vec<usize> {
        let term = &self.groups[group].term;
        let own = term.effect.reads() == Reads::OwnJoints && !term.joints.is_empty();
        if own {
            term.joints.clone()
        } else {
            (0..self.robot.joint_count()).collect()
        }
    }

    fn is_local(&self, group: usize) -> bool {
        self.groups[group].term.effect.reads() != Reads::Course
    }
}

/// What data say of a model's parameters, as `WᵀW` over the columns of a design: its base parameters, then the parameters of
/// `wanted`.
///
/// `known` and `terms` are base parameters and effects of the fit that `information` (the inverse covariance of base values, then
/// coefficients and free shapes effect by effect) is of. Effects of the fit that the design has not were free there, and are
/// taken out by their Schur complement; of effects that only the design has, the data say nothing.
pub fn information_over(
    known: &BaseParameters,
    terms: &[Term],
    information: &DMatrix<f64>,
    base: &BaseParameters,
    wanted: &[Term],
) -> DMatrix<f64> {
    let size = base.len() + wanted.iter().map(Term::parameters).sum::<usize>();
    // Y[:, kept] = Y_b K[:, kept]: how columns of the design are combinations of those of the fit.
    let mut map = DMatrix::zeros(information.nrows(), size);
    for (c, &column) in base.kept.iter().enumerate() {
        map.view_mut((0, c), (known.len(), 1)).copy_from(&known.map.column(column));
    }
    let mut own: Vec<usize> = (0..known.len()).collect();
    let (mut from, mut taken) = (known.len(), Vec::new());
    for term in terms {
        let mut to = base.len();
        for (w, other) in wanted.iter().enumerate() {
            if is_same(term, other) && !taken.contains(&w) {
                taken.push(w);
                own.extend(from..from + term.parameters());
                (0..term.parameters()).for_each(|i| map[(from + i, to + i)] = 1.0);
                break;
            }
            to += other.parameters();
        }
        from += term.parameters();
    }
    let others: Vec<usize> = (0..information.nrows()).filter(|i| !own.contains(i)).collect();
    let part = |rows: &[usize], columns: &[usize]| information.select_rows(rows).select_columns(columns);
    let mut left = part(&own, &own);
    if !others.is_empty() {
        let cross = part(&own, &others);
        left -= &cross * pseudo_inverse(&part(&others, &others), 1e-13) * cross.transpose();
    }
    let map = map.select_rows(&own);
    map.tr_mul(&(left * &map))
}

fn is_same(one: &Term, other: &Term) -> bool {
    one.effect.code() == other.effect.code()
        && one.joints == other.joints
        && one.form == other.form
        && one.parameters() == other.parameters()
}
