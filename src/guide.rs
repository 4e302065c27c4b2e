//! Pages for users.

#[doc = include_str!("guide/published.md")]
pub mod published {}
