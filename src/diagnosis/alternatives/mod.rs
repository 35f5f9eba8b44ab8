//! Could it be something else? Rivals of every effect, and what the data say between them.

mod border;
mod contest;
mod rivals;
mod swaps;

pub use border::RivalTerm;
pub(crate) use border::border;
pub(crate) use contest::Contest;
pub(crate) use rivals::{rivals, settled};
