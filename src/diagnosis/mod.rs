//! Residual diagnosis: which physical effect explains what the model leaves.
//!
//! In order: data faults and mounting ([`sample_faults`], [`column_faults`], [`mounting()`]); what differs between the periods;
//! selection of effects and their alternatives; held-out data, which decide what stays in the model; the remainder; stability;
//! the report. [`diagnose`] runs them and says for every effect what it did to the error, on data that fitted the model and on
//! data that never touched it. The method is described in `docs/closing-the-loop.md`. All thresholds are in `settings`.

mod alternatives;
mod conclusion;
mod course;
mod data_quality;
mod declared_effects;
mod detectable;
mod golden_section;
mod held_out;
mod laws;
mod mounting;
mod next_design;
mod nonparametric;
mod options;
mod outcome;
mod pipeline;
mod recorded_filter;
mod replicates;
mod report;
mod search;
mod selection;
mod settings;
mod stability;
mod without_periods;

pub use alternatives::RivalTerm;
pub use data_quality::{
    DataFault, FaultKind, LostRows, RawLog, Remedy, column_faults, column_faults_until, leave_out, lost_rows, sample_faults,
};
pub use detectable::{Detectable, Hidden, Inseparable, Plan, Visible, detectable};
pub use mounting::{Gravity, Mounting, diagnose_mounted, mounting, mounting_until};
pub use next_design::{EffectColumns, information_over};
pub use options::DiagnosisOptions;
pub use outcome::{Diagnosis, Estimates};
pub use pipeline::diagnose;
pub use report::{
    AtRest, Change, Covered, Evaluated, Evidence, Finding, FindingHeldOut, HeldOut, HeldOutVerdict, JointFit, JointHeldOut,
    NotTested, Remainder, ReportedParameter, ResidualReport, Rival, RmsPair, Undetected, Verdict,
};
pub use report::{is_determined, reported_parameters};
pub use settings::*;
pub use stability::{Perturbation, Survival};
