//! Makes cases in parallel and seals them. Cases made before a stop are stored and reused.

use std::fs;
use std::path::Path;

use file_access::{MOST_DOCUMENT_BYTES, read_text};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::layouts::Layouts;
use super::own_cases::own_case;
use crate::withheld::{CASES, Generator, QUIET, Seal, SealedCase, folder_digest};
use long_work::Control;
use numeric::parallel::OrFirstError;
use reference_simulator::motion::MotionLayout;
use reference_simulator::{
    Counts, Label, Layout, Plan, SimulatorError, generate_one, labels_json, motion, write_case,
};
use report::{Existing, OutputFolder, to_json};
use study::{StudyError, StudyResult};

/// A case, or the reason why it could not be made.
#[derive(Serialize, Deserialize)]
enum Made {
    Case(Box<Label>, Vec<SealedCase>),
    Refused(String),
}

/// Plan of the cases of an arm.
pub enum CasePlan {
    /// Hammer tests.
    Frf(Plan),
    /// Axes in motion.
    Motion(motion::Plan),
}

impl CasePlan {
    /// Builds the plan of an arm, on layouts of that arm.
    pub fn new(arm: &str, layouts: Option<Layouts>, counts: &Counts, seed: u64) -> Self {
        match (arm, layouts) {
            ("motion", None) => Self::Motion(motion::Plan::from_counts(counts, seed)),
            ("motion", Some(layouts)) => {
                Self::Motion(motion::Plan::on_layouts(counts, seed, MotionLayout::named(layouts.name())))
            }
            (_, None) => Self::Frf(Plan::from_counts(counts, seed)),
            (_, Some(layouts)) => Self::Frf(Plan::on_layouts(counts, seed, Layout::named(layouts.name()))),
        }
    }

    /// Returns the number of cases.
    pub fn len(&self) -> usize {
        match self {
            Self::Frf(plan) => plan.slots.len(),
            Self::Motion(plan) => plan.slots.len(),
        }
    }
}

/// Makes and seals all cases; `None` if stopped.
///
/// # Errors  a file cannot be written.
pub fn make_cases(folder: &Path, generator: &Generator, control: &Control) -> StudyResult<Option<Seal>> {
    let aside = folder.join("cases.partial");
    let whose = to_json(generator)?;
    let stated = aside.join("generator.json");
    if let Some(link) =
        [aside.clone(), folder.join(CASES), folder.join(QUIET)].iter().find(|path| path.is_symlink())
    {
        return Err(StudyError::input(link.display(), "is a link; remove it"));
    }
    if read_text(&stated, MOST_DOCUMENT_BYTES).is_ok_and(|text| text != whose) {
        fs::remove_dir_all(&aside).map_err(|e| StudyError::input(aside.display(), e.to_string()))?;
    }
    let out = OutputFolder::prepare(&aside)?;
    out.write("generator.json", whose.as_bytes())?;
    let plan = CasePlan::new(
        &generator.arm,
        generator.layout.as_deref().and_then(Layouts::named),
        &generator.counts,
        generator.seed,
    );
    let step = control.steps("make cases", generator.cases);
    let made: Vec<Option<Made>> = (0..generator.cases)
        .into_par_iter()
        .map(|index| -> StudyResult<Option<Made>> {
            if control.stopped() {
                return Ok(None);
            }
            let made = one(&out, &aside, generator, &plan, index)?;
            step();
            Ok(Some(made))
        })
        .or_first_error()?;
    let Some(made) = made.into_iter().collect::<Option<Vec<Made>>>() else {
        return Ok(None);
    };
    let (mut labels, mut cases, mut not_made) = (Vec::new(), Vec::new(), Vec::new());
    for one in made {
        match one {
            Made::Case(label, folders) => {
                labels.push(*label);
                cases.extend(folders);
            }
            Made::Refused(why) => not_made.push(why),
        }
    }
    let labels = labels_json(&labels).map_err(StudyError::impossible)?;
    let seal = Seal::new(generator.clone(), &labels, cases, not_made)?;
    let sealed = OutputFolder::prepare(folder)?;
    for part in [CASES, QUIET].into_iter().filter(|part| aside.join(part).exists()) {
        let moved = fs::rename(aside.join(part), folder.join(part));
        moved
            .map_err(|e| StudyError::input(aside.display(), format!("cannot be moved to its place: {e}")))?;
    }
    let seal_text = to_json(&seal)?;
    sealed.write_all([("labels.json", &labels), ("seal.json", &seal_text)], Existing::Own)?;
    fs::remove_dir_all(&aside).map_err(|e| StudyError::input(aside.display(), e.to_string()))?;
    Ok(Some(seal))
}

/// Makes one case of the plan, and its second measurement if it has one.
fn one(
    out: &OutputFolder,
    aside: &Path,
    generator: &Generator,
    plan: &CasePlan,
    index: usize,
) -> StudyResult<Made> {
    let kept = format!("made/{index}.json");
    if let Some(made) = read_text(&aside.join(&kept), MOST_DOCUMENT_BYTES)
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
    {
        return Ok(made);
    }
    let mut folders = Vec::new();
    type Write<'w> = &'w dyn Fn(&Path) -> Result<(), SimulatorError>;
    let mut seal =
        |name: &str, freeze: &[String], write: Write<'_>, quiet: Option<Write<'_>>| -> StudyResult<()> {
            let written = |part: &str, write: Write<'_>| {
                let path = aside.join(part).join(name);
                write(&path).map_err(StudyError::impossible)?;
                folder_digest(&path).map_err(StudyError::impossible)
            };
            let sha256 = written(CASES, write)?;
            let quiet_sha256 = quiet.map(|write| written(QUIET, write)).transpose()?;
            folders.push(SealedCase { name: name.into(), sha256, freeze: freeze.to_vec(), quiet_sha256 });
            Ok(())
        };
    let seed = generator.seed;
    let label = match plan {
        CasePlan::Frf(plan) => {
            let made = match generator.truth.as_str() {
                "own" => own_case(seed, plan, index).map_err(|e| format!("case {index}: {e}")),
                _ => generate_one(seed, plan, index).map_err(|e| e.to_string()),
            };
            made.map(|(case, label)| {
                let mut both = std::iter::once(&case).chain(case.follow_up.as_deref());
                both.try_for_each(|case| seal(&case.name, &case.freeze, &|path| write_case(path, case), None))
                    .map(|()| label)
            })
        }
        CasePlan::Motion(plan) => {
            motion::generate_one(seed, plan, index).map_err(|e| e.to_string()).map(|(case, label)| {
                let mut both = std::iter::once(&case).chain(case.follow_up.as_deref());
                both.try_for_each(|case| {
                    // All cases have noise-free records, so that their presence reveals nothing.
                    seal(
                        &case.name,
                        &case.freeze,
                        &|path| motion::write_case(path, case),
                        Some(&|path| motion::write_quiet(path, case)),
                    )
                })
                .map(|()| label)
            })
        }
    };
    let made = match label {
        Ok(label) => Made::Case(Box::new(label?), folders),
        Err(refusal) => Made::Refused(refusal),
    };
    out.write(&kept, to_json(&made)?.as_bytes())?;
    Ok(made)
}
