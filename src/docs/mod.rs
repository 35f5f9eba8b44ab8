//! Pages that explain what the code does.

#[doc = include_str!("notation.md")]
pub mod notation {}

#[doc = include_str!("method.md")]
pub mod method {}

#[doc = include_str!("closing-the-loop.md")]
pub mod closing_the_loop {}

#[doc = include_str!("worked-example.md")]
pub mod worked_example {}

#[doc = include_str!("own-effects.md")]
pub mod own_effects {}

#[doc = include_str!("validation.md")]
pub mod validation {}

#[doc = include_str!("formats.md")]
pub mod formats {}

#[doc = include_str!("service.md")]
pub mod service {}

#[doc = include_str!("performance.md")]
pub mod performance {}

#[doc = include_str!("bibliography.md")]
pub mod bibliography {}
