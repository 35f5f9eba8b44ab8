//! Files and documents on one side, domain types on the other.

pub mod log;
