//! Effects as candidates of a diagnosis.

use super::arguments::DiagnoseArguments;
use machine::{Data, Effect};

/// The candidates asked for, of those with one id the one for this data.
pub fn choose_effects(given: &DiagnoseArguments, all: &[Effect], data: Data) -> Result<Vec<Effect>, String> {
    for (key, ids) in [("--effects", &given.effects), ("--exclude", &given.exclude)] {
        if let Some(id) = ids.iter().find(|id| !all.iter().any(|e| e.id == **id)) {
            let known: Vec<&str> = all.iter().map(|e| e.id.as_str()).collect();
            return Err(format!("{key}: no effect is called «{id}»; there are {}", known.join(", ")));
        }
    }
    let wanted = |e: &&Effect| (given.effects.is_empty() || given.effects.contains(&e.id)) && !given.exclude.contains(&e.id);
    Ok(Effect::asked_of(all, data).filter(wanted).cloned().collect())
}
