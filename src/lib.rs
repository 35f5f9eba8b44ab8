//! dynident
pub mod spatial;
pub mod model;
pub mod parameters;
pub mod dynamics;
pub mod trajectory;
pub mod excitation;
pub mod identification;
pub mod io;
// Links the library that the semidefinite solver calls.
use openblas_src as _;
