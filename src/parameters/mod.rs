//! Which numbers describe the dynamics, what they are called, and which of them motion can tell apart.

mod base;
mod exact;
mod expression;
mod layout;

pub use base::{BaseParameters, NumericBase, numeric_base};
pub use expression::Expression;
pub use layout::{Inertial, Layout, Parameter, ParameterKind};
