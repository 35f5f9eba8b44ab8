//! Forward recursion: motion of every link frame, and the velocity of every link frame per unit joint velocity.

use super::chain::{Chain, Link};
use super::vec3::Vec3;
use super::{LANES, Pack, Real};
use crate::model::Robot;
use crate::spatial::Transform;

/// Motion of link k, in frame k.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkMotion<R> {
    pub sin: R,
    pub cos: R,
    pub angular_velocity: Vec3<R>,
    pub angular_acceleration: Vec3<R>,
    /// Of the origin, minus gravity.
    pub acceleration: Vec3<R>,
    /// `Rᵀ ω_{k−1}`: what the link before contributes, before joint k adds its own turn.
    pub carried_velocity: Vec3<R>,
}

/// Velocity of frame k per unit `qd_j`, in frame k: angular `axis`, linear `lever` of the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointTwist<R> {
    pub axis: Vec3<R>,
    pub lever: Vec3<R>,
}

/// Everything the forward recursion finds; reused from sample to sample.
#[derive(Debug, Clone)]
pub(super) struct Kinematics<R> {
    pub links: Vec<LinkMotion<R>>,
    /// `twists[k(k+1)/2 + j]` for j ≤ k.
    pub twists: Vec<JointTwist<R>>,
}

#[inline(always)]
pub(super) fn pair(j: usize, k: usize) -> usize {
    k * (k + 1) / 2 + j
}

impl Link {
    /// Components in frame k of a vector given in frame k−1: `Rz(q)ᵀ R0ᵀ x`; for a prismatic joint cos = 1, sin = 0.
    #[inline(always)]
    pub fn into_frame<R: Real>(&self, x: Vec3<R>, sin: R, cos: R) -> Vec3<R> {
        let y = x.rotated_back(&self.rotation);
        if !self.revolute {
            return y;
        }
        Vec3::new(cos * y.x + sin * y.y, cos * y.y - sin * y.x, y.z)
    }

    /// The inverse of [`Self::into_frame`].
    #[inline(always)]
    pub fn out_of_frame<R: Real>(&self, x: Vec3<R>, sin: R, cos: R) -> Vec3<R> {
        let y = if self.revolute {
            Vec3::new(cos * x.x - sin * x.y, sin * x.x + cos * x.y, x.z)
        } else {
            x
        };
        y.rotated(&self.rotation)
    }

    /// Position of origin k in frame k−1.
    #[inline(always)]
    pub fn offset<R: Real>(&self, q: R) -> Vec3<R> {
        let fixed = Vec3::splat(self.translation);
        if self.revolute {
            fixed
        } else {
            fixed + self.sliding_axis() * q
        }
    }

    /// The joint's z axis in frame k−1.
    #[inline(always)]
    pub fn sliding_axis<R: Real>(&self) -> Vec3<R> {
        Vec3::splat([self.rotation[0][2], self.rotation[1][2], self.rotation[2][2]])
    }
}

impl<R: Real> Kinematics<R> {
    pub fn new(joints: usize) -> Self {
        let v = Vec3::zero();
        let motion = LinkMotion {
            sin: R::zero(),
            cos: R::splat(1.0),
            angular_velocity: v,
            angular_acceleration: v,
            acceleration: v,
            carried_velocity: v,
        };
        let twist = JointTwist { axis: v, lever: v };
        Self {
            links: vec![motion; joints],
            twists: vec![twist; joints * (joints + 1) / 2],
        }
    }

    /// Fills everything for one sample. `q`, `qd`, `qdd` hand out the value of joint k.
    #[inline(always)]
    pub fn run(&mut self, chain: &Chain, q: impl Fn(usize) -> R, qd: impl Fn(usize) -> R, qdd: impl Fn(usize) -> R) {
        self.run_motion(chain, &q, qd, qdd);
        self.run_twists(chain, &q);
    }

    /// Velocities and accelerations of the link frames (Luh, Walker, Paul 1980).
    #[inline(always)]
    pub fn run_motion(&mut self, chain: &Chain, q: &impl Fn(usize) -> R, qd: impl Fn(usize) -> R, qdd: impl Fn(usize) -> R) {
        let mut velocity = Vec3::zero();
        let mut turning = Vec3::zero();
        let mut acceleration = Vec3::splat(chain.base_acceleration);
        for (k, link) in chain.links.iter().enumerate() {
            let (position, qd, qdd) = (q(k), qd(k), qdd(k));
            let (sin, cos) = if link.revolute {
                position.sin_cos()
            } else {
                (R::zero(), R::splat(1.0))
            };
            let p = link.offset(position);
            let at_origin = acceleration + turning.cross(p) + velocity.cross(velocity.cross(p));
            let carried = link.into_frame(velocity, sin, cos);
            let carried_turning = link.into_frame(turning, sin, cos);
            let mut here = link.into_frame(at_origin, sin, cos);
            // ω × z qd, with z = (0, 0, 1).
            let coriolis = Vec3::new(carried.y * qd, -(carried.x * qd), R::zero());
            velocity = carried;
            turning = carried_turning;
            if link.revolute {
                velocity.z += qd;
                turning += coriolis;
                turning.z += qdd;
            } else {
                here += coriolis + coriolis;
                here.z += qdd;
            }
            acceleration = here;
            self.links[k] = LinkMotion {
                sin,
                cos,
                angular_velocity: velocity,
                angular_acceleration: turning,
                acceleration,
                carried_velocity: carried,
            };
        }
    }

    #[inline(always)]
    fn run_twists(&mut self, chain: &Chain, q: &impl Fn(usize) -> R) {
        let one = Vec3::new(R::zero(), R::zero(), R::splat(1.0));
        for (k, link) in chain.links.iter().enumerate() {
            let p = link.offset(q(k));
            let (sin, cos) = (self.links[k].sin, self.links[k].cos);
            for j in 0..k {
                let before = self.twists[pair(j, k - 1)];
                self.twists[pair(j, k)] = JointTwist {
                    axis: link.into_frame(before.axis, sin, cos),
                    lever: link.into_frame(before.lever + before.axis.cross(p), sin, cos),
                };
            }
            let (axis, lever) = if link.revolute {
                (one, Vec3::zero())
            } else {
                (Vec3::zero(), one)
            };
            self.twists[pair(k, k)] = JointTwist { axis, lever };
        }
    }
}

/// Reads eight samples of a joint-major array (`stride` values per joint) starting at sample `at`.
#[inline(always)]
pub(super) fn load(values: &[f64], stride: usize, joint: usize, at: usize) -> Pack {
    let start = joint * stride + at;
    Pack::load(&values[start..start + LANES])
}

/// Pose of every link frame in the base frame at joint positions `q` (length n).
pub fn forward_kinematics(robot: &Robot, q: &[f64]) -> Vec<Transform> {
    let mut here = Transform::identity();
    let step = |(joint, &q): (&crate::model::Joint, &f64)| {
        here = here * joint.pose(q);
        here
    };
    robot.joints().iter().zip(q).map(step).collect()
}
