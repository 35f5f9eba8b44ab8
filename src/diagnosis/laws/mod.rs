//! Laws: formulas for what no listed effect explains.
//!
//! Where something is left on a joint, every form of a law on every place is scored beside the model; the best are refined and
//! fitted with everything else (`contest`), listed effects among them. One at a time they are added, exchanged and taken back
//! (`search`), under physics: what is called an energy must be one, and friction may not drive the arm (`physics`). What does not
//! leave the joint (nearly) clean is no law: the remainder is then described as before.

mod channel;
mod contest;
mod library;
mod physics;
mod rivals;
mod search;

pub(crate) use channel::channel_laws;
pub(crate) use rivals::law_contests;
pub(crate) use search::written;
