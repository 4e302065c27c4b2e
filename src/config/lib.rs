//! The file formats of machine configurations and of the effect library; nothing else knows them.

mod beginning;
mod contact;
mod embedded;
mod error;
mod file;
mod read;
mod rescale;
mod schema;
mod servo;
mod tolerance;

pub use beginning::MACHINE_BEGINNING;
pub use embedded::{BENCH, embedded_config};
pub use error::ConfigError;
pub use read::{MachineConfig, Overrides, effect_library, read_machine, read_machine_text};
pub use schema::{effects_schema, machine_schema};
