//! A progress bar on stderr, hidden where stderr is no terminal.

use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over an unknown number of generations that shows the best cost, or over a known number of steps.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Begins; hidden when `quiet`, and by itself where stderr is no terminal.
    pub fn begin(quiet: bool, what: &str) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}  {elapsed}  {msg}") {
            bar.set_style(style);
        }
        bar.set_prefix(what.to_string());
        Progress { bar }
    }

    /// Begins a bar over a known number of steps.
    pub fn counted(quiet: bool, what: &str, steps: usize) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(steps as u64) };
        if let Ok(style) = ProgressStyle::with_template("{prefix}  {bar:30} {pos}/{len}  {elapsed}, {eta} left") {
            bar.set_style(style);
        }
        bar.set_prefix(what.to_string());
        Progress { bar }
    }

    /// One step is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// A watcher for the search.
    pub fn watcher(&self) -> Arc<dyn Fn(u64, f64) + Send + Sync> {
        let bar = self.bar.clone();
        Arc::new(move |generation, best| {
            bar.set_message(format!("generation {generation}  best cost {best:.6}"));
            bar.tick();
        })
    }

    /// Shows the time while work goes on that tells no steps.
    pub fn ticking(self) -> Self {
        self.bar.enable_steady_tick(std::time::Duration::from_millis(150));
        self
    }

    /// Names what is done now.
    pub fn now(&self, what: &str) {
        self.bar.set_prefix(what.to_string());
    }

    /// Ends and clears the line.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}
