//! Numbers of a TOML file: those left open, and those beyond physics.

use toml::{Table, Value};

/// Largest magnitude of a number in SI units that is accepted.
pub const LARGEST_NUMBER: f64 = 1e30;
/// Smallest magnitude of a number in SI units that is accepted, apart from 0.
pub const SMALLEST_NUMBER: f64 = 1e-30;

/// Whether a number can be that of a machine or measurement in SI units. Beyond these magnitudes products
/// overflow.
pub fn is_physical(x: f64) -> bool {
    x == 0.0 || (SMALLEST_NUMBER..=LARGEST_NUMBER).contains(&x.abs())
}

/// Returns the keys whose number is `nan`, as a template leaves it, in the order of the table.
pub fn unfilled(table: &Table) -> Vec<String> {
    let mut found = Vec::new();
    table.iter().for_each(|(key, value)| walk(value, key, &mut found));
    found
}

fn walk(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Float(x) if x.is_nan() => found.push(path.into()),
        Value::Table(table) => {
            table.iter().for_each(|(key, value)| walk(value, &format!("{path}.{key}"), found))
        }
        Value::Array(list) => list.iter().enumerate().for_each(|(at, value)| {
            let name = ["name", "id"].iter().find_map(|key| value.get(key)?.as_str());
            walk(value, &format!("{path}.{}", name.map_or_else(|| at.to_string(), str::to_string)), found);
        }),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_open_numbers_are_found() {
        let table: Table =
            "a = nan\n[[point]]\nname = \"t\"\nmass_kg = nan\n[b.c]\nx = [1.0, nan]\ny = 1".parse().unwrap();
        assert_eq!(unfilled(&table), ["a", "b.c.x.1", "point.t.mass_kg"]);
        assert!(
            is_physical(0.0)
                && is_physical(-1e30)
                && !is_physical(1e308)
                && !is_physical(5e-324)
                && !is_physical(f64::NAN)
        );
    }
}
