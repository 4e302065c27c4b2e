//! How much of the gap the model that a diagnosis of motions chose closes on what the held-out records would read without noise.

use std::collections::BTreeMap;
use std::path::Path;

use crate::arguments::Sources;
use crate::delivery::told;
use crate::motion_records::make_ready;
use crate::sources::load;
use diagnosis::motion::{MotionPart, gap_of, part};
use dynamics::inverse_dynamics::{Motion, Recipe, leave_crossings_out};
use machine::Machine;
use measurement::{MotionRecord, read_set};
use withheld::{CASES, Diagnosis, QUIET};

/// 1 − after²/before², the channels weighed as in the diagnosis; absent where its document does not say at which values of the parameters, or nothing
/// is left before.
///
/// # Errors  a file of the case does not read.
pub fn closed(folder: &Path, case: &str, of: &Diagnosis) -> Result<Option<f64>, String> {
    let path = |whole: &str| folder.join(whole).join(case).to_string_lossy().into_owned();
    let config = format!("{}/machine.toml", path(CASES));
    let loaded = load(&Sources { config, measurements: path(QUIET), set: of.overrides.clone(), without: of.without.clone() })?;
    let noisy = read_set(&path(CASES)).map_err(told)?;
    let made = |quiet: &MotionRecord| -> Result<Motion, String> {
        // An exact encoder shows an axis that settles creep for long: what counts as rest is what the noisy one shows.
        let motion = |record: &MotionRecord| Motion::new(record, Recipe::usual(record.step_s)).map_err(told);
        let same = noisy.motions.iter().find(|record| record.name == quiet.name);
        let same = same.ok_or_else(|| format!("{}: no record is called {}", path(CASES), quiet.name))?;
        motion(quiet)?.resting_as(&motion(same)?, quiet).map_err(told)
    };
    let made: Result<Vec<Motion>, String> = loaded.set.motions.iter().map(made).collect();
    let (motions, rigid, _) = make_ready(&loaded, made?)?;
    let mut motions: Vec<Motion> = motions.into_iter().map(Motion::without_edges).collect();
    motions.iter_mut().for_each(|motion| motion.weigh(&of.weights()));
    let described = &loaded.config.machine;
    if let Some(values) = described.values_of(&of.described) {
        leave_crossings_out(&mut motions, &rigid, described, &values);
    }
    let gap = |machine: &Machine, values: &BTreeMap<String, f64>| {
        let values = machine.values_of(values)?;
        gap_of(&motions.iter().map(|motion| part(&rigid, machine, &values, motion)).collect::<Vec<MotionPart>>())
    };
    let before = gap(described, &of.described).filter(|before| *before > 0.0);
    let after = described.with_chosen(&of.chosen.id, &loaded.config.effects).and_then(|machine| gap(&machine, &of.chosen.parameters));
    Ok(before.zip(after).map(|(before, after)| 1.0 - (after / before).powi(2)))
}
