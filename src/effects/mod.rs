//! Effects that move torque and that the declared model lacks, one file each.
//!
//! An effect is a block of columns per joint (or per robot) with, perhaps, shape parameters: `tau += C(motion; shape) c`, or a
//! distortion of what the regressor is evaluated at (an encoder offset, a tilted base, a late torque stream). [`all`] is the
//! list; one more effect is one more file and one more line there. How they are distinguished on data is the business of
//! [`diagnosis`](crate::diagnosis).

mod effect;
mod formula;
mod handle;
mod interpolation;
pub mod law;
pub mod own;
pub mod ranges;
mod statements;
mod unexplained;

pub use base_tilt::tilted;
pub use effect::{
    About, Column, Effect, EffectKind, Motions, ParameterInfo, PlotVariable, Reads, Scene, Shape, Span, Travel, World,
};
pub(crate) use effect::{own_joint, times_position_unit};
pub use formula::Formula;
pub use handle::AnyEffect;
pub use interpolation::{FEWEST, REACH};
pub use law::Law;
pub use own::{ChannelVariable, Definition, OwnEffect, ParameterDefinition, SourceNames};
pub use payload::consistent_payload;
pub use statements::{Statements, Written};
pub(crate) use unexplained::{Unexplained, products, variable, variable_name};

/// Declares the modules of the effects and [`all`], so that one more effect is one more line.
macro_rules! registry {
    ($($module:ident::$effect:ident,)*) => {
        $(mod $module;)*

        /// Every effect that a search tries, in the order of the table in the documentation.
        pub fn all() -> &'static [&'static dyn Effect] {
            &[$(&$module::$effect),*]
        }
    };
}

registry! {
    torque_offset::TorqueOffset,
    stribeck_friction::StribeckFriction,
    nonlinear_viscous_friction::NonlinearViscousFriction,
    asymmetric_viscous_friction::AsymmetricViscousFriction,
    load_dependent_friction::LoadDependentFriction,
    presliding_hysteresis::PreslidingHysteresis,
    smooth_coulomb_friction::SmoothCoulombFriction,
    rotor_inertia::RotorInertia,
    transmission_coupling::TransmissionCoupling,
    joint_spring::JointSpring,
    position_ripple::PositionRipple,
    joint_elasticity::JointElasticity,
    encoder_offset::EncoderOffset,
    base_tilt::BaseTilt,
    payload::Payload,
    torque_delay::TorqueDelay,
    torque_gain::TorqueGain,
    torque_crosstalk::TorqueCrosstalk,
    torque_saturation::TorqueSaturation,
    friction_drift::FrictionDrift,
    external_contact::ExternalContact,
}

/// The effect with this code: one of [`all`], or a [`Law`], which no search tries by name.
pub fn by_code(code: &str) -> Option<&'static dyn Effect> {
    let listed = all().iter().copied().find(|e| e.code() == code);
    listed.or_else(|| (Law.code() == code).then_some(&Law as &'static dyn Effect))
}

/// Whether a name is taken by the program: no own effect may have it.
pub(crate) fn is_reserved(name: &str) -> bool {
    by_code(name).is_some() || ["unexplained", "own_effect"].contains(&name)
}
