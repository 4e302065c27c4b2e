//! Share of the gap that the chosen model of a motion diagnosis closes on the held-out records without noise.

use std::collections::BTreeMap;
use std::path::Path;

use crate::arguments::Sources;
use crate::motion_records::add_channels;
use crate::outcome::to_message;
use crate::sources::load;
use diagnosis::motion::{MotionPart, gap_of, part};
use dynamics::inverse_dynamics::{MotionSignal, Preprocessing, mask_backlash_crossings};
use machine::Machine;
use measurement::{MotionRecord, read_set};
use withheld::{CASES, DiagnosisAnswer, QUIET};

/// Computes the closed share 1 − after²/before² of the squared gap, with the channel weights of the diagnosis.
///
/// It is absent where the document has no parameter values, or where the gap before is 0.
///
/// # Errors  a file of the case cannot be read.
pub fn closed(folder: &Path, case: &str, of: &DiagnosisAnswer) -> Result<Option<f64>, String> {
    let path = |part: &str| folder.join(part).join(case).to_string_lossy().into_owned();
    let config = format!("{}/machine.toml", path(CASES));
    let loaded = load(&Sources { config, measurements: path(QUIET), set: of.overrides.clone(), without: of.without.clone() })?;
    let noisy = read_set(&path(CASES)).map_err(to_message)?;
    let made = |quiet: &MotionRecord| -> Result<MotionSignal, String> {
        // With an exact encoder a settling axis creeps for long: the standstills are those of the noisy record.
        let motion = |record: &MotionRecord| MotionSignal::new(record, Preprocessing::default_for(record.step_s)).map_err(to_message);
        let same = noisy.motions.iter().find(|record| record.name == quiet.name);
        let same = same.ok_or_else(|| format!("{}: no record is called {}", path(CASES), quiet.name))?;
        motion(quiet)?.with_rests_of(&motion(same)?, quiet).map_err(to_message)
    };
    let made: Result<Vec<MotionSignal>, String> = loaded.set.motions.iter().map(made).collect();
    let (motions, rigid, _) = add_channels(&loaded, made?)?;
    let mut motions: Vec<MotionSignal> = motions.into_iter().map(MotionSignal::without_edges).collect();
    motions.iter_mut().for_each(|motion| motion.set_weights(&of.weights()));
    let described = &loaded.config.machine;
    if let Some(values) = described.values_of(&of.described) {
        mask_backlash_crossings(&mut motions, &rigid, described, &values);
    }
    let gap = |machine: &Machine, values: &BTreeMap<String, f64>| {
        let values = machine.values_of(values)?;
        gap_of(&motions.iter().map(|motion| part(&rigid, machine, &values, motion)).collect::<Vec<MotionPart>>())
    };
    let before = gap(described, &of.described).filter(|before| *before > 0.0);
    let after = described.with_chosen(of.chosen.effects(), &loaded.config.effects).and_then(|machine| gap(&machine, &of.chosen.parameters));
    Ok(before.zip(after).map(|(before, after)| 1.0 - (after / before).powi(2)))
}
