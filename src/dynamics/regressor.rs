//! The regressor: torque as a linear function of the standard parameters, `tau = Y(q, qd, qdd) phi`.

use super::kinematics::{JointTwist, Kinematics, LinkMotion, load, pair};
use super::vec3::Vec3;
use super::{Chain, Coulomb, LANES, Motion, Pack, Real};
use crate::model::Robot;
use crate::parameters::{Inertial, Layout, ParameterKind};
use multiversion::multiversion;
use nalgebra::DMatrix;

/// A choice of columns of Y: all of them, or those of the base parameters.
///
/// Row j of Y holds the inertial columns of the links from j on, and the friction columns of joint j alone: everything else is
/// zero and is neither computed nor stored.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSet {
    columns: usize,
    /// Inertial columns wanted, ordered by link: (parameter, output column).
    pub(super) inertial: Vec<Vec<(Inertial, usize)>>,
    pub(super) viscous: Vec<Option<usize>>,
    pub(super) coulomb: Vec<Option<usize>>,
    /// Output column of every column of the block of row j.
    rows: Vec<Vec<usize>>,
}

impl ColumnSet {
    /// The standard columns `wanted` (indices into `layout`), in that order.
    pub fn new(robot: &Robot, layout: &Layout, wanted: &[usize]) -> Self {
        let n = robot.joint_count();
        let mut set = Self {
            columns: wanted.len(),
            inertial: vec![Vec::new(); n],
            viscous: vec![None; n],
            coulomb: vec![None; n],
            rows: Vec::new(),
        };
        for (output, &index) in wanted.iter().enumerate() {
            let parameter = layout.parameters()[index];
            match parameter.kind {
                ParameterKind::Inertial(i) => set.inertial[parameter.link].push((i, output)),
                ParameterKind::Viscous => set.viscous[parameter.link] = Some(output),
                ParameterKind::Coulomb => set.coulomb[parameter.link] = Some(output),
            }
        }
        set.rows = (0..n).map(|j| set.row_columns(j)).collect();
        set
    }

    /// All standard columns.
    pub fn all(robot: &Robot, layout: &Layout) -> Self {
        Self::new(robot, layout, &(0..layout.len()).collect::<Vec<_>>())
    }

    fn row_columns(&self, j: usize) -> Vec<usize> {
        let inertial = self.inertial[j..].iter().flatten().map(|&(_, output)| output);
        inertial.chain(self.viscous[j]).chain(self.coulomb[j]).collect()
    }

    /// Number of output columns.
    pub fn len(&self) -> usize {
        self.columns
    }

    /// Whether it has no column.
    pub fn is_empty(&self) -> bool {
        self.columns == 0
    }

    /// Number of joints n.
    pub fn joints(&self) -> usize {
        self.rows.len()
    }

    /// Output columns that row j of Y can be nonzero in, in the order of [`RowBlocks::block`].
    pub fn row(&self, j: usize) -> &[usize] {
        &self.rows[j]
    }
}

/// The rows of Y over all samples of a motion, one dense block per joint: block j is N × w_j, column-major, its columns those of
/// [`ColumnSet::row`]. Samples are padded with zero rows to [`Motion::stride`].
#[derive(Debug, Clone)]
pub struct RowBlocks {
    stride: usize,
    samples: usize,
    offsets: Vec<usize>,
    pub(super) data: Vec<f64>,
    work: Kinematics<Pack>,
}

