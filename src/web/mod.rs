//! What people look at: the pages that the binary serves, figures, and the report of an identification.
//!
//! Pages are plain HTML, ES modules and one style sheet, embedded in the program: no build step, no network. They use the HTTP
//! interface like any other client; nothing in them is privileged.

#[cfg(feature = "service")]
mod assets;
#[cfg(feature = "service")]
mod bibliography;
pub mod figures;
mod glossary;
#[cfg(feature = "service")]
mod pages;
mod report;

#[cfg(feature = "service")]
pub use pages::{PAGE_POLICY, missing_page, pages};
pub use report::{Circumstances, REPORT_POLICY, report};
