//! Identification of the dynamics of serial robot arms.
//!
//! The equations of motion of an arm are linear in its parameters,
//!
//! ```text
//! tau = Y(q, qd, qdd) phi = Y_b(q, qd, qdd) pi_b,     pi_b = K phi
//! ```
//!
//! with the standard parameters `phi` (mass, first moments, inertia, friction of every link) and the smaller set `pi_b` of base
//! parameters that motion can tell apart. To measure `pi_b` the arm moves along a periodic trajectory whose stacked regressor is
//! well conditioned: of all finite Fourier series
//!
//! ```text
//! q_i(t) = offset_i + Σ_l a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)
//! ```
//!
//! that start and end at rest and stay within every limit, [`excitation::search`] looks for the one with the least
//! `cond(Y_b) = σ_max/σ_min`, or another criterion. The method and the notation are described in [`docs`].
//!
//! | module | holds |
//! |---|---|
//! | [`spatial`], [`model`] | transforms and inertia; the robot: modified DH or URDF, limits, declared friction |
//! | [`parameters`], [`dynamics`] | names and base parameters; inverse dynamics, regressor and adjoint, batched over samples |
//! | [`trajectory`], [`excitation`] | Fourier series and others; the problem, the search, its result |
//! | [`preparation`], [`regression`] | from measured logs to rows; weighted least squares of a model with or without effects, and its covariance |
//! | [`identification`] | physically consistent bodies from base parameters; whether a log was good enough |
//! | [`solver`] | NLopt, behind two functions |
//! | [`effects`], [`diagnosis`], [`simulate`] | what a rigid model lacks, how it is found in the residual, a virtual robot to try it on |
//! | [`documents`], [`formats`], [`app`] | documents to and from these; use cases with progress, cancellation and stable error codes |
//! | `service`, `cli` | the same over HTTP and on the command line (features of the same names, on by default) |
//!
//! # A first trajectory
//!
//! ```
//! use dynident::excitation::{Control, Halt, Knowledge, Problem, ProblemSpec, Progress, SearchOptions, search};
//! use dynident::excitation::{Criterion, Form, Start};
//! use dynident::documents::{NamedRobots, shipped::Shipped};
//!
//! /// Never ends the search and looks at nothing.
//! struct Alone;
//! impl Control for Alone {
//!     fn halt(&self) -> Option<Halt> {
//!         None
//!     }
//!     fn progress(&self, _: &Progress) {}
//! }
//!
//! let robot = Shipped.named("planar_two_link").unwrap().robot;
//! let problem = Problem::new(ProblemSpec {
//!     robot,
//!     order: 3,
//!     fundamental_hz: 0.2,
//!     sample_rate_hz: 50.0,
//!     criterion: Criterion::ConditionNumber,
//!     form: Form::Paper,
//!     start: Start::Zero,
//!     start_position: None,
//!     torque_noise: None,
//!     torque: None,
//!     space: None,
//!     harmonics: None,
//!     knowledge: Knowledge::default(),
//! })?;
//! let options = SearchOptions { max_evaluations: Some(500), ..SearchOptions::default() };
//! let design = search(&problem, &options, &Alone);
//! // Every limit is met between the samples too.
//! assert!(design.margins.iter().all(|m| m.margin >= 0.0));
//! assert!(design.criteria.unwrap().condition_number < 60.0);
//! # Ok::<(), dynident::model::ModelError>(())
//! ```

#![warn(missing_docs)]

#[doc(inline)]
pub use dynident_core::{
    cancel, diagnosis, dynamics, effects, excitation, identification, model, parameters, preparation, regression, simulate,
    solver, spatial, trajectory,
};
#[doc(inline)]
pub use dynident_io::{app, documents, formats};

#[cfg(feature = "cli")]
pub mod cli;
pub mod docs;
#[cfg(feature = "service")]
pub mod service;
#[cfg(feature = "figures")]
pub mod web;
