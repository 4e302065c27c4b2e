//! Long work: on how many threads, how it is stopped, and what is kept of it until the same command goes on.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::arguments::OutputArguments;
use crate::outcome::{Outcome, to_message};
use crate::progress::WorkProgress;
use crate::sources::{Loaded, inputs};
use crate::terminal;
use optimizer::{Control, Journal};
use report::OutputFolder;

/// This build of the program: length and time of its file.
pub fn build() -> Option<(u64, std::time::SystemTime)> {
    std::env::current_exe().and_then(std::fs::metadata).and_then(|m| Ok((m.len(), m.modified()?))).ok()
}

/// What long work is told and asked: its progress, Ctrl-C, and what an earlier run of the same command has finished, kept beside the results.
/// Where no folder is named, nothing is kept.
///
/// # Errors  what an earlier run has kept cannot be read.
pub fn control(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    progress: &WorkProgress,
    loaded: &Loaded,
) -> Result<Control, String> {
    let journal = folder
        .map(|folder| {
            let path = folder.path().join(UNFINISHED);
            // Another build may find other numbers.
            let mut work = format!("{} {:?} {}", env!("CARGO_PKG_VERSION"), build(), same_work(std::env::args()).join("\u{1f}"));
            inputs(loaded).iter().for_each(|input| work += &format!(" {}", input.sha256));
            let journal = Journal::open(&path, &work).map_err(|e| format!("{}: cannot be read: {e}; remove it", path.display()))?;
            if journal.taken_over() > 0 && !output.quiet {
                eprintln!("goes on where an earlier run was stopped ({})", path.display());
            }
            Ok::<_, String>(Arc::new(journal))
        })
        .transpose()?;
    Ok(Control::new(stop_flag(), Some(progress.watcher())).keeping(journal))
}

/// Ends long work: what was kept of it goes where it is complete, and stays where it was stopped.
pub fn ended(output: &OutputArguments, control: &Control, complete: bool) -> Outcome {
    let fault = control.journal().and_then(|journal| {
        if complete {
            journal.remove();
        }
        journal.fault()
    });
    if let Some(fault) = fault.filter(|_| !output.quiet) {
        terminal::warning(&format!("{fault}: what is finished could not be kept; after a stop this run would begin anew"));
    } else if !complete && control.journal().is_some() && !output.quiet {
        eprintln!("stopped; the same command goes on from here");
    }
    if complete { Outcome::Done } else { Outcome::Stopped }
}

/// What is finished of a run, in the folder of its results, until all of it is.
const UNFINISHED: &str = "unfinished.jsonl";

/// The arguments that results depend on.
fn same_work(arguments: impl Iterator<Item = String>) -> Vec<String> {
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

/// A flag that Ctrl-C sets; a second Ctrl-C ends the process at once.
pub fn stop_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let handled = Arc::clone(&flag);
    // Where no handler can be set, Ctrl-C ends the process as usual.
    let _ = ctrlc::set_handler(move || {
        if handled.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    flag
}

/// Whether Ctrl-C was not pressed yet.
pub fn watch_for_stop() -> impl Fn() -> bool + Sync {
    let flag = stop_flag();
    move || !flag.load(Ordering::Relaxed)
}

/// Runs work on the number of threads asked for.
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
    fn work_is_the_same_whatever_does_not_touch_its_result() {
        let of = |line: &str| same_work(line.split(' ').map(String::from));
        let plain = of("jointid identify --seed 3");
        assert_eq!(plain, ["identify", "--seed", "3"]);
        assert_eq!(of("other/jointid identify -q --threads 2 --seed 3 --out results --json"), plain);
        assert_eq!(of("jointid identify --threads=2 --seed 3 --out=there -v"), plain);
        assert_ne!(of("jointid identify --seed 4"), plain);
    }
}
