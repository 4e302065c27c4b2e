//! `jointid lab withheld`: makes and seals cases, diagnoses each with the public command, and scores the
//! answers.

pub mod arguments;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use self::arguments::{ArmName, TruthName, WithheldArguments};
use crate::blind_check::{Arm, BlindCheck, BlindCheckRequest, CaseOrigin, Program, page};
use crate::withheld::{Seal, WithheldDocument, withheld_text};
use cli::long_work::{on_threads, stop_flag};
use cli::message::{shown, to_message};
use cli::outcome::{CommandResult, Outcome, deliver, prepare, print_out, warn};
use cli::progress::WorkProgress;
use cli::terminal;
use report::to_json;
use study::{Control, StudyResult};

/// Word before the words of the product's command line, which the blind check runs as a process of its own.
pub(super) const PRODUCT: &str = "jointid";

/// Runs the command.
pub fn run(given: &WithheldArguments) -> CommandResult {
    if !given.page.is_empty() {
        print_out(&page(&given.page).map_err(shown)?)?;
        return Ok(Outcome::Done);
    }
    if given.cases_only && given.output.out.is_none() {
        return Err("--cases-only requires a folder for the cases; name one with --out".into());
    }
    let folder = CaseFolder::new(given.output.out.as_deref())?;
    let check = BlindCheck::new(&folder.path, given.request()).map_err(shown)?;
    if given.output.out.is_none() && !given.case.is_empty() {
        return Err("--case requires the folder of the cases; name it with --out".into());
    }
    // Single cases may be diagnosed side by side in one folder.
    let file = check.document_path();
    let kept = if given.case.is_empty() { prepare(&given.output, &[&file.to_string_lossy()])? } else { None };
    let stop = stop_flag();
    let seal = on_threads(given.jobs, || with_progress(given, &stop, |control| check.seal(control)))?
        .map_err(shown)?;
    let Some(seal) = seal else {
        terminal::say(
            "stopped before all cases were made; the same command resumes from there if it has an --out\n",
        );
        return Ok(Outcome::Stopped);
    };
    // Printed before anything is scored; to stderr where stdout is for the document.
    match (given.output.json, given.output.quiet) {
        (false, _) => print_out(&seal.summary_text())?,
        (true, false) => terminal::say(&seal.summary_text()),
        (true, true) => {}
    }
    if given.cases_only {
        if given.output.json {
            print_out(&to_json(&seal).map_err(to_message)?)?;
        }
        return Ok(Outcome::Done);
    }
    let program = program()?;
    if !given.case.is_empty() {
        with_progress(given, &stop, |control| check.diagnose(&program, &seal, control)).map_err(shown)?;
        return Ok(if stop.load(Ordering::Relaxed) { Outcome::Stopped } else { Outcome::Done });
    }
    let document =
        with_progress(given, &stop, |control| scored(&check, &program, &seal, control)).map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, kept.as_ref(), &file.to_string_lossy(), &document, &withheld_text(&document))?;
    Ok(if document.stamp.complete { Outcome::Done } else { Outcome::Stopped })
}

/// Diagnoses the cases, and scores the answers.
fn scored(
    check: &BlindCheck,
    program: &Program,
    seal: &Seal,
    control: &Control,
) -> StudyResult<WithheldDocument> {
    let answers = check.diagnose(program, seal, control)?;
    check.score(&answers, control)
}

/// Returns the product's command, which this program contains: all that is examined is of one build.
fn program() -> Result<Program, String> {
    let file =
        std::env::current_exe().map_err(|e| format!("this program's own file cannot be found: {e}"))?;
    Ok(Program { command: vec![file.clone().into(), PRODUCT.into()], file })
}

/// Does work with a progress bar of its own, so that nothing is printed beside a bar.
fn with_progress<T>(
    given: &WithheldArguments,
    stop: &Arc<AtomicBool>,
    work: impl FnOnce(&Control) -> T,
) -> T {
    let progress = WorkProgress::begin(given.output.quiet, "withheld");
    let done = work(&Control::new(Arc::clone(stop), Some(progress.watcher())));
    progress.end();
    done
}

impl WithheldArguments {
    fn request(&self) -> BlindCheckRequest {
        BlindCheckRequest {
            arm: self.arm.map(|name| match name {
                ArmName::Frf => Arm::Frf,
                ArmName::Motion => Arm::Motion,
            }),
            cases: self.cases,
            seed: self.seed,
            layout: self.layout,
            truth: self.truth.map(|name| match name {
                TruthName::Independent => CaseOrigin::Independent,
                TruthName::Own => CaseOrigin::Own,
            }),
            ablation: self.ablation.split_whitespace().map(str::to_owned).collect(),
            jobs: self.jobs.map(usize::from),
            time_limit_s: self.time_limit_s.into(),
            only: self.case.clone(),
            facts: self.facts,
        }
    }
}

/// The folder of a check. Without --out it is temporary, and removed at the end.
struct CaseFolder {
    path: PathBuf,
    temporary: bool,
}

impl CaseFolder {
    fn new(requested: Option<&Path>) -> Result<Self, String> {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_err(to_message)?;
        let name = format!("jointid-withheld-{}-{}", std::process::id(), now.as_nanos());
        let path = requested.map_or_else(|| std::env::temp_dir().join(name), Path::to_path_buf);
        Ok(Self { path, temporary: requested.is_none() })
    }
}

impl Drop for CaseFolder {
    fn drop(&mut self) {
        if self.temporary {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}
