//! Finding what a model lacks, on virtual robots.

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
mod recorded_filter;
mod rivals;
mod unsteady;
mod without_periods;
