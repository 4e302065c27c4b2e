//! `jointid diagnose`: the effect that the model lacks, where, and what it closes.

use std::path::{Path, PathBuf};

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};
use crate::completion;
use crate::long_work::{finish, on_threads, resumable};
use crate::message::{shown, to_message};
use crate::outcome::{
    CommandResult, Outcome, deliver, named_file, prepare, prepare_file, print_out, warn, write_announced,
};
use crate::progress::WorkProgress;
use crate::search::settings;
use crate::terminal;
use crate::words::{Word, one_of};
use report::diagnosis::DiagnosisDocument;
use report::record::motion_diagnosis_text;
use report::{EARLIER, OutputFolder, identification_text, to_json};
use report::{diagnosis_text, why_text};
use study::{Ablation, DiagnosisRequest, NullCache, Study};

/// Identification of the machine with the named effect; that before keeps its name.
const APPLIED: &str = "identification-applied.json";

/// Parts of the method that can be disabled, by name.
const PARTS: [Word<Ablation>; 4] = [
    ("chi-square", Ablation::ChiSquare, "Thresholds from χ² tables instead of null simulations"),
    (
        "frozen-nominal",
        Ablation::FrozenNominal,
        "Candidates fitted with all other parameters held at the nominal fit",
    ),
    ("no-nuisances", Ablation::NoNuisances, "No tolerances fitted as nuisance parameters"),
    ("in-sample", Ablation::InSample, "Candidates ranked by the fitted positions, without cross-validation"),
];

/// `diagnose`.
#[derive(Debug, clap::Args)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    /// Candidate effects, comma-separated; by default all that apply
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', add = completion::effects())]
    pub effects: Vec<String>,
    /// Effects to leave out of the candidates, comma-separated
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', add = completion::effects())]
    pub exclude: Vec<String>,
    /// Null simulations whose fits are made in full, beside 2000 linear ones; 25 times as many for motion
    /// records
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(20..=2000))]
    pub nulls: u16,
    /// Folder for cached null simulations; the platform's cache by default
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Neither read nor write cached null simulations
    #[arg(long)]
    pub no_cache: bool,
    /// Parts of the method to disable, comma-separated
    #[arg(long, value_name = "PARTS", value_delimiter = ',', value_parser = one_of(&PARTS))]
    pub ablate: Vec<Ablation>,
    /// Machine file to write where the verdict names one effect: the machine with it, which is then
    /// identified
    #[arg(long, value_name = "FILE")]
    pub apply: Option<PathBuf>,
    /// File to write everything on which the verdict rests to
    #[arg(long, value_name = "FILE")]
    pub facts: Option<PathBuf>,
    /// Print the rules of the verdict, and which of them held
    #[arg(long)]
    pub why: bool,
    /// Replace existing files of these names
    #[arg(long)]
    pub replace: bool,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &DiagnoseArguments) -> CommandResult {
    let study = given.sources.open()?.with_settings(settings(&given.search)?);
    let study = given.split.applied(study)?;
    let request = DiagnosisRequest {
        effects: given.effects.clone(),
        exclude: given.exclude.clone(),
        nulls: usize::from(given.nulls),
        cache: match (given.no_cache, &given.cache) {
            (true, _) => NullCache::None,
            (false, Some(folder)) => NullCache::Folder(folder.clone()),
            (false, None) => NullCache::Platform,
        },
        ablated: given.ablate.clone(),
        all_facts: given.facts.is_some(),
    };
    // Before the folder of the outputs exists.
    for (key, ids) in [("effects", &request.effects), ("exclude", &request.exclude)] {
        study.check_effects(key, ids).map_err(shown)?;
    }
    let existing = named_file(given.replace);
    let documents = ["diagnosis.json", APPLIED];
    let out = (given.output.out.as_deref(), &documents[..]);
    let prepared = |path: Option<&Path>, argument| {
        path.map(|path| prepare_file((path, argument), existing, out)).transpose()
    };
    let target = prepared(given.apply.as_deref(), "--apply")?;
    let facts_file = prepared(given.facts.as_deref(), "--facts")?;
    if given.facts.is_some() && given.facts == given.apply {
        return Err("--facts: names the file of --apply; name another file".into());
    }
    let folder = prepare(&given.output, &documents)?;
    let progress = WorkProgress::begin(given.output.quiet, "diagnose");
    let study =
        resumable(study, &given.output, folder.as_ref(), &progress, &format!("diagnose {request:?}"))?;
    let ran = on_threads(given.search.threads, || study.diagnose_with_facts(&request))?;
    progress.end();
    let (document, facts) = ran.map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    let mut text = format!(
        "{}\n{}",
        study.machine().title,
        if document.motion.is_some() { motion_diagnosis_text(&document) } else { diagnosis_text(&document) }
    );
    if given.why {
        text += &format!("\n{}", why_text(&document));
    }
    deliver(&given.output, folder.as_ref(), "diagnosis.json", &document, &text)?;
    // Those of a run that was stopped would be judged as if nothing else were to be found.
    let complete = facts.filter(|facts| facts.stamp.complete);
    if let Some(((target, name), facts)) = facts_file.zip(complete) {
        let json = to_json(&facts).map_err(to_message)?;
        write_announced(&given.output, &target, &[(&name, &json)], existing)?;
    }
    match (finish(&given.output, study.control(), document.stamp.complete), &given.apply, &target) {
        (Outcome::Done, Some(path), Some(target)) => {
            apply(given, &study, &document, (path, target), folder.as_ref())
        }
        (ended, _, _) => Ok(ended),
    }
}

/// Writes the machine with the effect that the verdict names, and identifies it. The diagnosis is delivered
/// already.
fn apply(
    given: &DiagnoseArguments,
    study: &Study,
    diagnosis: &DiagnosisDocument,
    (path, (target, name)): (&Path, &(OutputFolder, String)),
    folder: Option<&OutputFolder>,
) -> CommandResult {
    let text = match study.machine_of_diagnosis(diagnosis) {
        Ok(text) => text,
        Err(fault) => {
            terminal::warning(&format!("--apply: {fault}"));
            return Ok(Outcome::LimitNotMet);
        }
    };
    write_announced(&given.output, target, &[(name, &text)], named_file(given.replace))?;
    let applied = study.with_machine_file(&path.display().to_string()).map_err(shown)?;
    let progress = WorkProgress::searches(given.output.quiet, "identify", applied.settings().repeats);
    let applied = resumable(applied, &given.output, folder, &progress, "identify")?;
    let ran = on_threads(given.search.threads, || applied.identify())?;
    progress.end();
    let document = match ran {
        Err(error) if error.is_stop() => return Ok(finish(&given.output, applied.control(), false)),
        made => made.map_err(shown)?,
    };
    warn(&given.output, &document.stamp.warnings);
    if let Some(folder) = folder {
        let json = to_json(&document).map_err(to_message)?;
        write_announced(&given.output, folder, &[(APPLIED, &json)], EARLIER)?;
    }
    if !given.output.json {
        let derived: Vec<String> = applied.machine().derived.iter().map(|d| d.name.clone()).collect();
        print_out(&format!("\n{}", identification_text(&applied.machine().title, &document, &derived)))?;
    }
    Ok(finish(&given.output, applied.control(), document.stamp.complete))
}
