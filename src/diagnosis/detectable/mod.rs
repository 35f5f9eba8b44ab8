//! What a planned recording would reveal: the smallest size of every effect that the diagnosis finds, and what it cannot tell
//! apart.
//!
//! Nothing is simulated. An effect of size s on a place adds `s C e` to the torque, C its columns along the planned motion at a
//! nominal shape, e the direction that its size is counted along. Rows are whitened by the noise of the mean over the periods.
//! What the base parameters cannot imitate is left of it,
//!
//! ```text
//! λ(s) = s² eᵀ (CᵀC − CᵀJ (JᵀJ)⁺ JᵀC) e,
//! ```
//!
//! and the gain of a candidate R of the search is χ² with as many degrees of freedom as it has parameters (rank and shapes) and
//! the noncentrality `ρ² λ`, ρ the correlation of the effect with the columns of R, both orthogonal to J. The search accepts R
//! where its gain passes the larger of two thresholds: of its evidence (`cost ln N + 2 ln tried`), and of chance (χ² at the
//! false-alarm level over the number of hypotheses). The size reported is the least with which any candidate that would be
//! physical passes with the power asked for, and predicts folds of time left out ([`generalisation`]): the diagnosis then says
//! that something is there. What it is called is a question of its own (`pairs`): two effects are separated from the size on at
//! which the BIC difference excludes the other one with the same power.

mod assess;
mod between;
mod gains;
mod generalisation;
mod pairs;
mod physical;
mod plan;
mod planned;
mod power;
mod signals;
mod sizes;
#[cfg(test)]
mod tests;

pub use assess::{Detectable, detectable};
pub use pairs::Inseparable;
pub use plan::Plan;
pub use sizes::{Hidden, Visible};
