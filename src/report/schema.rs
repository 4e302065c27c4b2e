//! JSON Schemas of the result documents, made of the types that write them.

use schemars::{Schema, schema_for};

use super::{diagnosis, document, hybrid, loops, motion, simulation};

/// Names of the documents that have a schema: those of their files.
pub const SCHEMAS: [&str; 22] = [
    "identification",
    "validation",
    "comparison",
    "objectives",
    "peaks",
    "plan",
    "diagnosis",
    "frf",
    "modes",
    "matrices",
    "motion",
    "bode",
    "gain",
    "hold",
    "hybrid",
    "circle",
    "stiffness",
    "sensitivity",
    "friction",
    "published",
    "convergence",
    "stamp",
];

/// The schema of a document by name.
pub fn schema(name: &str) -> Option<Schema> {
    Some(match name {
        "identification" => schema_for!(document::Identification),
        "validation" => schema_for!(document::Validation),
        "comparison" => schema_for!(document::Comparison),
        "objectives" => schema_for!(document::Objectives),
        "peaks" => schema_for!(document::Peaks),
        "plan" => schema_for!(document::Plan),
        "diagnosis" => schema_for!(diagnosis::Diagnosis),
        "frf" => schema_for!(document::Frfs),
        "modes" => schema_for!(simulation::Modes),
        "matrices" => schema_for!(simulation::MatricesDocument),
        "motion" => schema_for!(motion::MotionDocument),
        "bode" => schema_for!(loops::Bode),
        "gain" => schema_for!(loops::GainStudy),
        "hold" => schema_for!(loops::HoldDocument),
        "circle" => schema_for!(loops::Circles),
        "hybrid" => schema_for!(hybrid::Hybrid),
        "stiffness" => schema_for!(simulation::Sweep),
        "sensitivity" => schema_for!(simulation::SensitivityDocument),
        "friction" => schema_for!(simulation::FrictionDocument),
        "published" => schema_for!(simulation::PublishedDocument),
        "convergence" => schema_for!(simulation::Convergence),
        "stamp" => schema_for!(document::Stamp),
        _ => return None,
    })
}
