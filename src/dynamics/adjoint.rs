//! The adjoint of the regressor: from `∂F/∂Y` to `∂F/∂(q, qd, qdd)`, one backward sweep per sample.
//!
//! For any scalar F of the observation matrix, exact gradients follow from the weights `W = ∂F/∂Y` alone. A singular value of
//! Y_b has `W = u vᵀ`; a function of the Gram matrix `M = Yᵀ Y` with symmetric derivative G has `W = 2 Y G`.

use super::kinematics::{JointTwist, Kinematics, LinkMotion, load, pair};
use super::regressor::entries_adjoint;
use super::vec3::Vec3;
use super::{Chain, ColumnSet, Coulomb, LANES, Motion, Pack, Real, RowBlocks};
use multiversion::multiversion;

/// `∂F/∂q, ∂F/∂qd, ∂F/∂qdd` in the layout of [`Motion`], with the storage the sweep needs.
#[derive(Debug, Clone)]
pub struct MotionGradient {
    stride: usize,
    pub(crate) q: Vec<f64>,
    pub(crate) qd: Vec<f64>,
    pub(crate) qdd: Vec<f64>,
    work: Kinematics<Pack>,
    adjoint: Kinematics<Pack>,
}

impl MotionGradient {
    /// Storage for motions of `joints` joints and `samples` samples.
    pub fn new(joints: usize, samples: usize) -> Self {
        let stride = samples.div_ceil(LANES) * LANES;
        let zeros = vec![0.0; joints * stride];
        let work = Kinematics::new(joints);
        Self {
            stride,
            q: zeros.clone(),
            qd: zeros.clone(),
            qdd: zeros,
            adjoint: work.clone(),
            work,
        }
    }

    /// `[∂F/∂q, ∂F/∂qd, ∂F/∂qdd]` of a joint at a sample.
    pub fn get(&self, joint: usize, sample: usize) -> [f64; 3] {
        let at = joint * self.stride + sample;
        [self.q[at], self.qd[at], self.qdd[at]]
    }

    /// Takes over the gradient at the samples of `part`, which stand from `first` on in this one.
    pub(crate) fn put(&mut self, part: &Self, first: usize) {
        let samples = part.stride.min(self.stride - first);
        for (to, from) in [(&mut self.q, &part.q), (&mut self.qd, &part.qd), (&mut self.qdd, &part.qdd)] {
            for (to, from) in to.chunks_exact_mut(self.stride).zip(from.chunks_exact(part.stride)) {
                to[first..first + samples].copy_from_slice(&from[..samples]);
            }
        }
    }

    /// Computes the gradient at `motion` of the F whose `∂F/∂Y` is `weights` (blocks as of [`RowBlocks::fill`]). Overwrites
    /// everything. The sign of the Coulomb column has no derivative; its smooth stand-in has.
    pub fn fill(&mut self, chain: &Chain, columns: &ColumnSet, motion: &Motion, coulomb: Coulomb, weights: &RowBlocks) {
        assert_eq!(motion.stride(), self.stride, "made for another number of samples");
        sweep(chain, columns, motion, weights, self);
        self.add_friction(columns, motion, coulomb, weights);
    }

