//! The `residual` part of an answer: findings, lack of fit, errors, and detection limits of what was not found.

mod detection_limits;
mod findings;
mod lack_of_fit;
mod parameter;
mod result;

pub(crate) use detection_limits::{nuisance, undetected};
pub use findings::reported_parameters;
pub(crate) use findings::{FindingInputs, between_findings, findings};
pub(crate) use lack_of_fit::{at_rest, fits, rms};
pub use parameter::ReportedParameter;
pub use parameter::is_determined;
pub(crate) use parameter::joint_names;
pub use result::{
    AtRest, Change, Covered, Evaluated, Evidence, Finding, FindingHeldOut, HeldOut, HeldOutVerdict, JointFit, JointHeldOut,
    NotTested, Remainder, ResidualReport, Rival, RmsPair, Undetected, Verdict,
};
