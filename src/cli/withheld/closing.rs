//! How much of the gap the model that a diagnosis of motions chose closes on what the held-out records would read without noise.

use std::collections::BTreeMap;
use std::path::Path;

use crate::arguments::Sources;
use crate::motion_records::make_ready;
use crate::outcome::to_message;
use crate::sources::load;
use diagnosis::motion::{MotionPart, gap_of, part};
use dynamics::inverse_dynamics::{MotionSignal, Preprocessing, mask_backlash_crossings};
use machine::Machine;
use measurement::{MotionRecord, read_set};
use withheld::{CASES, DiagnosisAnswer, QUIET};

/// 1 − after²/before², the channels weighed as in the diagnosis; absent where its document does not say at which values of the parameters, or nothing
/// is left before.
///
/// # Errors  a file of the case does not read.
pub fn closed(folder: &Path, case: &str, of: &DiagnosisAnswer) -> Result<Option<f64>, String> {
    let path = |whole: &str| folder.join(whole).join(case).to_string_lossy().into_owned();
    let config = format!("{}/machine.toml", path(CASES));
    let loaded = load(&Sources { config, measurements: path(QUIET), set: of.overrides.clone(), without: of.without.clone() })?;
    let noisy = read_set(&path(CASES)).map_err(to_message)?;
    let made = |quiet: &MotionRecord| -> Result<MotionSignal, String> {
        // An exact encoder shows an axis that settles creep for long: what counts as rest is what the noisy one shows.
        let motion = |record: &MotionRecord| MotionSignal::new(record, Preprocessing::usual(record.step_s)).map_err(to_message);
        let same = noisy.motions.iter().find(|record| record.name == quiet.name);
        let same = same.ok_or_else(|| format!("{}: no record is called {}", path(CASES), quiet.name))?;
        motion(quiet)?.resting_as(&motion(same)?, quiet).map_err(to_message)
    };
    let made: Result<Vec<MotionSignal>, String> = loaded.set.motions.iter().map(made).collect();
    let (motions, rigid, _) = make_ready(&loaded, made?)?;
    let mut motions: Vec<MotionSignal> = motions.into_iter().map(MotionSignal::without_edges).collect();
    motions.iter_mut().for_each(|motion| motion.weigh(&of.weights()));
    let described = &loaded.config.machine;
    if let Some(values) = described.values_of(&of.described) {
        mask_backlash_crossings(&mut motions, &rigid, described, &values);
    }
    let gap = |machine: &Machine, values: &BTreeMap<String, f64>| {
        let values = machine.values_of(values)?;
        gap_of(&motions.iter().map(|motion| part(&rigid, machine, &values, motion)).collect::<Vec<MotionPart>>())
    };
    let before = gap(described, &of.described).filter(|before| *before > 0.0);
    let after = described.with_chosen(&of.chosen.id, &loaded.config.effects).and_then(|machine| gap(&machine, &of.chosen.parameters));
    Ok(before.zip(after).map(|(before, after)| 1.0 - (after / before).powi(2)))
}
