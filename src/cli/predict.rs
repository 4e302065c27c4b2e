//! `jointid predict`: natural frequencies, FRFs and static stiffness of an identified machine at any
//! position.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, band, opened};
use crate::completion;
use crate::long_work::{on_threads, stop_flag};
use crate::message::shown;
use crate::outcome::{
    CommandResult, Outcome, deliver_with, named_file, prepare, prepare_file, used, warn, write_announced,
};
use crate::progress::WorkProgress;
use report::{predicted_frfs_csv, prediction_csv, prediction_text};
use study::simulation::Place;
use study::{Control, PredictionRequest, Sources, Study, StudyError};

/// Names of the documents.
const DOCUMENTS: [&str; 3] = ["prediction.json", "prediction.csv", "prediction-frf.csv"];

/// Arguments of `predict`.
#[derive(Debug, clap::Args)]
pub struct PredictArguments {
    /// identification.json of the machine
    #[arg(long, value_name = "FILE")]
    pub result: PathBuf,
    /// Nut positions from the left end of the screw (m), comma-separated
    #[arg(long, value_name = "M", value_delimiter = ',', conflicts_with = "positions")]
    pub nut_m: Vec<f64>,
    /// Positions of the measurement set, comma-separated; all by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::positions())]
    pub positions: Vec<String>,
    /// Also predict the FRF at each position, with a pointwise band
    #[arg(long)]
    pub frf: bool,
    /// Lowest and highest frequency (Hz), comma-separated; those of the fitted data by default
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Machines drawn for the intervals
    #[arg(long, value_name = "N", default_value_t = 199, value_parser = clap::value_parser!(u16).range(39..=9999))]
    pub draws: u16,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Accept files outside the measurement set's folder in its manifest
    #[arg(long)]
    pub allow_outside: bool,
    /// Number of threads, which does not change the result; all cores by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Machine file to write: parameters at their estimates, estimates of tolerances
    #[arg(long, value_name = "FILE")]
    pub machine_out: Option<PathBuf>,
    /// Replace an existing file of that name
    #[arg(long, requires = "machine_out")]
    pub replace: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &PredictArguments) -> CommandResult {
    let sources = Sources { allow_outside: given.allow_outside, ..Sources::default() };
    let (study, identified, file) = Study::open_with_result(&sources, &given.result).map_err(shown)?;
    let places = if given.nut_m.is_empty() {
        given.positions.iter().cloned().map(Place::Position).collect()
    } else {
        given.nut_m.iter().copied().map(Place::Nut).collect()
    };
    let request = PredictionRequest {
        places,
        band_hz: band(&given.band, "5,1000")?,
        frf: given.frf,
        lines_hz: None,
        draws: usize::from(given.draws),
        seed: given.seed,
        file: Some(file),
        ..PredictionRequest::default()
    };
    let existing = named_file(given.replace);
    let out = (given.output.out.as_deref(), &DOCUMENTS[..]);
    let file = given.machine_out.as_deref().map(|path| (path, "--machine-out"));
    let target = file.map(|file| prepare_file(file, existing, out)).transpose()?;
    let progress = WorkProgress::begin(given.output.quiet, "predict");
    let study = opened(Ok(study))?.with_control(Control::new(stop_flag(), Some(progress.watcher())));
    let ran = on_threads(given.threads, || study.predict_with(&identified, &request))?;
    progress.end();
    let document = match ran {
        Err(StudyError::Stopped) => return Ok(Outcome::Stopped),
        ran => ran.map_err(shown)?,
    };
    // Folders are made after all checks: nothing is written for a result that is refused.
    let name = given.result.display().to_string();
    let machine = target.map(|target| Ok((target, study.machine_of_identification(&identified, &name)?)));
    let machine = machine.transpose().map_err(shown)?;
    let folder = prepare(&given.output, &DOCUMENTS)?;
    if let Some(((folder, name), text)) = &machine {
        write_announced(&given.output, folder, &[(name, text)], existing)?;
    }
    warn(&given.output, &document.stamp.warnings);
    let text = used(&study, &given.result) + &prediction_text(&study.machine().title, &document);
    let [_, of_places, of_lines] = DOCUMENTS;
    let tables = [(of_places, Some(prediction_csv(&document))), (of_lines, predicted_frfs_csv(&document))];
    let tables: Vec<(&str, String)> =
        tables.into_iter().filter_map(|(name, text)| Some((name, text?))).collect();
    deliver_with(&given.output, folder.as_ref(), ("prediction.json", &tables), &document, &text)?;
    Ok(if document.stamp.complete { Outcome::Done } else { Outcome::Stopped })
}