    fn add_friction(&mut self, columns: &ColumnSet, motion: &Motion, coulomb: Coulomb, weights: &RowBlocks) {
        for j in 0..columns.joints() {
            let range = j * self.stride..(j + 1) * self.stride;
            let (to, qd) = (&mut self.qd[range.clone()], &motion.qd[range]);
            let mut blocks = weights.block(j).rchunks_exact(self.stride);
            if columns.coulomb[j].is_some() {
                let w = blocks.next().expect("the block has its Coulomb column");
                to.iter_mut()
                    .zip(w)
                    .zip(qd)
                    .for_each(|((g, w), &v)| *g += w * coulomb.slope(v));
            }
            if columns.viscous[j].is_some() {
                let w = blocks.next().expect("the block has its viscous column");
                to.iter_mut().zip(w).for_each(|(g, w)| *g += w);
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn sweep(chain: &Chain, columns: &ColumnSet, motion: &Motion, weights: &RowBlocks, out: &mut MotionGradient) {
    let stride = motion.stride();
    let n = columns.joints();
    // Columns of the links before each.
    let before: Vec<usize> = columns
        .inertial
        .iter()
        .scan(0, |sum, own| Some(std::mem::replace(sum, *sum + own.len())))
        .collect();
    for at in (0..stride).step_by(LANES) {
        let (work, adjoint) = (&mut out.work, &mut out.adjoint);
        work.run(
            chain,
            |k| load(&motion.q, stride, k, at),
            |k| load(&motion.qd, stride, k, at),
            |k| load(&motion.qdd, stride, k, at),
        );
        for k in 0..n {
            // What is no column has no weight; zeroed once per link, not once per pair of joints.
            let mut w = [Pack::zero(); 10];
            clear_link(&mut adjoint.links[k]);
            for j in 0..=k {
                let (block, first) = (weights.block(j), before[k] - before[j]);
                for (column, &(which, _)) in (first..).zip(&columns.inertial[k]) {
                    w[which as usize] = Pack::load(&block[column * stride + at..]);
                }
                let (at_pair, v) = (pair(j, k), Vec3::zero());
                adjoint.twists[at_pair] = JointTwist { axis: v, lever: v };
                entries_adjoint(
                    &w,
                    &work.twists[at_pair],
                    &work.links[k],
                    &mut adjoint.twists[at_pair],
                    &mut adjoint.links[k],
                );
            }
        }
        for k in (0..n).rev() {
            let state = [&motion.q, &motion.qd].map(|v| load(v, stride, k, at));
            let qdd = load(&motion.qdd, stride, k, at);
            let gradient = back_through(chain, work, adjoint, k, [state[0], state[1], qdd]);
            let start = k * stride + at;
            gradient[0].store(&mut out.q[start..start + LANES]);
            gradient[1].store(&mut out.qd[start..start + LANES]);
            gradient[2].store(&mut out.qdd[start..start + LANES]);
        }
    }
}

#[inline(always)]
fn clear_link<R: Real>(link: &mut LinkMotion<R>) {
    let v = Vec3::zero();
    (link.angular_velocity, link.angular_acceleration, link.acceleration) = (v, v, v);
}

/// Derivative of `y = Rz(q)ᵀ x` by q, weighted: `−(z × y)·dy`.
#[inline(always)]
fn turn<R: Real>(dy: Vec3<R>, y: Vec3<R>) -> R {
    dy.x * y.y - dy.y * y.x
}

/// One backward step: from the adjoint of link k to that of link k−1, and `∂F/∂(q_k, qd_k, qdd_k)`.
#[inline(always)]
fn back_through<R: Real>(
    chain: &Chain,
    work: &Kinematics<R>,
    adjoint: &mut Kinematics<R>,
    k: usize,
    [q, qd, _qdd]: [R; 3],
) -> [R; 3] {
    let link = &chain.links[k];
    let here = &work.links[k];
    let (sin, cos) = (here.sin, here.cos);
    let p = link.offset(q);
    let (mut to_q, mut to_p) = (R::zero(), Vec3::zero());
    for j in 0..k {
        let twist = work.twists[pair(j, k)];
        let before = work.twists[pair(j, k - 1)];
        let d = adjoint.twists[pair(j, k)];
        if link.revolute {
            to_q += turn(d.axis, twist.axis) + turn(d.lever, twist.lever);
        }
        let lever = link.out_of_frame(d.lever, sin, cos);
        let to = &mut adjoint.twists[pair(j, k - 1)];
        to.axis += link.out_of_frame(d.axis, sin, cos) + p.cross(lever);
        to.lever += lever;
        to_p += lever.cross(before.axis);
    }
    let LinkMotion {
        angular_velocity: dw,
        angular_acceleration: ddw,
        acceleration: da,
        ..
    } = adjoint.links[k];
    let c = here.carried_velocity;
    let two = R::splat(2.0);
    let (to_carried, to_qd, to_qdd);
    if link.revolute {
        to_qd = dw.z + c.y * ddw.x - c.x * ddw.y;
        to_qdd = ddw.z;
        to_carried = dw + Vec3::new(-(ddw.y * qd), ddw.x * qd, R::zero());
        let turning = here.angular_acceleration;
        let carried_turning = Vec3::new(turning.x - c.y * qd, turning.y + c.x * qd, turning.z);
        to_q += turn(to_carried, c) + turn(ddw, carried_turning) + turn(da, here.acceleration);
    } else {
        to_qd = two * (c.y * da.x - c.x * da.y);
        to_qdd = da.z;
        to_carried = dw + Vec3::new(-(da.y * qd), da.x * qd, R::zero()) * two;
    }
    let gx = link.out_of_frame(da, sin, cos);
    let (w, turning) = match k {
        0 => (Vec3::zero(), Vec3::zero()),
        _ => (work.links[k - 1].angular_velocity, work.links[k - 1].angular_acceleration),
    };
    to_p += gx.cross(turning) + w * w.dot(gx) + -(gx * w.dot(w));
    if !link.revolute {
        to_q += to_p.dot(link.sliding_axis());
    }
    if k > 0 {
        let to = &mut adjoint.links[k - 1];
        to.angular_velocity += link.out_of_frame(to_carried, sin, cos) + gx * w.dot(p) + p * w.dot(gx) + -(w * (two * p.dot(gx)));
        to.angular_acceleration += link.out_of_frame(ddw, sin, cos) + p.cross(gx);
        to.acceleration += gx;
    }
    [to_q, to_qd, to_qdd]
}
