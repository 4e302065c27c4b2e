//! Control of long work: progress reports, a stop flag, and a journal of finished pieces.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::journal::Journal;

/// Progress of long work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'w> {
    /// A stage begins.
    Stage(&'w str),
    /// A generation of a search.
    Generation {
        /// Number of the search; several may run concurrently.
        search: usize,
        /// Generations done; equal to `most` once the search has ended.
        done: u64,
        /// Maximum number of generations; the search may converge earlier.
        most: u64,
        /// Best cost so far.
        best: f64,
    },
    /// A step of a known number of steps.
    Step {
        /// Name of the steps.
        what: &'w str,
        /// Steps done.
        done: usize,
        /// Total number of steps.
        of: usize,
    },
}

/// Callback that receives the progress.
pub type Watcher = Arc<dyn Fn(Progress<'_>) + Send + Sync>;

/// Connects long work with its caller: reports progress, requests a stop, and provides the pieces that an
/// earlier run has finished.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    watcher: Option<Watcher>,
    journal: Option<Arc<Journal>>,
    part: String,
}

impl Control {
    /// Creates a control that stops when `stop` is set and reports progress to `watcher`.
    pub fn new(stop: Arc<AtomicBool>, watcher: Option<Watcher>) -> Self {
        Control { stop, watcher, journal: None, part: String::new() }
    }

    /// Adds a journal, which keeps finished pieces and provides those of an earlier run.
    #[must_use]
    pub fn with_journal(self, journal: Option<Arc<Journal>>) -> Self {
        Control { journal, ..self }
    }

    /// Returns the journal of finished pieces.
    pub fn journal(&self) -> Option<&Journal> {
        self.journal.as_deref()
    }

    /// Reports the start of a stage.
    pub fn begin(&self, stage: &str) {
        self.report(Progress::Stage(stage));
    }

    /// Counts steps of parallel work; the returned function is to be called after each step.
    pub fn steps<'c>(&'c self, what: &'c str, of: usize) -> impl Fn() + Sync + 'c {
        let done = AtomicUsize::new(0);
        self.report(Progress::Step { what, done: 0, of });
        move || self.report(Progress::Step { what, done: done.fetch_add(1, Ordering::Relaxed) + 1, of })
    }

    /// Reports progress to the watcher.
    pub fn report(&self, progressed: Progress<'_>) {
        if let Some(watcher) = &self.watcher {
            watcher(progressed);
        }
    }

    /// Returns a control for a part of the work, in which the names of pieces are separate from those of
    /// other parts.
    #[must_use]
    pub fn within(&self, part: &str) -> Self {
        Control { part: format!("{}{part}/", self.part), ..self.clone() }
    }

    /// Returns a piece of work from the journal, or does the work and keeps the result unless it was stopped.
    /// The name must be unique within the part, so it contains everything in which pieces differ.
    pub fn cached<T: Serialize + DeserializeOwned>(&self, piece: &str, work: impl FnOnce() -> T) -> T {
        let done = self.try_cached(piece, || Ok::<T, std::convert::Infallible>(work()));
        match done {
            Ok(found) => found,
        }
    }

    /// As [`Control::cached`] for work that can fail; an error is not cached.
    ///
    /// # Errors  that of the work.
    pub fn try_cached<T: Serialize + DeserializeOwned, E>(
        &self,
        piece: &str,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some(journal) = &self.journal else { return work() };
        let name = format!("{}{piece}", self.part);
        if let Some(found) = journal.read(&name) {
            return Ok(found);
        }
        let found = work()?;
        if !self.stopped() {
            journal.write(&name, &found);
        }
        Ok(found)
    }

    /// Returns the last state that an earlier run has kept of an unfinished piece.
    pub fn last_state<T: DeserializeOwned>(&self, piece: &str) -> Option<T> {
        self.journal.as_ref()?.read(&format!("{}{piece}", self.part))
    }

    /// Returns a function that keeps the states of a piece of work, at most one per `BETWEEN_STATES`.
    pub fn states<T: Serialize>(&self, piece: &str) -> impl FnMut(&T) + use<T> {
        let (journal, name) = (self.journal.clone(), format!("{}{piece}", self.part));
        let mut last = Instant::now();
        move |state| {
            if let Some(journal) = journal.as_ref().filter(|_| last.elapsed() >= BETWEEN_STATES) {
                journal.write(&name, state);
                last = Instant::now();
            }
        }
    }

    /// Returns the stop flag.
    pub fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    /// Whether a stop was requested.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Least time between two kept states of a search (1 s): the work lost when the process is killed.
const BETWEEN_STATES: Duration = Duration::from_secs(1);
