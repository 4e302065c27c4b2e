//! What commands share: sources read, plans made, documents stamped and delivered.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use crate::arguments::{ModelName, ObjectiveName, Output, SearchArguments, Sources};
use crate::progress::Progress;
use crate::talk;
use config::{MachineConfig, read_machine};
use dynamics::model::Rods;
use identification::Plan;
use identification::objective::{FrfSettings, ModeSettings, Objective};
use measurement::{MeasurementSet, read_set};
use optimizer::{Control, Journal, Strategy};
use report::document::{Input, Settings, Stamp};
use report::{OutputFolder, digest, to_json};

/// How a command ended.
pub enum Outcome {
    /// Done.
    Done,
    /// Done, but a limit that was asked for is not met.
    LimitNotMet,
    /// Stopped early; what is known was delivered.
    Stopped,
}

/// What a command gives: an outcome, or the one message that says why it could not run.
pub type CommandResult = Result<Outcome, String>;

/// Any error as its message.
pub fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Machine and measurements.
pub struct Loaded {
    /// Overrides of the configuration.
    pub overrides: Vec<String>,
    /// Effects taken out of it.
    pub without: Vec<String>,
    /// The machine as configured.
    pub config: MachineConfig,
    /// What was measured.
    pub set: MeasurementSet,
}

/// Reads machine and measurements.
pub fn load(sources: &Sources) -> Result<Loaded, String> {
    let config = read_machine(&sources.config, &sources.set, &sources.without).map_err(told)?;
    let set = read_set(&sources.measurements).map_err(told)?;
    Ok(Loaded { config, set, overrides: sources.set.clone(), without: sources.without.clone() })
}

/// As [`load`], for commands that need a machine and at most the positions of its set: the published bench's set stands in for no other machine.
pub fn load_machine(sources: &Sources) -> Result<Loaded, String> {
    let config = read_machine(&sources.config, &sources.set, &sources.without).map_err(told)?;
    let other = sources.measurements == measurement::BENCH && !config.path.contains("tian");
    let set = if other { MeasurementSet::none() } else { read_set(&sources.measurements).map_err(told)? };
    Ok(Loaded { config, set, overrides: sources.set.clone(), without: sources.without.clone() })
}

/// Rods as asked for.
pub fn rods(model: ModelName, lumps: u16) -> Rods {
    match model {
        ModelName::Receptance => Rods::Exact,
        ModelName::Lumped => Rods::Lumped(usize::from(lumps)),
    }
}

/// Objective as asked for.
pub fn objective(name: ObjectiveName) -> Objective {
    match name {
        ObjectiveName::LeastSquares => Objective::LeastSquares,
        ObjectiveName::Eq26 => Objective::Eq26,
        ObjectiveName::Frequencies => Objective::Frequencies,
        ObjectiveName::Frf | ObjectiveName::InverseDynamics | ObjectiveName::OutputError => Objective::LeastSquares,
    }
}

/// Whether whole FRFs are fitted: where it is asked for, or where the set has some and nothing else is asked for.
pub fn fits_frfs(search: &SearchArguments, set: &MeasurementSet) -> bool {
    search.objective.map_or(!set.frfs.is_empty(), |o| o == ObjectiveName::Frf)
}

/// The band that was asked for.
fn band_hz(search: &SearchArguments) -> Result<(f64, f64), String> {
    match search.band[..] {
        [] => Ok(FrfSettings::default().band_hz),
        [from, to] if from >= 0.0 && to > from => Ok((from, to)),
        _ => Err(format!("--band {}: write the lowest and the highest frequency in Hz, such as --band 20,800", listed(&search.band))),
    }
}

fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// The word for an objective.
pub fn objective_word(objective: Objective) -> &'static str {
    match objective {
        Objective::LeastSquares => "least-squares",
        Objective::Eq26 => "eq26",
        Objective::Frequencies => "frequencies",
    }
}

