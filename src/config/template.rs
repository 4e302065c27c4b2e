//! The template of a machine configuration.

/// A commented `machine.toml`. Numbers that the user has to enter are `nan`, which the program rejects by
/// key.
pub const MACHINE_TEMPLATE: &str = include_str!("template/machine.toml");
