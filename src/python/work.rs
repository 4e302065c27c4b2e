//! Work without the interpreter's lock: progress, Ctrl-C, threads, and processes that were forked.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use study::{Control, Progress, StudyResult, Watcher};

use crate::error::{argument, forked, internal, to_exception};

/// Time between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);
/// Longest wait for work that was asked to stop: Ctrl-C ends a call within half a second.
const STOPPING: Duration = Duration::from_millis(350);

/// State of a work: stage, and steps done of how many, where they are counted.
#[derive(Clone, Default, PartialEq)]
struct WorkState {
    stage: String,
    steps: Option<(u64, u64)>,
}

/// How a work is run: its callback `progress(stage, done, of)`, and its number of threads.
#[derive(FromPyObject)]
pub struct Running {
    #[pyo3(item)]
    progress: Option<Py<PyAny>>,
    #[pyo3(item)]
    threads: Option<usize>,
}

/// Largest number of threads.
const MOST_THREADS: usize = 1024;

/// Process that first used the threads that all work shares; 0 before.
static OWNER: AtomicU32 = AtomicU32::new(0);

/// Refuses to use the shared threads in a process that was forked from one that used them: a fork copies the
/// pool, but not its threads, so that the work would wait for ever.
fn require_threads() -> PyResult<()> {
    let own = std::process::id();
    match OWNER.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed) {
        Err(owner) if owner != own => Err(forked(owner)),
        _ => Ok(()),
    }
}

/// Does a short piece of work without the interpreter's lock.
///
/// # Errors  the error of the work; the process was forked from one that has computed.
pub fn compute<T: Send>(py: Python<'_>, work: impl FnOnce() -> StudyResult<T> + Send) -> PyResult<T> {
    require_threads()?;
    py.detach(work).map_err(|error| to_exception(&error))
}

/// Does a piece of work in a thread of its own, under a control that it is given. The calling thread looks for
/// Ctrl-C, and calls back with the progress.
///
/// # Errors  the error of the work or of the callback; `KeyboardInterrupt`; the process was forked from one
///   that has computed. Work that does not stop in time is left behind, and ends on its own.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    running: &Running,
    work: impl FnOnce(Control) -> StudyResult<T> + Send + 'static,
) -> PyResult<T> {
    let pool = match running.threads {
        None => {
            require_threads()?;
            None
        }
        Some(count) if (1..=MOST_THREADS).contains(&count) => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
            Some(pool.map_err(|e| {
                argument("threads", &format!("{count} cannot be started ({e}); ask for fewer"))
            })?)
        }
        Some(count) => {
            return Err(argument("threads", &format!("is {count}; write a number from 1 to {MOST_THREADS}")));
        }
    };
    let state = Arc::new(Mutex::new(WorkState::default()));
    let control = Control::new(Arc::default(), running.progress.is_some().then(|| watcher(&state)));
    let control = control.with_journal(None);
    let stop = Arc::clone(control.stop());
    let (sender, receiver) = channel();
    let started = std::thread::Builder::new().name("jointid".into()).spawn(move || {
        let done = match pool {
            Some(pool) => pool.install(|| work(control)),
            None => work(control),
        };
        // The receiver is gone where the work was left behind.
        let _ = sender.send(done);
    });
    started.map_err(internal)?;
    let mut seen = WorkState::default();
    let mut interrupted: Option<(PyErr, Instant)> = None;
    let receiver = Mutex::new(receiver);
    loop {
        let received = py.detach(|| {
            receiver
                .lock()
                .map_or(Err(RecvTimeoutError::Disconnected), |receiver| receiver.recv_timeout(LOOK))
        });
        match (received, interrupted.take()) {
            (Ok(_), Some((error, _))) => return Err(error),
            (Ok(done), None) => {
                report(py, running, &state, &mut seen)?;
                return done.map_err(|error| to_exception(&error));
            }
            (Err(RecvTimeoutError::Disconnected), _) => {
                return Err(internal("the work ended without a result; please report it"));
            }
            (Err(RecvTimeoutError::Timeout), Some((error, since))) => {
                if since.elapsed() > STOPPING {
                    return Err(error);
                }
                interrupted = Some((error, since));
            }
            (Err(RecvTimeoutError::Timeout), None) => {
                if let Err(error) = py.check_signals().and_then(|()| report(py, running, &state, &mut seen)) {
                    stop.store(true, Ordering::Relaxed);
                    interrupted = Some((error, Instant::now()));
                }
            }
        }
    }
}

/// Returns a watcher that keeps the last state of a work.
fn watcher(state: &Arc<Mutex<WorkState>>) -> Watcher {
    let state = Arc::clone(state);
    Arc::new(move |progress| {
        let Ok(mut state) = state.lock() else { return };
        match progress {
            Progress::Stage(stage) => *state = WorkState { stage: stage.into(), steps: None },
            // Searches end as soon as they have converged: how far they are is unknown.
            Progress::Generation { .. } => state.steps = None,
            Progress::Step { what, done, of } => {
                *state = WorkState { stage: what.into(), steps: Some((done as u64, of as u64)) }
            }
        }
    })
}

/// Calls back with the state of the work, if it has changed.
fn report(
    py: Python<'_>,
    running: &Running,
    state: &Arc<Mutex<WorkState>>,
    seen: &mut WorkState,
) -> PyResult<()> {
    let Some(callback) = &running.progress else { return Ok(()) };
    let now = state.lock().map_or_else(|_| WorkState::default(), |state| state.clone());
    if now != *seen {
        let (done, of) = now.steps.unzip();
        callback.call1(py, (now.stage.as_str(), done, of))?;
        *seen = now;
    }
    Ok(())
}
