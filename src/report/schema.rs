//! JSON Schemas of the result documents, generated from their types.

use schemars::{Schema, schema_for};

use super::{change, diagnosis, document, effects, loops, motion, prediction, simulation};

/// Name of a document, as in its file name, and the function that generates its schema.
type Document = (&'static str, fn() -> Schema);

const DOCUMENTS: [Document; 18] = [
    ("identification", || schema_for!(document::IdentificationDocument)),
    ("validation", || schema_for!(document::ValidationDocument)),
    ("comparison", || schema_for!(document::ComparisonDocument)),
    ("objectives", || schema_for!(document::ObjectivesDocument)),
    ("peaks", || schema_for!(document::PeaksDocument)),
    ("plan", || schema_for!(document::PlanDocument)),
    ("change", || schema_for!(change::ChangeDocument)),
    ("prediction", || schema_for!(prediction::PredictionDocument)),
    ("diagnosis", || schema_for!(diagnosis::DiagnosisDocument)),
    ("frf", || schema_for!(document::FrfsDocument)),
    ("modes", || schema_for!(simulation::ModesDocument)),
    ("motion", || schema_for!(motion::MotionDocument)),
    ("bode", || schema_for!(loops::BodeDocument)),
    ("hold", || schema_for!(loops::HoldDocument)),
    ("stiffness", || schema_for!(simulation::SweepDocument)),
    ("friction", || schema_for!(simulation::FrictionDocument)),
    ("effect-library", || schema_for!(effects::EffectLibraryDocument)),
    ("stamp", || schema_for!(document::Stamp)),
];

/// Names of the documents that have a schema, as in their file names.
pub const SCHEMAS: [&str; DOCUMENTS.len()] = {
    let mut names = [""; DOCUMENTS.len()];
    let mut at = 0;
    while at < names.len() {
        names[at] = DOCUMENTS[at].0;
        at += 1;
    }
    names
};

/// Returns the schema of a document by name.
pub fn schema(name: &str) -> Option<Schema> {
    DOCUMENTS.iter().find(|(of, _)| *of == name).map(|(_, make)| make())
}
