//! The file formats of machine configurations and of the effect library; nothing else knows them.

mod contact;
mod embedded;
mod error;
mod extent;
mod file;
mod fitted;
mod identified;
mod plausibility;
mod read;
mod rescale;
mod schema;
mod servo;
mod template;
#[cfg(test)]
mod tests;
mod unit;
mod unknown;

pub use embedded::{BENCH, embedded_config};
pub use error::ConfigError;
pub use identified::{Found, machine_as_found};
pub use read::{MachineConfig, Overrides, effect_library, read_machine, read_machine_text};
pub use schema::{effects_schema, machine_schema};
pub use template::{LINEAR_TEMPLATE, MACHINE_TEMPLATE, ROTARY_TEMPLATE, floating_template};
pub use unknown::unknown_effect;
