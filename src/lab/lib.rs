//! The laboratory: what examines the method, and what repeats the papers. `jointid lab …` runs its program,
//! `jointid-lab`.
//!
//! ```text
//! withheld     seals, answers and scores of the blind check
//! blind_check  cases made, sealed, diagnosed by the public command, and scored
//! hybrid       a model and a neural network trained on its residual
//! convergence  the lumped model over its number of masses
//! simulation   simulations of the papers
//! published    printed figures, compared with ours
//! document     result documents and their texts
//! command      the command line
//! ```

pub mod blind_check;
mod command;
pub mod convergence;
pub mod document;
pub mod hybrid;
pub mod published;
pub mod simulation;
pub mod withheld;

pub use command::run;
