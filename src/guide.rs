//! Pages for users.

#[doc = include_str!("guide/own-machine.md")]
pub mod own_machine {}

#[doc = include_str!("guide/published.md")]
pub mod published {}
