//! Inverse dynamics by recursive Newton-Euler (Luh, Walker, Paul 1980), over the standard parameters.
//!
//! Independent of the regressor: forces and moments are passed down the chain instead of projected link by link, so that
//! `Y phi = inverse dynamics` is a test and not a restatement.

use super::kinematics::{Kinematics, load};
use super::vec3::Vec3;
use super::{Chain, Coulomb, LANES, Motion, Pack, Real};
use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use multiversion::multiversion;

/// Joint torques (forces for prismatic joints) of one sample: `tau` (n) for `phi` (p, in the order of `layout`) at `q, qd, qdd`
/// (n).
///
/// # Panics
/// When a length does not match the robot.
pub fn inverse_dynamics(robot: &Robot, layout: &Layout, phi: &[f64], q: &[f64], qd: &[f64], qdd: &[f64]) -> Vec<f64> {
    let n = robot.joint_count();
    assert!(q.len() == n && qd.len() == n && qdd.len() == n, "one value per joint");
    let chain = Chain::new(robot);
    let bodies = Body::all(layout, phi, n);
    let mut work = Kinematics::new(n);
    let mut wrenches = vec![Wrench::zero(); n];
    let mut tau = vec![0.0; n];
    work.run_motion(&chain, &|k| q[k], |k| qd[k], |k| qdd[k]);
    pass_down(&chain, &bodies, &work, |k| q[k], &mut wrenches, |k, v| tau[k] = v);
    for (k, body) in bodies.iter().enumerate() {
        tau[k] += body.viscous * qd[k] + body.coulomb * Coulomb::Sign.value(qd[k]);
    }
    tau
}

/// Joint torques over a whole motion, joint-major with [`Motion::stride`]; padding samples hold gravity torques of the robot at
/// zero.
pub fn inverse_dynamics_batch(chain: &Chain, layout: &Layout, phi: &[f64], motion: &Motion, coulomb: Coulomb) -> Vec<f64> {
    let bodies = Body::all(layout, phi, chain.joint_count());
    let mut tau = vec![0.0; motion.joints() * motion.stride()];
    run_packs(chain, &bodies, motion, &mut tau);
    for (k, body) in bodies.iter().enumerate() {
        let range = k * motion.stride()..(k + 1) * motion.stride();
        for (t, &v) in tau[range.clone()].iter_mut().zip(&motion.qd[range]) {
            *t += body.viscous * v + body.coulomb * coulomb.value(v);
        }
    }
    tau
}

/// Parameters of one link as constants of the recursion.
struct Body {
    mass: f64,
    first_moment: [f64; 3],
    inertia: [[f64; 3]; 3],
    viscous: f64,
    coulomb: f64,
}

impl Body {
    fn all(layout: &Layout, phi: &[f64], links: usize) -> Vec<Self> {
        assert_eq!(phi.len(), layout.len(), "one value per standard parameter");
        let friction = |link: usize, kind: ParameterKind| {
            let found = layout.parameters().iter().position(|p| p.link == link && p.kind == kind);
            found.map_or(0.0, |at| phi[at])
        };
        (0..links)
            .map(|k| {
                let body = layout.link_inertia(phi, k);
                Self {
                    mass: body.mass,
                    first_moment: body.first_moment.into(),
                    inertia: std::array::from_fn(|r| std::array::from_fn(|c| body.inertia[(r, c)])),
                    viscous: friction(k, ParameterKind::Viscous),
                    coulomb: friction(k, ParameterKind::Coulomb),
                }
            })
            .collect()
    }
}

#[derive(Clone, Copy)]
struct Wrench<R> {
    force: Vec3<R>,
    moment: Vec3<R>,
}

impl<R: Real> Wrench<R> {
    fn zero() -> Self {
        Self {
            force: Vec3::zero(),
            moment: Vec3::zero(),
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn run_packs(chain: &Chain, bodies: &[Body], motion: &Motion, tau: &mut [f64]) {
    let stride = motion.stride();
    let n = chain.joint_count();
    let mut work = Kinematics::<Pack>::new(n);
    let mut wrenches = vec![Wrench::zero(); n];
    for at in (0..stride).step_by(LANES) {
        let q = |k| load(&motion.q, stride, k, at);
        work.run_motion(
            chain,
            &q,
            |k| load(&motion.qd, stride, k, at),
            |k| load(&motion.qdd, stride, k, at),
        );
        pass_down(chain, bodies, &work, q, &mut wrenches, |k, v| {
            let start = k * stride + at;
            v.store(&mut tau[start..start + LANES]);
        });
    }
}

/// Newton and Euler for every link about its frame origin, then wrenches from the last link to the first.
///
/// `f = m a + ω̇ × h + ω × (ω × h)`, `n = I ω̇ + ω × I ω + h × a`; `tau = z·n` (revolute) or `z·f` (prismatic).
#[inline(always)]
fn pass_down<R: Real>(
    chain: &Chain,
    bodies: &[Body],
    work: &Kinematics<R>,
    q: impl Fn(usize) -> R,
    wrenches: &mut [Wrench<R>],
    mut tau: impl FnMut(usize, R),
) {
    for ((wrench, body), link) in wrenches.iter_mut().zip(bodies).zip(&work.links) {
        let h = Vec3::splat(body.first_moment);
        let (w, dw, a) = (link.angular_velocity, link.angular_acceleration, link.acceleration);
        wrench.force = a * R::splat(body.mass) + dw.cross(h) + w.cross(w.cross(h));
        wrench.moment = dw.rotated(&body.inertia) + w.cross(w.rotated(&body.inertia)) + h.cross(a);
    }
    for k in (0..wrenches.len()).rev() {
        let Wrench { force, moment } = wrenches[k];
        let (link, motion) = (&chain.links[k], &work.links[k]);
        tau(k, if link.revolute { moment.z } else { force.z });
        if k > 0 {
            let f = link.out_of_frame(force, motion.sin, motion.cos);
            let m = link.out_of_frame(moment, motion.sin, motion.cos);
            wrenches[k - 1].force += f;
            wrenches[k - 1].moment += m + link.offset(q(k)).cross(f);
        }
    }
}