impl RowBlocks {
    /// Storage for `samples` samples; reused by every [`Self::fill`].
    pub fn new(columns: &ColumnSet, samples: usize) -> Self {
        let stride = samples.div_ceil(LANES) * LANES;
        let mut offsets = vec![0];
        for j in 0..columns.joints() {
            offsets.push(offsets[j] + columns.row(j).len() * stride);
        }
        let data = vec![0.0; offsets[columns.joints()]];
        Self {
            stride,
            samples,
            offsets,
            data,
            work: Kinematics::new(columns.joints()),
        }
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Numbers from one column of a block to the next: the samples, rounded up to whole vectors.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Takes no more than the first `samples` samples from now on, at most as many as there is room for.
    pub(crate) fn shorten(&mut self, samples: usize) {
        debug_assert!(samples <= self.stride);
        self.samples = samples;
    }

    /// Block of row j: `stride × w_j`, column-major.
    pub fn block(&self, j: usize) -> &[f64] {
        &self.data[self.offsets[j]..self.offsets[j + 1]]
    }

    /// The block of joint `j` for writing, laid out as in [`block`](Self::block).
    pub fn block_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.data[self.offsets[j]..self.offsets[j + 1]]
    }

    /// Computes the rows for `motion`, which must have the joints and samples this was made for. Overwrites everything.
    pub fn fill(&mut self, chain: &Chain, columns: &ColumnSet, motion: &Motion, coulomb: Coulomb) {
        assert_eq!(motion.stride(), self.stride, "made for another number of samples");
        assert_eq!(motion.joints(), columns.joints(), "made for another robot");
        fill_inertial(chain, columns, motion, &self.offsets, &mut self.data, &mut self.work);
        self.fill_friction(columns, motion, coulomb);
        self.clear_padding();
    }

    /// The friction columns alone, for velocities that may be those of another motion.
    pub(crate) fn fill_friction(&mut self, columns: &ColumnSet, motion: &Motion, coulomb: Coulomb) {
        for j in 0..columns.joints() {
            let qd = &motion.qd[j * self.stride..(j + 1) * self.stride];
            let end = self.offsets[j + 1];
            let coulomb_at = columns.coulomb[j].map(|_| end - self.stride);
            let viscous_at = columns.viscous[j].map(|_| coulomb_at.unwrap_or(end) - self.stride);
            if let Some(at) = viscous_at {
                self.data[at..at + self.stride].copy_from_slice(qd);
            }
            if let Some(at) = coulomb_at {
                let column = &mut self.data[at..at + self.stride];
                column.iter_mut().zip(qd).for_each(|(y, &v)| *y = coulomb.value(v));
            }
        }
    }

    /// Padding samples are a robot at rest, whose gravity torques would count as measurements.
    fn clear_padding(&mut self) {
        if self.samples < self.stride {
            for column in self.data.chunks_exact_mut(self.stride) {
                column[self.samples..].fill(0.0);
            }
        }
    }

    /// Y stacked over samples (the paper's overlined Y): row `s n + j` is joint j at sample s; (N n) × p.
    pub fn observation_matrix(&self, columns: &ColumnSet) -> DMatrix<f64> {
        let n = columns.joints();
        let mut w = DMatrix::zeros(self.samples * n, columns.len());
        for j in 0..n {
            for (column, &output) in self.block(j).chunks_exact(self.stride).zip(columns.row(j)) {
                for s in 0..self.samples {
                    w[(s * n + j, output)] = column[s];
                }
            }
        }
        w
    }
}

