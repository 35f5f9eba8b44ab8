//! Finding what a model lacks, on virtual robots.

// Without the service, whose build the tests would wait for.
extern crate dynident_io as dynident;

mod augmented;
mod bench;
mod columns;
mod detectable;
mod false_alarms;
mod faults;
mod findings;
mod laws;
mod measured;
mod mountings;
mod one_model;
mod own;
mod position_noise;
mod recorded_filter;
mod rivals;
mod same_joint;
mod unsteady;
mod without_periods;
