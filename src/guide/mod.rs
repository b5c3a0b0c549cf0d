//! Pages to read: a tour, what each format can carry, how to add a technique.

#[doc = include_str!("tour.md")]
pub mod tour {}

#[doc = include_str!("formats.md")]
pub mod formats {}

#[doc = include_str!("technique.md")]
pub mod technique {}
