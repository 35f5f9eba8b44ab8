//! What differs between the periods of a log: friction that drifts, contacts, and torque that is not the same all through. The
//! average hides all three.

mod channel;
mod contact;
mod deviations;
mod drift;
mod instability;
mod level;
mod level_search;
mod period_finding;
mod separation;
mod trend;

pub(crate) use channel::Following;
pub(crate) use instability::{joined, remainder_of};
pub(crate) use period_finding::BetweenFinding;
pub(crate) use separation::{Separated, separate};
pub(crate) use trend::trends;
