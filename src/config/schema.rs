//! JSON Schemas of configuration files, generated from the types that read them.

use schemars::{Schema, schema_for};

use super::file::{LibraryFile, MachineFile};

/// Returns the schema of a machine configuration, with its TOML read as JSON.
pub fn machine_schema() -> Schema {
    schema_for!(MachineFile)
}

/// Returns the schema of an effect library.
pub fn effects_schema() -> Schema {
    schema_for!(LibraryFile)
}
