//! Long computations: their threads, Ctrl-C, and the journal of finished work from which the same command
//! resumes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use crate::arguments::OutputArguments;
use crate::message::shown;
use crate::outcome::Outcome;
use crate::progress::WorkProgress;
use crate::terminal;
use report::{OutputFolder, release_claims};
use study::{Control, Study};

/// Connects a study with the terminal: progress, Ctrl-C, and the journal of work that an earlier run of the
/// same command has finished.
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
        terminal::say(&format!("resumes where an earlier run was stopped ({})\n", path.display()));
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
        terminal::say("stopped; the same command resumes from here\n");
    }
    if complete { Outcome::Done } else { Outcome::Stopped }
}

/// Name of the journal in the result folder. The file exists until the run is complete.
const JOURNAL: &str = "unfinished.jsonl";

/// Time after Ctrl-C within which the work must stop and deliver what it has found. Ctrl-C ends a command
/// within a second.
const DELIVERY: Duration = Duration::from_millis(850);

/// Flag that Ctrl-C sets.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// Whether work looks at the flag.
static LOOKS: AtomicBool = AtomicBool::new(false);

/// Ends the process without a result.
fn end() -> ! {
    release_claims();
    terminal::say("stopped without a result; nothing is written\n");
    std::process::exit(3);
}

/// Lets a file that grows beyond the limit of the process (`ulimit -f`) fail like one on a full disk, instead of
/// ending the process.
#[cfg(unix)]
fn outlive_file_limit() {
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

#[cfg(not(unix))]
fn outlive_file_limit() {}

/// Ends the work for a signal: at the first one within [`DELIVERY`], if it looks at [`stop_flag`].
fn stop() {
    if STOP.swap(true, Ordering::Relaxed) {
        release_claims();
        // 128 + 2, the usual exit code of a process ended by SIGINT.
        std::process::exit(130);
    }
    if !LOOKS.load(Ordering::Relaxed) {
        end();
    }
    // Without a further thread the second Ctrl-C remains.
    let _ = std::thread::Builder::new().spawn(|| {
        std::thread::sleep(DELIVERY);
        end();
    });
}

/// Lets SIGTERM end the command like Ctrl-C. SIGHUP stays as it is: `nohup` ignores it.
#[cfg(unix)]
fn watch_termination() {
    let Ok(mut signals) = signal_hook::iterator::Signals::new([signal_hook::consts::SIGTERM]) else { return };
    // Without a further thread SIGTERM waits for the end of the work.
    let _ = std::thread::Builder::new().spawn(move || signals.forever().for_each(|_| stop()));
}

#[cfg(not(unix))]
fn watch_termination() {}

/// Lets Ctrl-C and SIGTERM end the command: work that looks at [`stop_flag`] stops and delivers what it has
/// found, within `DELIVERY`; other work ends at once, and so does any at a second one.
pub fn watch_ctrl_c() {
    outlive_file_limit();
    watch_termination();
    // Where no handler can be set, Ctrl-C ends the process as usual.
    let _ = ctrlc::set_handler(stop);
}

/// Returns the flag that Ctrl-C sets, for work that looks at it.
pub fn stop_flag() -> Arc<AtomicBool> {
    LOOKS.store(true, Ordering::Relaxed);
    Arc::clone(&STOP)
}

/// Runs a computation on the given number of threads; without one, on all cores or as many as
/// `RAYON_NUM_THREADS` states.
///
/// # Errors  the threads cannot be started.
pub fn on_threads<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, String> {
    match threads {
        None => Ok(work()),
        Some(1) if rayon::current_num_threads() == 1 => Ok(work()),
        Some(count) => {
            terminal::THREADS.get_or_init(|| usize::from(count));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(count)).build();
            Ok(pool
                .map_err(|e| format!("{count} threads cannot be started ({e}); ask for fewer"))?
                .install(work))
        }
    }
}

/// Largest number of threads, as `--threads` has it.
const MOST_THREADS: usize = 1024;

/// Starts the threads of this process: one per core, or as many as `RAYON_NUM_THREADS` states. Where the
/// system refuses them, all work runs on the main thread.
pub fn start_threads() {
    let requested = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse::<usize>().ok());
    let mut builder = rayon::ThreadPoolBuilder::new();
    if let Some(count) = requested.filter(|count| *count > MOST_THREADS) {
        terminal::warning(&format!(
            "RAYON_NUM_THREADS is {count}; at most {MOST_THREADS} threads are started"
        ));
        builder = builder.num_threads(MOST_THREADS);
    }
    if let Err(error) = builder.build_global() {
        // The pool for all cannot be asked for twice; one of this thread takes its place until the process
        // ends.
        if let Ok(alone) = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
            std::mem::forget(alone);
            terminal::warning(&format!("threads cannot be started ({error}); the work runs on one"));
        }
    }
}
