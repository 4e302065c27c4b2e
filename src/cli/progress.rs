//! A progress bar on stderr with the time that is left, hidden where stderr is no terminal.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use optimizer::{Progressed, Watcher};

const STEPS: &str = "{prefix}  {bar:24} {pos}/{len}  {elapsed}, {eta} left";
const SEARCHES: &str = "{prefix}  {bar:24} {elapsed}, at most {eta} left  {msg}";

/// A bar over the searches and steps of a command, or over a known number of steps of its own.
pub struct WorkProgress {
    bar: ProgressBar,
    at: Arc<Mutex<BarState>>,
}

/// Where the work stands.
struct BarState {
    name: String,
    searches: u64,
    /// Generations done of each search.
    done: HashMap<usize, u64>,
    best: f64,
}

impl WorkProgress {
    /// Begins with so many searches, one after another; hidden when `quiet`, and by itself where stderr is no terminal.
    pub fn searches(quiet: bool, name: &str, searches: usize) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        style(&bar, "{spinner} {prefix}  {elapsed}");
        // Also where nothing is heard for long, the time that has passed is seen to grow.
        bar.enable_steady_tick(Duration::from_millis(200));
        WorkProgress::of(bar, name, searches)
    }

    /// Begins with searches of unknown number.
    pub fn begin(quiet: bool, name: &str) -> Self {
        WorkProgress::searches(quiet, name, 1)
    }

    /// Begins a bar over a known number of steps.
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

    /// One step is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// A watcher for stages, searches and counted steps. A search that converges early brings the end nearer.
    pub fn watcher(&self) -> Watcher {
        let (bar, at) = (self.bar.clone(), Arc::clone(&self.at));
        Arc::new(move |progressed| {
            let Ok(mut at) = at.lock() else { return };
            match progressed {
                Progressed::Stage(stage) => {
                    style(&bar, "{spinner} {prefix}  {elapsed}");
                    bar.set_prefix(format!("{}: {stage}", at.name));
                    bar.tick();
                }
                Progressed::Generation { search, done, most, best } => {
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
                Progressed::Step { what, done, of } => {
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

    /// Names what is done now.
    pub fn now(&self, what: &str) {
        if let Ok(mut at) = self.at.lock() {
            at.name = what.into();
            // Other data, other costs.
            at.best = f64::INFINITY;
        }
        self.bar.set_prefix(what.to_string());
    }

    /// Ends and clears the line.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}

fn style(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
}