/// The plan that was asked for.
pub fn plan(search: &SearchArguments, set: &MeasurementSet) -> Result<Plan, String> {
    for (key, x) in [("--frequency-model-error", search.frequency_model_error), ("--amplitude-sd", search.amplitude_sd)] {
        if !(1e-6..=1e3).contains(&x) {
            return Err(format!("{key} {x}: write a number above 0, from 1e-6 to 1000"));
        }
    }
    if !(0.0..=1e3).contains(&search.frf_model_error) {
        return Err(format!("--frf-model-error {}: write 0 or a number above it, such as 0.01", search.frf_model_error));
    }
    if (1..50).contains(&search.bootstrap) {
        return Err(format!("--bootstrap {}: too few for 95 % intervals; draw at least 50", search.bootstrap));
    }
    let frf = FrfSettings {
        model_error: search.frf_model_error,
        band_hz: band_hz(search)?,
        rods: rods(search.model, search.lumps),
        ..FrfSettings::default()
    };
    Ok(Plan {
        settings: ModeSettings {
            objective: search.objective.map_or(Objective::LeastSquares, objective),
            frequency_model_error: search.frequency_model_error,
            amplitude_sd: search.amplitude_sd,
            rods: rods(search.model, search.lumps),
        },
        frozen: search.freeze.clone(),
        seed: search.seed,
        repeats: usize::from(search.repeats),
        strategy: Strategy::CurrentToPbest,
        frf: fits_frfs(search, set).then_some(frf),
        near: None,
        profile: true,
        bootstrap: usize::from(search.bootstrap),
    })
}

/// The settings of a run, to be kept with its result.
pub fn settings(sources: &Sources, search: &SearchArguments, plan: &Plan) -> Settings {
    let lumped = search.model == ModelName::Lumped;
    Settings {
        config: sources.config.clone(),
        measurements: sources.measurements.clone(),
        model: if lumped { "lumped" } else { "receptance" }.into(),
        lumps: lumped.then_some(usize::from(search.lumps)),
        objective: plan.frf.map_or_else(|| objective_word(plan.settings.objective), |_| "frf").into(),
        frf_model_error: search.frf_model_error,
        band_hz: plan.frf.map(|f| f.band_hz).filter(|b| *b != FrfSettings::default().band_hz).map(|b| [b.0, b.1.min(f64::MAX)]),
        positions: None,
        hold_out: Vec::new(),
        bootstrap: plan.bootstrap,
        frequency_model_error: search.frequency_model_error,
        amplitude_sd: search.amplitude_sd,
        repeats: usize::from(search.repeats),
        freeze: search.freeze.clone(),
    }
}

/// The files a run rests on.
pub fn inputs(loaded: &Loaded) -> Vec<Input> {
    let config = Input { path: loaded.config.path.clone(), sha256: digest(loaded.config.text.as_bytes()) };
    std::iter::once(config).chain(set_inputs(&loaded.set)).collect()
}

fn set_inputs(set: &MeasurementSet) -> Vec<Input> {
    set.files.iter().map(|f| Input { path: f.path.clone(), sha256: digest(&f.bytes) }).collect()
}

/// The stamp of a document.
pub fn stamp(schema: &str, seed: u64, complete: bool, loaded: &Loaded, warnings: Vec<String>) -> Stamp {
    let alone = set_stamp(schema, &loaded.set, Vec::new());
    Stamp {
        seed,
        complete,
        inputs: inputs(loaded),
        overrides: loaded.overrides.clone(),
        without: loaded.without.clone(),
        warnings: alone.warnings.into_iter().chain(loaded.config.warnings.iter().cloned()).chain(warnings).collect(),
        ..alone
    }
}

/// The stamp of a document that rests on measurements alone.
pub fn set_stamp(schema: &str, set: &MeasurementSet, warnings: Vec<String>) -> Stamp {
    Stamp {
        schema: format!("jointid/{schema}/1"),
        tool_version: env!("CARGO_PKG_VERSION").into(),
        seed: 0,
        complete: true,
        inputs: set_inputs(set),
        overrides: Vec::new(),
        without: Vec::new(),
        warnings: set.warnings.iter().cloned().chain(warnings).collect(),
    }
}

/// The folder results go to, made sure of before the work begins, and this run's alone until its end.
pub fn prepare(output: &Output) -> Result<Option<OutputFolder>, String> {
    output.out.as_deref().map(OutputFolder::claim).transpose()
}

