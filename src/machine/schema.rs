//! JSON Schemas of types whose doc comments do not address authors of configuration files.

use schemars::Schema;

/// Reduces the schema of an enum to its allowed strings, without descriptions.
pub(crate) fn enum_without_descriptions(schema: &mut Schema) {
    schema.remove("description");
    let variants = schema.remove("oneOf");
    let variants = variants.iter().filter_map(|variants| variants.as_array()).flatten();
    let strings: Vec<_> = variants.filter_map(|variant| variant.get("const").cloned()).collect();
    schema.insert("type".into(), "string".into());
    schema.insert("enum".into(), strings.into());
}
