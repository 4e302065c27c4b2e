//! JSON Schemas of the result documents, generated from their types.

use schemars::{Schema, schema_for};

use super::{convergence, matrices, published, sensitivity};
use crate::withheld::WithheldDocument;
use report::{hybrid, loops};

/// Names of the documents that have a schema, as in their file names.
pub const SCHEMAS: [&str; 8] =
    ["matrices", "sensitivity", "gain", "circle", "hybrid", "convergence", "published", "withheld"];

/// Returns the schema of a document by name.
pub fn schema(name: &str) -> Option<Schema> {
    Some(match name {
        "matrices" => schema_for!(matrices::MatricesDocument),
        "sensitivity" => schema_for!(sensitivity::SensitivityDocument),
        "gain" => schema_for!(loops::GainStudyDocument),
        "circle" => schema_for!(loops::CirclesDocument),
        "hybrid" => schema_for!(hybrid::HybridDocument),
        "convergence" => schema_for!(convergence::ConvergenceDocument),
        "published" => schema_for!(published::PublishedDocument),
        "withheld" => schema_for!(WithheldDocument),
        _ => return None,
    })
}
