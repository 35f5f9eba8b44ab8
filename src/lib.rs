//! dynident
pub mod spatial;
pub mod model;
pub mod parameters;
pub mod dynamics;
pub mod trajectory;
pub mod excitation;
pub mod effects;
pub mod residual;
pub mod simulate;
pub mod identification;
pub mod io;
