//! Provenance of result documents: program, seed, inputs, warnings, and the machine's description.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An input file of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Input {
    /// Path of the file; name of a file that is embedded in the program.
    pub path: String,
    /// SHA-256 digest of the file (hexadecimal).
    pub sha256: String,
}

/// Description of the machine of a result, so that the result can be used without its files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MachineText {
    /// Path of the file; name of a description that is embedded in the program.
    pub path: String,
    /// Text of the file (TOML), to be read with the overrides and without the removed effects that the
    /// document states.
    pub text: String,
}

/// Provenance common to all result documents.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stamp {
    /// Name and version of the document schema, such as `jointid/identification/1`.
    pub schema: String,
    /// Version of the program that wrote the document.
    pub tool_version: String,
    /// Seed of the random number generator; 0 for results without random numbers.
    pub seed: u64,
    /// Whether the run completed; otherwise the results are partial.
    pub complete: bool,
    /// Input files.
    pub inputs: Vec<Input>,
    /// Overrides of the machine configuration, each as `KEY=VALUE`.
    #[serde(default)]
    pub overrides: Vec<String>,
    /// Effects removed from the machine description before fitting, by id.
    #[serde(default)]
    pub without: Vec<String>,
    /// Warnings about inputs and results, one sentence each.
    pub warnings: Vec<String>,
}
