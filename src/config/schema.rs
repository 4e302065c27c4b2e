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

#[cfg(test)]
mod tests {
    use super::{effects_schema, machine_schema};
    use machine::{Mechanism, Number};
    use serde_json::Value;

    /// Sections whose numbers are not those of a machine: parameters, their tolerances and derived
    /// quantities.
    const OTHER_SECTIONS: [&str; 8] = [
        "ParameterFile",
        "PriorFile",
        "ToleranceFile",
        "DerivedFile",
        "FittedFile",
        "KnownFile",
        "Number",
        "SeriesNumber",
    ];

    /// Whether a property takes a number, or a list of numbers.
    fn is_numeric(schema: &Value) -> bool {
        let is_number = |kind: &Value| ["number", "integer"].iter().any(|number| kind == number);
        let own = schema.get("type").is_some_and(|kind| {
            is_number(kind) || kind.as_array().is_some_and(|kinds| kinds.iter().any(is_number))
        });
        let refers = schema
            .get("$ref")
            .and_then(Value::as_str)
            .is_some_and(|name| name.ends_with("/Number") || name.ends_with("/ConformityFile"));
        let below = ["anyOf", "items", "prefixItems"].iter().filter_map(|key| schema.get(key));
        own || refers
            || below
                .flat_map(|list| list.as_array().cloned().unwrap_or_else(|| vec![list.clone()]))
                .any(|schema| is_numeric(&schema))
    }

    fn numeric_keys(schema: &Value, found: &mut Vec<(String, String)>) {
        let sections = schema["$defs"]
            .as_object()
            .unwrap()
            .iter()
            .filter(|(name, _)| !OTHER_SECTIONS.contains(&name.as_str()));
        for (name, section) in sections.chain([(&"machine".to_string(), schema)]) {
            let properties = section.get("properties").and_then(Value::as_object).into_iter().flatten();
            found.extend(
                properties
                    .filter(|(_, schema)| is_numeric(schema))
                    .map(|(key, _)| (name.clone(), key.clone())),
            );
        }
    }

    #[test]
    fn every_number_of_a_description_stands_in_the_table() {
        let mut keys = Vec::new();
        numeric_keys(machine_schema().as_value(), &mut keys);
        numeric_keys(effects_schema().as_value(), &mut keys);
        assert!(keys.len() > 90 && keys.contains(&("WaveFile".into(), "period".into())), "{keys:?}");
        for (section, key) in keys {
            assert!(
                Number::quantity_of(&key).is_some(),
                "{section}.{key} has no row in the table of numbers"
            );
        }
    }

    #[test]
    fn numbers_of_one_key_have_one_magnitude_and_known_units() {
        let own = |number: &Number| number.key.rsplit('.').next().unwrap();
        for number in Number::all() {
            let first = Number::quantity_of(own(number)).unwrap();
            assert_eq!(first.magnitude, number.quantity.magnitude, "{}", number.key);
            let units = number.quantity.mechanism.units();
            assert!(number.quantity.mechanism != Mechanism::Other, "{}", number.key);
            assert!(
                units.iter().all(|unit| numeric::unit::parse_for(unit, |_| true).is_ok()),
                "{}: {units:?}",
                number.key
            );
        }
    }
}
