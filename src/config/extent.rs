//! Limits on the extent of a description. Computations grow with it, so a description beyond them is refused.

use file_access::shortened;
use machine::MachineError;
use toml::{Table, Value};

use super::error::fault;

/// Largest numbers of entries by section.
const MOST: [(&str, usize); 10] = [
    ("point", 200),
    ("shaft", 50),
    ("joint", 300),
    ("parameter", 200),
    ("contact", 100),
    ("friction", 100),
    ("segment", 100),
    ("effect", 100),
    ("effects", 100),
    ("derived", 200),
];
/// Largest number of stations of a shaft.
const MOST_STATIONS: usize = 50;
/// Greatest length of a name, id or key (characters).
const LONGEST_NAME: usize = 100;
/// Greatest length of another text (characters).
const LONGEST_TEXT: usize = 2000;
/// Largest whole number: the greatest number of tandem rows, pole pairs, turns and the like is far below.
const LARGEST_WHOLE: f64 = 1e15;

/// Checks the numbers of entries and the lengths of names and texts.
///
/// # Errors  one of them is above its limit.
pub(super) fn check_extent(table: &Table) -> Result<(), MachineError> {
    let count = |value: &Value| {
        value.as_array().map(Vec::len).or_else(|| value.as_table().map(Table::len)).unwrap_or(0)
    };
    for (key, most) in MOST {
        let found = table.get(key).map_or(0, count);
        if found > most {
            return Err(fault(key, format!("has {found} entries; at most {most} are handled")));
        }
    }
    for shaft in table.get("shaft").and_then(Value::as_array).into_iter().flatten() {
        let found = shaft.get("station").map_or(0, count);
        if found > MOST_STATIONS {
            return Err(fault(
                "shaft.station",
                format!("has {found} entries; at most {MOST_STATIONS} are handled"),
            ));
        }
    }
    table.iter().try_for_each(|(key, value)| check_texts(key, value))
}

fn check_texts(key: &str, value: &Value) -> Result<(), MachineError> {
    check_length("a key", key, LONGEST_NAME)?;
    match value {
        Value::String(text) if ["name", "id"].contains(&key) && text.contains(['\n', '\r']) => {
            Err(fault(key, format!("«{}» has a line break; write names in one line", shortened(text, 40))))
        }
        Value::String(text) if ["name", "id"].contains(&key) => check_length(key, text, LONGEST_NAME),
        Value::String(text) => check_length(key, text, LONGEST_TEXT),
        Value::Integer(whole) if !((*whole as f64).abs() <= LARGEST_WHOLE) => Err(fault(
            key,
            format!(
                "is {whole}; write a number of at most {LARGEST_WHOLE:e}, with a decimal point if it is none of entries"
            ),
        )),
        Value::Table(table) => table.iter().try_for_each(|(key, value)| check_texts(key, value)),
        Value::Array(list) => list.iter().try_for_each(|value| check_texts(key, value)),
        _ => Ok(()),
    }
}

fn check_length(key: &str, text: &str, most: usize) -> Result<(), MachineError> {
    match text.chars().count() {
        length if length > most => Err(fault(
            key,
            format!("«{}» has {length} characters; at most {most} are handled", shortened(text, 20)),
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use crate::read_machine_text;
    use std::time::{Duration, Instant};

    fn refusal(text: &str) -> String {
        let begun = Instant::now();
        let message = read_machine_text("m.toml", text, &[], &[])
            .map(|_| "accepted".to_string())
            .unwrap_or_else(|e| e.to_string());
        assert!(begun.elapsed() < Duration::from_secs(20), "{message}");
        message
    }

    #[test]
    fn descriptions_beyond_the_limits_are_refused_at_once() {
        let point =
            |at: usize| format!("[[point]]\nname = \"p{at}\"\nmotion = \"translation\"\nmass_kg = 1.0\n");
        let points = (0..20_000).map(point).collect::<String>();
        assert!(
            refusal(&format!("title = \"t\"\n{points}")).contains("point: has 20000 entries; at most 200")
        );
        let name = "n".repeat(5000);
        let long =
            format!("title = \"t\"\n[[point]]\nname = \"{name}\"\nmotion = \"translation\"\nmass_kg = 1.0\n");
        let message = refusal(&long);
        assert!(message.contains("has 5000 characters") && message.len() < 200, "{message}");
        let parameter =
            |at: usize| format!("[parameter.q{at}]\nunit = \"N/m\"\nstart = 1e6\nlower = 1e5\nupper = 1e7\n");
        let parameters = (0..3000).map(parameter).collect::<String>();
        assert!(
            refusal(&format!("title = \"t\"\n{}{parameters}", point(0)))
                .contains("parameter: has 3000 entries")
        );
    }
}
