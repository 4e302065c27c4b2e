//! Long computations: their threads, Ctrl-C, and the journal of finished work from which the same command resumes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::arguments::OutputArguments;
use crate::outcome::{Outcome, shown, to_message};
use crate::progress::WorkProgress;
use crate::sources::{Loaded, inputs};
use crate::terminal;
use optimizer::{Control, Journal};
use report::OutputFolder;
use study::Study;

/// Identifies this build of the program by the length and modification time of its file; `None` if they cannot be read.
pub fn build_id() -> Option<(u64, std::time::SystemTime)> {
    std::env::current_exe().and_then(std::fs::metadata).and_then(|m| Ok((m.len(), m.modified()?))).ok()
}

/// Builds the control of a long computation: progress, Ctrl-C, and the journal of work that an earlier run of the same command has finished.
///
/// The journal lies in the result folder. Without a folder there is no journal.
///
/// # Errors  the journal cannot be read.
pub fn control(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    progress: &WorkProgress,
    loaded: &Loaded,
) -> Result<Control, String> {
    let journal = folder
        .map(|folder| {
            let path = folder.path().join(JOURNAL);
            // Another build may compute other numbers. Arguments may contain blanks, so U+001F separates them.
            let mut work = format!("{} {:?} {}", env!("CARGO_PKG_VERSION"), build_id(), result_arguments(std::env::args()).join("\u{1f}"));
            inputs(loaded).iter().for_each(|input| work += &format!(" {}", input.sha256));
            let journal = Journal::open(&path, &work).map_err(|e| format!("{}: cannot be read: {e}; remove it", path.display()))?;
            if journal.taken_over() > 0 && !output.quiet {
                eprintln!("resumes where an earlier run was stopped ({})", path.display());
            }
            Ok::<_, String>(Arc::new(journal))
        })
        .transpose()?;
    Ok(Control::new(stop_flag(), Some(progress.watcher())).with_journal(journal))
}

/// Gives a study the control of a long computation: progress, Ctrl-C, and the journal of work that an earlier run of the same work has finished.
/// `work` holds everything on which the result depends beside the study itself.
///
/// The journal lies in the result folder. Without a folder there is no journal.
///
/// # Errors  the journal cannot be read.
pub fn resumable(
    study: Study,
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    progress: &WorkProgress,
    work: &str,
) -> Result<Study, String> {
    let study = study.with_control(Control::new(stop_flag(), Some(progress.watcher())));
    let Some(folder) = folder else { return Ok(study) };
    let path = folder.path().join(JOURNAL);
    let study = study.resumable(&path, work).map_err(shown)?;
    if study.control().journal().is_some_and(|journal| journal.taken_over() > 0) && !output.quiet {
        eprintln!("resumes where an earlier run was stopped ({})", path.display());
    }
    Ok(study)
}

/// Ends a long computation: removes the journal of a complete run, and keeps that of a stopped one.
pub fn finish(output: &OutputArguments, control: &Control, complete: bool) -> Outcome {
    let fault = control.journal().and_then(|journal| {
        if complete {
            journal.remove();
        }
        journal.fault()
    });
    if let Some(fault) = fault.filter(|_| !output.quiet) {
        terminal::warning(&format!(
            "{fault}: the journal of finished work could not be written; after a stop the same command repeats the work missing from it"
        ));
    } else if !complete && control.journal().is_some() && !output.quiet {
        eprintln!("stopped; the same command resumes from here");
    }
    if complete { Outcome::Done } else { Outcome::Stopped }
}

/// Name of the journal in the result folder. The file exists until the run is complete.
const JOURNAL: &str = "unfinished.jsonl";

/// Returns the command-line arguments on which results depend.
fn result_arguments(arguments: impl Iterator<Item = String>) -> Vec<String> {
    let mut kept = Vec::new();
    let mut arguments = arguments.skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "-q" | "--quiet" | "--json" | "-v" | "--verbose" => {}
            "--out" | "--threads" => drop(arguments.next()),
            other if other.starts_with("--out=") || other.starts_with("--threads=") => {}
            _ => kept.push(argument),
        }
    }
    kept
}

/// Returns a flag that Ctrl-C sets. A second Ctrl-C ends the process at once.
///
/// Only one flag per process works: Ctrl-C keeps setting the first one.
pub fn stop_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let handled = Arc::clone(&flag);
    // Where no handler can be set, Ctrl-C ends the process as usual.
    let _ = ctrlc::set_handler(move || {
        if handled.swap(true, Ordering::Relaxed) {
            // 128 + 2, the usual exit code of a process ended by SIGINT.
            std::process::exit(130);
        }
    });
    flag
}

/// Returns a predicate: whether Ctrl-C has not been pressed yet.
pub fn not_stopped() -> impl Fn() -> bool + Sync {
    let flag = stop_flag();
    move || !flag.load(Ordering::Relaxed)
}

/// Runs a computation on the given number of threads; without one, on all cores or as many as `RAYON_NUM_THREADS` states.
///
/// # Errors  the threads cannot be started.
pub fn on_threads<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, String> {
    match threads {
        None => Ok(work()),
        Some(count) => {
            terminal::THREADS.get_or_init(|| usize::from(count));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(count)).build().map_err(to_message)?;
            Ok(pool.install(work))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_that_do_not_change_the_result_are_dropped() {
        let of = |line: &str| result_arguments(line.split(' ').map(String::from));
        let expected = of("jointid identify --seed 3");
        assert_eq!(expected, ["identify", "--seed", "3"]);
        assert_eq!(of("other/jointid identify -q --threads 2 --seed 3 --out results --json"), expected);
        assert_eq!(of("jointid identify --threads=2 --seed 3 --out=there -v"), expected);
        assert_ne!(of("jointid identify --seed 4"), expected);
    }
}
