//! Files to begin with, and schemas of files and documents.

use crate::FactsDocument;
use config::{
    LINEAR_TEMPLATE, MACHINE_TEMPLATE, ROTARY_TEMPLATE, effects_schema, floating_template, machine_schema,
};
use measurement::{MOTION_SET_TEMPLATE, SET_TEMPLATE, manifest_schema};
use schemars::{Schema, schema_for};

/// What a template describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Template {
    /// A ball-screw axis for FRFs or modes, both bearings fixed.
    FixedScrew,
    /// The same; its right bearing carries no axial load.
    FloatingScrew,
    /// A rigid linear axis for motion records.
    LinearMotion,
    /// A rigid rotary axis for motion records.
    RotaryMotion,
}

/// Returns name and text of a commented machine description and a measurement set to fill in.
pub fn templates(of: Template) -> Vec<(String, String)> {
    let (machine, set): (String, &[(&str, &str)]) = match of {
        Template::FixedScrew => (MACHINE_TEMPLATE.into(), &SET_TEMPLATE),
        Template::FloatingScrew => (floating_template(), &SET_TEMPLATE),
        Template::LinearMotion => (LINEAR_TEMPLATE.into(), &MOTION_SET_TEMPLATE),
        Template::RotaryMotion => (ROTARY_TEMPLATE.into(), &MOTION_SET_TEMPLATE),
    };
    let set = set.iter().map(|(name, text)| (format!("measurements/{name}"), text.to_string()));
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
