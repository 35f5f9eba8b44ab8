//! dynident
pub mod dynamics;
pub mod excitation;
pub mod model;
pub mod parameters;
pub mod spatial;
pub mod trajectory;
