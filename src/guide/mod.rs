//! The user's guide: each page answers one question.
//!
//! Use: [own_machine], [own_frfs], [motion], [rotary], [python], [mistakes]. Results: [results], [prediction],
//! [verdicts], [own_effect]. Background: [models], [validation],
//! [speed], [published], [papers]. Source code: [crates].

#[doc = include_str!("own-machine.md")]
pub mod own_machine {}

#[doc = include_str!("own-frfs.md")]
pub mod own_frfs {}

#[doc = include_str!("results.md")]
pub mod results {}

#[doc = include_str!("prediction.md")]
pub mod prediction {}

#[doc = include_str!("verdicts.md")]
pub mod verdicts {}

#[doc = include_str!("own-effect.md")]
pub mod own_effect {}

#[doc = include_str!("motion.md")]
pub mod motion {}

#[doc = include_str!("rotary.md")]
pub mod rotary {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("models.md")]
pub mod models {}

#[doc = include_str!("validation.md")]
pub mod validation {}

#[doc = include_str!("speed.md")]
pub mod speed {}

#[doc = include_str!("published.md")]
pub mod published {}

#[doc = include_str!("papers.md")]
pub mod papers {}

#[doc = include_str!("mistakes.md")]
pub mod mistakes {}

#[doc = include_str!("crates.md")]
pub mod crates {}
