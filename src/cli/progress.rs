//! A progress bar on stderr with the remaining time, hidden where stderr is no terminal.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use optimizer::{Progress, Watcher};

const STEPS: &str = "{prefix}  {bar:24} {pos}/{len}  {elapsed}, {eta} left";
const SEARCHES: &str = "{prefix}  {bar:24} {elapsed}, at most {eta} left  {msg}";

/// Progress bar over the searches and steps of a command, or over a known number of steps.
pub struct WorkProgress {
    bar: ProgressBar,
    at: Arc<Mutex<BarState>>,
}

/// State of a progress bar.
struct BarState {
    name: String,
    searches: u64,
    /// Generations done of each search.
    done: HashMap<usize, u64>,
    best: f64,
}

impl WorkProgress {
    /// Starts a bar over a number of successive searches. It is hidden when `quiet`, and where stderr is no terminal.
    pub fn searches(quiet: bool, name: &str, searches: usize) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        style(&bar, "{spinner} {prefix}  {elapsed}");
        // Updates the elapsed time between reports.
        bar.enable_steady_tick(Duration::from_millis(200));
        WorkProgress::of(bar, name, searches)
    }

    /// Starts a bar over an unknown number of searches.
    pub fn begin(quiet: bool, name: &str) -> Self {
        WorkProgress::searches(quiet, name, 1)
    }

    /// Starts a bar over a known number of steps.
    pub fn counted(quiet: bool, name: &str, steps: usize) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(steps as u64) };
        style(&bar, STEPS);
        WorkProgress::of(bar, name, 1)
    }

    fn of(bar: ProgressBar, name: &str, searches: usize) -> Self {
        bar.set_prefix(name.to_string());
        WorkProgress {
            bar,
            at: Arc::new(Mutex::new(BarState { name: name.into(), searches: searches as u64, done: HashMap::new(), best: f64::INFINITY })),
        }
    }

    /// Counts one finished step.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Returns a watcher for stages, searches and counted steps. A search that converges early shortens the remaining time.
    pub fn watcher(&self) -> Watcher {
        let (bar, at) = (self.bar.clone(), Arc::clone(&self.at));
        Arc::new(move |progressed| {
            let Ok(mut at) = at.lock() else { return };
            match progressed {
                Progress::Stage(stage) => {
                    style(&bar, "{spinner} {prefix}  {elapsed}");
                    bar.set_prefix(format!("{}: {stage}", at.name));
                    bar.tick();
                }
                Progress::Generation { search, done, most, best } => {
                    if at.done.is_empty() {
                        style(&bar, SEARCHES);
                        bar.set_prefix(at.name.clone());
                    }
                    at.done.insert(search, done);
                    at.best = at.best.min(best);
                    bar.set_length(at.searches.max(at.done.len() as u64) * most);
                    bar.set_position(at.done.values().sum());
                    bar.set_message(format!("best cost {:.4}", at.best));
                }
                Progress::Step { what, done, of } => {
                    if done == 0 {
                        style(&bar, STEPS);
                        bar.set_prefix(format!("{}: {what}", at.name));
                        bar.set_position(0);
                        bar.reset_eta();
                    }
                    bar.set_length(of as u64);
                    bar.set_position(done as u64);
                }
            }
        })
    }

    /// Names the current work.
    pub fn now(&self, what: &str) {
        if let Ok(mut at) = self.at.lock() {
            at.name = what.into();
            // Costs on other data are not comparable.
            at.best = f64::INFINITY;
        }
        self.bar.set_prefix(what.to_string());
    }

    /// Ends the bar and clears its line.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}

fn style(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
}
