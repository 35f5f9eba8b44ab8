//! The search for effects where the noise is not measured: logs without periods.
//!
//! All that the model leaves may be misfit there, and everything smooth explains a part of it. So effects are judged by blocks of
//! time that the fit has not seen: first what every robot may have, on all joints at once, then single effects, each by its gain
//! on the blocks left out, by the scatter of that gain, by the joint that pays for it, and by whether it is chosen again from
//! other selections of blocks. All of it is linear algebra on normal equations, block by block; only what is accepted is fitted
//! to all rows.

mod blocks;
mod contender;
mod families;
mod field;
mod motion_functions;
mod nuisance;
mod passing;
mod remainder;
mod rivals;
mod search;
mod settle;
mod stability;
mod validation;

pub(crate) use remainder::examine;
pub(crate) use rivals::linear_contests;
pub(crate) use search::extend;
