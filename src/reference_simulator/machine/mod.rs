//! Machines as numbers: the built machine, the engineer's description, and the tolerances between the two.

pub mod assembly;
pub mod catalogue;
pub mod description;
pub mod layout;
pub mod leeway;
pub mod nuisance;
pub mod number;
pub mod point;
