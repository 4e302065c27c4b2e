//! A progress bar on stderr with the remaining time, hidden where stderr is no terminal.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use study::{Progress, Watcher};

// The text at the end is cut where the terminal is too narrow for it.
const BEGUN: &str = "{spinner} {elapsed}  {wide_msg}";
const FIRST_STEP: &str = "{bar:12} {pos}/{len}  {elapsed}  {wide_msg}";
const STEPS: &str = "{bar:12} {pos}/{len}  {elapsed}, {eta} left  {wide_msg}";
const SEARCHES: &str = "{bar:12} {elapsed}, at most {eta} left  {wide_msg}";

/// Progress bar over the searches and steps of a command.
pub struct WorkProgress {
    bar: ProgressBar,
    at: Arc<Mutex<BarState>>,
}

/// State of a progress bar.
struct BarState {
    name: String,
    /// Stage of the work that began last.
    stage: Option<String>,
    is_searching: bool,
    searches: u64,
    /// Generations done of each search.
    done: HashMap<usize, u64>,
    best: f64,
}

impl WorkProgress {
    /// Starts a bar over a number of successive searches. It is hidden when `quiet`, and where stderr is no
    /// terminal.
    pub fn searches(quiet: bool, name: &str, searches: usize) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        style(&bar, BEGUN);
        // Updates the elapsed time between reports.
        if !bar.is_hidden() && rayon::current_num_threads() > 1 {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        bar.set_message(name.to_string());
        let state = BarState {
            name: name.into(),
            stage: None,
            is_searching: false,
            searches: searches as u64,
            done: HashMap::new(),
            best: f64::INFINITY,
        };
        WorkProgress { bar, at: Arc::new(Mutex::new(state)) }
    }

    /// Starts a bar over an unknown number of searches.
    pub fn begin(quiet: bool, name: &str) -> Self {
        WorkProgress::searches(quiet, name, 1)
    }

    /// Returns a watcher for stages, searches and counted steps. A search that converges early shortens the
    /// remaining time.
    pub fn watcher(&self) -> Watcher {
        let (bar, at) = (self.bar.clone(), Arc::clone(&self.at));
        Arc::new(move |progressed| {
            let Ok(mut at) = at.lock() else { return };
            match progressed {
                Progress::Stage(stage) => {
                    style(&bar, BEGUN);
                    bar.set_message(format!("{}: {stage}", at.name));
                    bar.tick();
                    // Costs of another stage are not comparable.
                    (at.stage, at.is_searching, at.best) = (Some(stage.to_string()), false, f64::INFINITY);
                }
                Progress::Generation { search, done, most, best } => {
                    if !at.is_searching {
                        style(&bar, SEARCHES);
                        at.is_searching = true;
                    }
                    at.done.insert(search, done);
                    at.best = at.best.min(best);
                    bar.set_length(at.searches.max(at.done.len() as u64) * most);
                    bar.set_position(at.done.values().sum());
                    let stage = at.stage.as_ref().map_or_else(String::new, |stage| format!(": {stage}"));
                    bar.set_message(format!("{}{stage}, best cost {:.4}", at.name, at.best));
                }
                Progress::Step { what, done, of } => {
                    if done == 0 {
                        // The remaining time is unknown before the first step is done.
                        style(&bar, FIRST_STEP);
                        bar.set_message(format!("{}: {what}", at.name));
                        bar.set_position(0);
                        bar.reset_eta();
                    } else if bar.position() == 0 {
                        style(&bar, STEPS);
                    }
                    bar.set_length(of as u64);
                    bar.set_position(done as u64);
                }
            }
        })
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
