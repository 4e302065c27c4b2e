//! The user's guide, in the order of the work.

#[doc = include_str!("own-machine.md")]
pub mod own_machine {}

#[doc = include_str!("verdicts.md")]
pub mod verdicts {}

#[doc = include_str!("own-effect.md")]
pub mod own_effect {}

#[doc = include_str!("mistakes.md")]
pub mod mistakes {}

#[doc = include_str!("published.md")]
pub mod published {}
