//! JSON Schemas of types whose doc comments are not written for those who write files.

use schemars::Schema;

/// Leaves the words of a choice alone, without descriptions.
pub(crate) fn words_alone(schema: &mut Schema) {
    schema.remove("description");
    let variants = schema.remove("oneOf");
    let variants = variants.iter().filter_map(|variants| variants.as_array()).flatten();
    let words: Vec<_> = variants.filter_map(|variant| variant.get("const").cloned()).collect();
    schema.insert("type".into(), "string".into());
    schema.insert("enum".into(), words.into());
}
