//! Cases made in parallel and sealed. What was made before a stop is kept aside and used again.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::super::common::told;
use super::super::progress::Progress;
use super::own::own_case;
use crate::report::{OutputFolder, to_json};
use crate::truth::{Case, Label, Plan, generate_one, labels_json, write_case};
use crate::withheld::{Generator, Seal, SealedCase, folder_digest};

/// Set by Ctrl-C.
pub type Flag = Arc<AtomicBool>;

/// A case that was made, or why it could not be.
type Made = Result<(Label, Vec<SealedCase>), String>;

/// Makes and seals all cases; `None` if stopped.
pub fn make(folder: &Path, generator: &Generator, stop: &Flag, quiet: bool) -> Result<Option<Seal>, String> {
    let aside = folder.join("cases.partial");
    let whose = to_json(generator)?;
    let stated = aside.join("generator.json");
    if fs::read_to_string(&stated).is_ok_and(|text| text != whose) {
        fs::remove_dir_all(&aside).map_err(|e| format!("{}: {e}", aside.display()))?;
    }
    let out = OutputFolder::prepare(&aside)?;
    out.write("generator.json", whose.as_bytes())?;
    let plan = Plan::from_counts(&generator.counts, generator.seed);
    let progress = Progress::counted(quiet, "make cases", generator.cases);
    let made: Vec<Option<Made>> = (0..generator.cases)
        .into_par_iter()
        .map(|index| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let made = one(&out, &aside, generator, &plan, index)?;
            progress.step();
            Ok(Some(made))
        })
        .collect::<Result<_, String>>()?;
    progress.end();
    let Some(made) = made.into_iter().collect::<Option<Vec<Made>>>() else {
        return Ok(None);
    };
    let (mut labels, mut cases, mut not_made) = (Vec::new(), Vec::new(), Vec::new());
    for one in made {
        match one {
            Ok((label, folders)) => {
                labels.push(label);
                cases.extend(folders);
            }
            Err(why) => not_made.push(why),
        }
    }
    let labels = labels_json(&labels).map_err(told)?;
    let seal = Seal::new(generator.clone(), &labels, cases, not_made)?;
    let whole = OutputFolder::prepare(folder)?;
    let moved = fs::rename(aside.join("cases"), folder.join("cases"));
    moved.map_err(|e| format!("{}: cannot be moved to its place: {e}", aside.display()))?;
    whole.write("labels.json", labels.as_bytes())?;
    whole.write("seal.json", to_json(&seal)?.as_bytes())?;
    fs::remove_dir_all(&aside).map_err(|e| format!("{}: {e}", aside.display()))?;
    Ok(Some(seal))
}

/// One case of the plan and its second measurement, if it has one.
fn one(out: &OutputFolder, aside: &Path, generator: &Generator, plan: &Plan, index: usize) -> Result<Made, String> {
    let kept = format!("made/{index}.json");
    if let Some(made) = fs::read_to_string(aside.join(&kept)).ok().and_then(|text| serde_json::from_str(&text).ok()) {
        return Ok(made);
    }
    let made = match case_of(generator, plan, index) {
        Err(refusal) => Err(refusal),
        Ok((case, label)) => {
            let mut folders = Vec::new();
            for case in std::iter::once(&case).chain(case.follow_up.as_deref()) {
                let path = aside.join("cases").join(&case.name);
                write_case(&path, case).map_err(told)?;
                folders.push(SealedCase { name: case.name.clone(), sha256: folder_digest(&path)?, freeze: case.freeze.clone() });
            }
            Ok((label, folders))
        }
    };
    out.write(&kept, to_json(&made)?.as_bytes())?;
    Ok(made)
}

fn case_of(generator: &Generator, plan: &Plan, index: usize) -> Result<(Case, Label), String> {
    match generator.truth.as_str() {
        "own" => own_case(generator.seed, plan, index).map_err(|e| format!("case {index}: {e}")),
        _ => generate_one(generator.seed, plan, index).map_err(told),
    }
}
