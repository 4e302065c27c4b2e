//! What goes between long work and whoever waits for it: progress, a flag to stop, and what is kept of what is finished.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::journal::Journal;

/// How far long work has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progressed<'w> {
    /// A stage of it begins.
    Stage(&'w str),
    /// A search.
    Generation {
        /// Which search; several may go on at once.
        search: usize,
        /// Generations of it that are done; all there can be once it has ended.
        done: u64,
        /// Most there will be; it may converge before.
        most: u64,
        /// Best cost so far.
        best: f64,
    },
    /// Steps of known number.
    Step {
        /// What they are.
        what: &'w str,
        /// Steps that are done.
        done: usize,
        /// Steps in all.
        of: usize,
    },
}

/// Is told how far the work has come.
pub type Watcher = Arc<dyn Fn(Progressed<'_>) + Send + Sync>;

/// Told of the progress, asked whether to stop, and asked for what an earlier run has finished.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    watcher: Option<Watcher>,
    journal: Option<Arc<Journal>>,
    part: String,
}

impl Control {
    /// Stops when `stop` is set; `watcher` is told the progress.
    pub fn new(stop: Arc<AtomicBool>, watcher: Option<Watcher>) -> Self {
        Control { stop, watcher, journal: None, part: String::new() }
    }

    /// The same that keeps what is finished, and goes on from what an earlier run has kept.
    #[must_use]
    pub fn keeping(self, journal: Option<Arc<Journal>>) -> Self {
        Control { journal, ..self }
    }

    /// Where what is finished is kept.
    pub fn journal(&self) -> Option<&Journal> {
        self.journal.as_deref()
    }

    /// A stage begins.
    pub fn begin(&self, stage: &str) {
        self.report(Progressed::Stage(stage));
    }

    /// Counts steps of work that is done in parallel: the function given back is called after each.
    pub fn steps<'c>(&'c self, what: &'c str, of: usize) -> impl Fn() + Sync + 'c {
        let done = AtomicUsize::new(0);
        self.report(Progressed::Step { what, done: 0, of });
        move || self.report(Progressed::Step { what, done: done.fetch_add(1, Ordering::Relaxed) + 1, of })
    }

    pub(super) fn report(&self, progressed: Progressed<'_>) {
        if let Some(watcher) = &self.watcher {
            watcher(progressed);
        }
    }

    /// The same for a part of the work: pieces of one part have nothing to do with those of another.
    #[must_use]
    pub fn within(&self, part: &str) -> Self {
        Control { part: format!("{}{part}/", self.part), ..self.clone() }
    }

    /// A piece of work: as an earlier run has kept it, or done now and kept unless it was stopped. Its name tells it from all other pieces of the
    /// part, so it holds whatever differs between them.
    pub fn kept<T: Serialize + DeserializeOwned>(&self, piece: &str, work: impl FnOnce() -> T) -> T {
        let done = self.kept_or_failed(piece, || Ok::<T, std::convert::Infallible>(work()));
        match done {
            Ok(found) => found,
        }
    }

    /// As [`Control::kept`], for work that can fail; an error is not kept.
    ///
    /// # Errors  that of the work.
    pub fn kept_or_failed<T: Serialize + DeserializeOwned, E>(&self, piece: &str, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
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

    /// The last state that an earlier run has kept of a piece it has not finished.
    pub(super) fn last_state<T: DeserializeOwned>(&self, piece: &str) -> Option<T> {
        self.journal.as_ref()?.read(&format!("{}{piece}", self.part))
    }

    /// Keeps the state of a piece of work now and then: the function given back is called whenever there is one.
    pub(super) fn states<T: Serialize>(&self, piece: &str) -> impl FnMut(&T) + use<T> {
        let (journal, name) = (self.journal.clone(), format!("{}{piece}", self.part));
        let mut last = Instant::now();
        move |state| {
            if let Some(journal) = journal.as_ref().filter(|_| last.elapsed() >= BETWEEN_STATES) {
                journal.write(&name, state);
                last = Instant::now();
            }
        }
    }

    /// The flag that stops it.
    pub fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    /// Whether it was asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Time between two states of a search that are kept: what a kill costs at most.
const BETWEEN_STATES: Duration = Duration::from_secs(1);
