//! What the model leaves over, and the physical effect it comes from.
//!
//! Seven steps: data faults first ([`sample_faults`], [`column_faults`]); the noise floor from the scatter of the periods ([`NoiseModel`]); lack of fit;
//! candidates after the base regressor is projected out; forward and backward selection; rivals; the remainder. [`trace`] runs them
//! and says for every effect added what it did to the error, on data that fitted the model and on data that never touched it. The
//! method is told in `docs/closing-the-loop.md`.

mod appraise;
mod between;
mod border;
mod candidate;
mod coarse;
mod confirm;
mod contact;
mod crossval;
mod declared;
mod dependence;
mod design;
mod deviations;
mod distortion;
mod drift;
mod estimate;
mod evaluation;
mod family;
mod faults;
mod findings;
mod fit;
mod function;
mod gravity;
mod held_out;
mod jackknife;
mod judge;
mod levels;
mod misfit;
mod model;
mod noise;
mod perturbation;
mod price;
mod product;
mod projection;
mod remainder;
mod report;
mod rivals;
mod robust;
mod scan;
mod select;
mod store;
mod stretch;
mod system;
mod trace;
mod trend;
mod undetected;
mod unsteady;
mod without_periods;

pub use border::RivalTerm;
pub use design::{EffectColumns, information_over};
pub use estimate::Fitted;
pub use faults::{
    DataFault, FaultKind, LostRows, RawLog, Remedy, column_faults, column_faults_until, leave_out, lost_rows, sample_faults,
};
pub use gravity::{Gravity, Mounting, OTHER_MOUNTING, mounting, mounting_until, trace_mounted};
pub use misfit::PredictionErrors;
pub(crate) use model::reported;
pub use model::{AugmentedModel, Term};
pub use noise::{NoiseModel, NoiseSource};
pub use perturbation::{Perturbation, Survival};
pub(crate) use report::of_deviation;
pub use report::{
    AtRest, Change, Estimates, Evaluated, Evidence, Finding, FindingHeldOut, HeldOut, HeldOutVerdict, JointFit, JointHeldOut,
    NotTested, Outcome, Remainder, ReportedParameter, ResidualReport, Rival, RmsPair, Undetected, Verdict,
};
pub use stretch::{Stretch, Unfiltered};
pub use system::Prior;

pub use trace::{TraceOptions, Traced, trace};