/// Delivers a document: as JSON alone, or as text for a person; and as a file where a folder was named.
pub fn deliver<T: Serialize>(output: &Output, folder: Option<&OutputFolder>, file: &str, document: &T, text: &str) -> Result<(), String> {
    deliver_with(output, folder, (file, &[]), document, text)
}

/// As [`deliver`], with other files `beside` the document: all are written, or none.
pub fn deliver_with<T: Serialize>(
    output: &Output,
    folder: Option<&OutputFolder>,
    (file, beside): (&str, &[(&str, String)]),
    document: &T,
    text: &str,
) -> Result<(), String> {
    let json = to_json(document)?;
    if let Some(folder) = folder {
        let beside = beside.iter().map(|(name, text)| (*name, text.as_str()));
        write_told(output, folder, &std::iter::once((file, json.as_str())).chain(beside).collect::<Vec<_>>())?;
    }
    print_out(if output.json { &json } else { text })?;
    talk::background(output, &json);
    Ok(())
}

/// Writes files, all or none, and says where they are.
pub fn write_told(output: &Output, folder: &OutputFolder, files: &[(&str, &str)]) -> Result<(), String> {
    folder.write_all(files.iter().copied())?;
    if !output.json && !output.quiet {
        files.iter().for_each(|(name, _)| eprintln!("written: {}", folder.file(name).display()));
    }
    Ok(())
}

/// Prints to stdout; a closed pipe is no error.
pub fn print_out(text: &str) -> Result<(), String> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(format!("stdout: cannot be written: {error}")),
        _ => Ok(()),
    }
}

/// Warnings for a person, on stderr.
pub fn warn(output: &Output, warnings: &[String]) {
    if !output.quiet {
        warnings.iter().for_each(|w| talk::warning(w));
    }
}

/// This build of the program: length and time of its file.
pub fn build() -> Option<(u64, std::time::SystemTime)> {
    std::env::current_exe().and_then(std::fs::metadata).and_then(|m| Ok((m.len(), m.modified()?))).ok()
}

/// What long work is told and asked: its progress, Ctrl-C, and what an earlier run of the same command has finished, kept beside the results.
/// Where no folder is named, nothing is kept.
///
/// # Errors  what an earlier run has kept cannot be read.
pub fn control(output: &Output, folder: Option<&OutputFolder>, progress: &Progress, loaded: &Loaded) -> Result<Control, String> {
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
pub fn ended(output: &Output, control: &Control, complete: bool) -> Outcome {
    let fault = control.journal().and_then(|journal| {
        if complete {
            journal.remove();
        }
        journal.fault()
    });
    if let Some(fault) = fault.filter(|_| !output.quiet) {
        talk::warning(&format!("{fault}: what is finished could not be kept; after a stop this run would begin anew"));
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
        if handled.swap(true, std::sync::atomic::Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    flag
}

/// Runs work on the number of threads asked for.
pub fn on_threads<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, String> {
    match threads {
        None => Ok(work()),
        Some(count) => {
            talk::THREADS.get_or_init(|| usize::from(count));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(count)).build().map_err(told)?;
            Ok(pool.install(work))
        }
    }
}

/// Reads a JSON document; it is an input of another, by the digest of the very bytes that were read.
pub fn read_document<T: serde::de::DeserializeOwned>(path: &Path) -> Result<(T, Input), String> {
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => format!("{}: there is no such file; run identify with --out first", path.display()),
        _ if path.is_dir() => format!("{}: is a folder; name the identification.json in it", path.display()),
        _ => format!("{}: {e}", path.display()),
    })?;
    let document = serde_json::from_slice(&bytes);
    let document = document.map_err(|e| format!("{}, line {}: is no result of identify: {e}", path.display(), e.line()))?;
    Ok((document, Input { path: path.display().to_string(), sha256: digest(&bytes) }))
}

/// A result document as an input of another.
pub fn document_input(path: &Path) -> Result<Input, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Input { path: path.display().to_string(), sha256: digest(&bytes) })
}

#[cfg(test)]
mod tests {
    use crate::*;

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
