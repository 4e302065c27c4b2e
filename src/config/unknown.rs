//! Messages about names that do not exist, with the one that was probably meant.

use machine::Effect;

/// Says that no effect has an id, which one was probably meant, and which there are.
pub fn unknown_effect(id: &str, effects: &[Effect]) -> String {
    let mut known: Vec<&str> = effects.iter().map(|e| e.id.as_str()).collect();
    known.sort_unstable();
    known.dedup();
    let meant = nearest(id, &known).map_or_else(String::new, |name| format!("did you mean «{name}»? "));
    format!("no effect is called «{id}»; {meant}there are {}", known.join(", "))
}

/// Returns the name that differs from a given one by the fewest letters, a third of them at most, or begins or
/// ends with it.
fn nearest<'n>(given: &str, names: &[&'n str]) -> Option<&'n str> {
    let given = given.trim().to_lowercase().replace('_', "-");
    let part = |name: &&str| given.len() >= 3 && (name.starts_with(&given) || name.ends_with(&given));
    let distance = |name: &str| (distance(&given, name), name.len());
    let close = names.iter().filter(|name| part(name) || 3 * distance(name).0 <= given.chars().count());
    close.min_by_key(|name| distance(name)).copied()
}

/// Number of letters to insert, remove or replace between two words.
///
/// # Source  Levenshtein, Soviet Physics Doklady 10 (1966) 707–710.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (at, x) in a.chars().enumerate() {
        let mut before = row[0];
        row[0] = at + 1;
        for (place, y) in b.iter().enumerate() {
            let replaced = before + usize::from(x != *y);
            before = row[place + 1];
            row[place + 1] = replaced.min(before + 1).min(row[place] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect_library;

    #[test]
    fn the_effect_that_was_meant_is_named() {
        let effects = effect_library().unwrap();
        for (given, meant) in [
            ("rotor-hol", "rotor-hold"),
            ("rotor_hold", "rotor-hold"),
            ("Table-Masses", "table-mass"),
            ("bed", "bed-compliance"),
            ("stribeck", "stribeck-friction"),
        ] {
            let text = unknown_effect(given, &effects);
            assert!(text.contains(&format!("did you mean «{meant}»?")), "{text}");
        }
        let text = unknown_effect("gearbox", &effects);
        assert!(
            !text.contains("did you mean") && text.contains("there are") && text.contains("backlash"),
            "{text}"
        );
    }
}
