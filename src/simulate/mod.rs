//! A virtual robot that makes logs: any arm, any trajectory, any of the effects, noise, and faults of the record.
//!
//! Simulation and identification of an effect share no code: here states are integrated in time, delays shift time, elastic
//! joints are solved for the link's motion, so that agreement with the columns of [`effects`](crate::effects) means something.
//! [`ListedEffect`] is the exception.

mod elastic;
mod experiment;
mod fault;
mod friction;
mod hidden;
mod listed;
mod noise;
mod torque;

pub use experiment::{Experiment, RecordedLog, simulate};
pub use fault::{LogFault, corrupt};
pub use hidden::HiddenEffect;
pub use listed::ListedEffect;
pub use noise::Noise;
