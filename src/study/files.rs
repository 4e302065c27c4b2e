//! Files to begin with, and schemas of files and documents.

use crate::FactsDocument;
use config::{MACHINE_TEMPLATE, effects_schema, floating_template, machine_schema};
use measurement::{SET_TEMPLATE, manifest_schema};
use schemars::{Schema, schema_for};

/// Returns name and text of a commented machine description and an empty measurement set to fill in. The right
/// bearing may float: it carries no axial load then.
pub fn templates(floating: bool) -> Vec<(String, String)> {
    let machine = if floating { floating_template() } else { MACHINE_TEMPLATE.into() };
    let set = SET_TEMPLATE.map(|(name, text)| (format!("measurements/{name}"), text.to_string()));
    std::iter::once(("machine.toml".to_string(), machine)).chain(set).collect()
}

/// Returns the names of all files and documents that have a JSON Schema.
pub fn schema_names() -> Vec<&'static str> {
    let mut names = vec!["machine", "effects", "manifest"];
    names.extend(report::SCHEMAS);
    names.push("facts");
    names
}

/// Returns the JSON Schema of a file or document; `None` for an unknown name.
pub fn schema(name: &str) -> Option<Schema> {
    match name {
        "machine" => Some(machine_schema()),
        "effects" => Some(effects_schema()),
        "manifest" => Some(manifest_schema()),
        "facts" => Some(schema_for!(FactsDocument)),
        other => report::schema(other),
    }
}
