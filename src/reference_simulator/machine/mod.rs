//! Machines in numbers: what is built, what the engineer believes, and the ordinary differences between the two.

pub mod assembly;
pub mod catalogue;
pub mod description;
pub mod nuisance;
pub mod number;
pub mod point;