/// Y of one sample, n × p, over all standard parameters of `layout`: `Y phi` is [`super::inverse_dynamics`].
///
/// `q`, `qd`, `qdd` have length n; overwritten: nothing.
pub fn regressor(robot: &Robot, layout: &Layout, q: &[f64], qd: &[f64], qdd: &[f64]) -> DMatrix<f64> {
    let columns = ColumnSet::all(robot, layout);
    let motion = Motion::from_fn(robot.joint_count(), 1, |j, _| [q[j], qd[j], qdd[j]]);
    let mut rows = RowBlocks::new(&columns, 1);
    rows.fill(&Chain::new(robot), &columns, &motion, Coulomb::Sign);
    rows.observation_matrix(&columns)
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn fill_inertial(
    chain: &Chain,
    columns: &ColumnSet,
    motion: &Motion,
    offsets: &[usize],
    data: &mut [f64],
    work: &mut Kinematics<Pack>,
) {
    let stride = motion.stride();
    let n = columns.joints();
    for at in (0..stride).step_by(LANES) {
        work.run(
            chain,
            |k| load(&motion.q, stride, k, at),
            |k| load(&motion.qd, stride, k, at),
            |k| load(&motion.qdd, stride, k, at),
        );
        for j in 0..n {
            let mut here = offsets[j] + at;
            for k in j..n {
                let entries = entries(&work.twists[pair(j, k)], &work.links[k]);
                for &(which, _) in &columns.inertial[k] {
                    entries[which as usize].store(&mut data[here..here + LANES]);
                    here += stride;
                }
            }
        }
    }
}

/// Torque on joint j per unit of each of the ten parameters of link k:
///
/// - mass: `u·a`
/// - first moment: `u × ω̇ + ω (ω·u) − u (ω·ω) + a × z` (from force and moment of the link)
/// - inertia: `z·(I ω̇) + (z × ω)·(I ω)`, symmetric I
///
/// with `z, u` the twist of joint j at link k, and `a` the acceleration of the link's origin minus gravity.
#[inline(always)]
fn entries<R: Real>(twist: &JointTwist<R>, link: &LinkMotion<R>) -> [R; 10] {
    let (z, u) = (twist.axis, twist.lever);
    let (w, dw, a) = (link.angular_velocity, link.angular_acceleration, link.acceleration);
    let moment = u.cross(dw) + w * w.dot(u) + -(u * w.dot(w)) + a.cross(z);
    let s = z.cross(w);
    [
        u.dot(a),
        moment.x,
        moment.y,
        moment.z,
        z.x * dw.x + s.x * w.x,
        z.x * dw.y + z.y * dw.x + s.x * w.y + s.y * w.x,
        z.x * dw.z + z.z * dw.x + s.x * w.z + s.z * w.x,
        z.y * dw.y + s.y * w.y,
        z.y * dw.z + z.z * dw.y + s.y * w.z + s.z * w.y,
        z.z * dw.z + s.z * w.z,
    ]
}

/// `W x` with the symmetric matrix of the inertia weights. No closure: those may stay out of line, compiled without the vector
/// units of their caller.
#[inline(always)]
fn inertia_weights<R: Real>(weights: &[R; 10], x: Vec3<R>) -> Vec3<R> {
    Vec3::new(
        weights[4] * x.x + weights[5] * x.y + weights[6] * x.z,
        weights[5] * x.x + weights[7] * x.y + weights[8] * x.z,
        weights[6] * x.x + weights[8] * x.y + weights[9] * x.z,
    )
}

/// Adjoint of [`entries`]: given `weights = ∂F/∂entries`, adds `∂F/∂(z, u)` to `to_twist` and `∂F/∂(ω, ω̇, a)` to `to_link`.
#[inline(always)]
pub(super) fn entries_adjoint<R: Real>(
    weights: &[R; 10],
    twist: &JointTwist<R>,
    link: &LinkMotion<R>,
    to_twist: &mut JointTwist<R>,
    to_link: &mut LinkMotion<R>,
) {
    let (z, u) = (twist.axis, twist.lever);
    let (w, dw, a) = (link.angular_velocity, link.angular_acceleration, link.acceleration);
    let mass = weights[0];
    let c = Vec3::new(weights[1], weights[2], weights[3]);
    let s = z.cross(w);
    let to_s = inertia_weights(weights, w);
    let two = R::splat(2.0);
    to_twist.lever += a * mass + dw.cross(c) + w * w.dot(c) + -(c * w.dot(w));
    to_twist.axis += c.cross(a) + inertia_weights(weights, dw) + w.cross(to_s);
    to_link.acceleration += u * mass + z.cross(c);
    to_link.angular_acceleration += c.cross(u) + inertia_weights(weights, z);
    to_link.angular_velocity +=
        c * w.dot(u) + u * w.dot(c) + -(w * (two * u.dot(c))) + inertia_weights(weights, s) + to_s.cross(z);
}
