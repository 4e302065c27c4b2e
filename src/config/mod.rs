//! The file formats of machine configurations and of the effect library; nothing else knows them.

mod contact;
mod embedded;
mod error;
mod file;
mod number;
mod read;

pub use embedded::{BENCH, embedded_config};
pub use error::ConfigError;
pub use read::{MachineConfig, Overrides, effect_library, read_machine, read_machine_text};
