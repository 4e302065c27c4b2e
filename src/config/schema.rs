//! JSON Schemas of configuration files, made of the types that read them.

use schemars::{Schema, schema_for};

use super::file::{LibraryFile, MachineFile};

/// The schema of a machine configuration, its TOML read as JSON.
pub fn machine_schema() -> Schema {
    schema_for!(MachineFile)
}

/// The schema of an effect library.
pub fn effects_schema() -> Schema {
    schema_for!(LibraryFile)
}
