//! Equations of motion of a serial arm: inverse dynamics, regressor, and the adjoint of the regressor.
//!
//! Notation (frames, vectors and parameters are those of Khalil & Dombre 2004; the paper's section 2):
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | `ω_k, ω̇_k` | `angular_velocity`, `angular_acceleration` | of link k, in frame k |
//! | `v̇_k − g` | `acceleration` | of the origin of frame k, minus gravity, in frame k |
//! | `z_jk, u_jk` | `axis`, `lever` | angular and linear velocity of frame k per unit `qd_j`, in frame k |
//! | `Y` | [`RowBlocks`], [`regressor`] | `tau = Y phi`, n × p |
//!
//! Everything is written once, generically over [`Real`], and runs on single samples (`f64`) or on [`Pack`]s of eight.

mod adjoint;
mod base;
mod batch;
mod chain;
mod channel;
mod energy;
mod inverse;
mod kinematics;
mod real;
mod regressor;
mod vec3;

pub use adjoint::MotionGradient;
pub use base::numeric_base_parameters;
pub use batch::{Coulomb, Motion};
pub use chain::Chain;
pub use channel::Channel;
pub use energy::{Energy, energy};
pub use inverse::{inverse_dynamics, inverse_dynamics_batch};
pub use kinematics::forward_kinematics;
pub(crate) use real::sines_and_cosines;
pub use real::{LANES, Pack, Real};
pub use regressor::{ColumnSet, RowBlocks, regressor};
