//! A progress bar on stderr with the remaining time, hidden where stderr is no terminal.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use study::{Progress, Watcher};

const FIRST_STEP: &str = "{prefix}  {bar:24} {pos}/{len}  {elapsed}";
const STEPS: &str = "{prefix}  {bar:24} {pos}/{len}  {elapsed}, {eta} left";
const SEARCHES: &str = "{prefix}  {bar:24} {elapsed}, at most {eta} left  {msg}";

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
        style(&bar, "{spinner} {prefix}  {elapsed}");
        // Updates the elapsed time between reports.
        if !bar.is_hidden() && rayon::current_num_threads() > 1 {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        bar.set_prefix(name.to_string());
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
                    style(&bar, "{spinner} {prefix}  {elapsed}");
                    bar.set_prefix(format!("{}: {stage}", at.name));
                    bar.tick();
                    // Costs of another stage are not comparable.
                    (at.stage, at.is_searching, at.best) = (Some(stage.to_string()), false, f64::INFINITY);
                }
                Progress::Generation { search, done, most, best } => {
                    if !at.is_searching {
                        style(&bar, SEARCHES);
                        bar.set_prefix(
                            at.stage
                                .as_ref()
                                .map_or_else(|| at.name.clone(), |stage| format!("{}: {stage}", at.name)),
                        );
                        at.is_searching = true;
                    }
                    at.done.insert(search, done);
                    at.best = at.best.min(best);
                    bar.set_length(at.searches.max(at.done.len() as u64) * most);
                    bar.set_position(at.done.values().sum());
                    bar.set_message(format!("best cost {:.4}", at.best));
                }
                Progress::Step { what, done, of } => {
                    if done == 0 {
                        // The remaining time is unknown before the first step is done.
                        style(&bar, FIRST_STEP);
                        bar.set_prefix(format!("{}: {what}", at.name));
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
