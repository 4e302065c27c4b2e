//! Share of the gap that the chosen model of a motion diagnosis closes on the held-out records without noise.

use std::collections::BTreeMap;
use std::path::Path;

use crate::withheld::{CASES, DiagnosisAnswer, QUIET};
use diagnosis::motion::{MotionPart, gap_of, part};
use dynamics::inverse_dynamics::{MotionSignal, mask_backlash_crossings};
use machine::Machine;
use measurement::{MotionRecord, read_set};
use study::{Sources, Study, StudyError, StudyResult};

/// Computes the closed share 1 − after²/before² of the squared gap, with the channel weights of the
/// diagnosis.
///
/// It is absent where the document has no parameter values, or where the gap before is 0.
///
/// # Errors  a file of the case cannot be read.
pub fn closed_share(folder: &Path, case: &str, of: &DiagnosisAnswer) -> StudyResult<Option<f64>> {
    let path = |part: &str| folder.join(part).join(case).to_string_lossy().into_owned();
    let study = Study::open(&Sources {
        config: Some(format!("{}/machine.toml", path(CASES))),
        measurements: Some(path(QUIET)),
        overrides: of.overrides.clone(),
        without: of.without.clone(),
        ..Sources::default()
    })?;
    let noisy = read_set(&path(CASES))?;
    let made = |quiet: &MotionRecord| -> StudyResult<MotionSignal> {
        // With an exact encoder a settling axis creeps for long: the standstills are those of the noisy
        // record.
        let same = noisy.motions.iter().find(|record| record.name == quiet.name);
        let same = same
            .ok_or_else(|| StudyError::input(path(CASES), format!("no record is called {}", quiet.name)))?;
        let same = MotionSignal::of(same)?;
        Ok(MotionSignal::new(quiet, same.preprocessing)?.with_rests_of(&same, quiet)?)
    };
    let made: StudyResult<Vec<MotionSignal>> = study.measurements().motions.iter().map(made).collect();
    let (motions, rigid, _) = study.add_channels(made?)?;
    let mut motions: Vec<MotionSignal> = motions.into_iter().map(MotionSignal::without_edges).collect();
    motions.iter_mut().for_each(|motion| motion.set_weights(&of.weights()));
    let described = study.machine();
    if let Some(values) = described.values_of(&of.described) {
        mask_backlash_crossings(&mut motions, &rigid, described, &values);
    }
    let gap = |machine: &Machine, values: &BTreeMap<String, f64>| {
        let values = machine.values_of(values)?;
        gap_of(
            &motions.iter().map(|motion| part(&rigid, machine, &values, motion)).collect::<Vec<MotionPart>>(),
        )
    };
    let before = gap(described, &of.described).filter(|before| *before > 0.0);
    let after = described
        .with_chosen(of.chosen.effects(), &study.candidates(&of.chosen.parameters))
        .and_then(|machine| gap(&machine, &of.chosen.parameters));
    Ok(before.zip(after).map(|(before, after)| 1.0 - (after / before).powi(2)))
}
