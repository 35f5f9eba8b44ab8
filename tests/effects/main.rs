//! Finding what a model lacks, on virtual robots.

mod augmented;
mod bench;
mod columns;
mod faults;
mod findings;
mod measured;
mod mountings;
mod rivals;
mod unsteady;
