//! The beginning of a configuration, to be filled in.

/// A commented `machine.toml`: what the user must say is `nan` there, which the program refuses by name.
pub const MACHINE_TEMPLATE: &str = include_str!("template/machine.toml");
