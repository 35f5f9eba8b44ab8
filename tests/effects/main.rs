//! Finding what a model lacks, on virtual robots.

mod bench;
mod faults;
mod findings;
