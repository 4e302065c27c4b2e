//! `jointid plan`: ranks choices of measurements by the remaining uncertainty of the parameters.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, RodArguments, Sources, band};
use crate::completion;
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, used, warn};
use crate::words::{Word, one_of};
use report::plan_table;
use study::{PlanRequest, PlannedData, Settings, read_diagnosis};

/// Kinds of data, by name.
const DATA: [Word<PlannedData>; 2] = [
    ("modes", PlannedData::Modes, "Natural frequencies and amplitudes"),
    ("frf", PlannedData::Frf, "Whole FRFs"),
];

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Machine, set and parameter values from this identification.json; --config and --measurements replace
    /// its own
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Kind of data to measure; by default frf where the set has FRFs, else modes
    #[arg(long, value_parser = one_of(&DATA))]
    pub data: Option<PlannedData>,
    /// Numbers of measurements to choose, comma-separated; by default 2,3, or 1 with --measured
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(1..=8))]
    pub choose: Vec<u8>,
    /// Measurements already made, comma-separated: positions, or position:response/excitation
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::positions())]
    pub measured: Vec<String>,
    /// Channels to choose from, response/excitation, comma-separated; that of the set by default
    #[arg(long, value_name = "POINT/POINT", value_delimiter = ',')]
    pub channels: Vec<String>,
    /// Operating states to choose from, comma-separated: as-is, servo-off, mass=KG, level=N
    #[arg(long, value_name = "STATES", value_delimiter = ',')]
    pub states: Vec<String>,
    /// Nut positions (m), comma-separated: rank by the intervals of the natural frequencies predicted there
    #[arg(long, value_name = "M", value_delimiter = ',', allow_negative_numbers = true)]
    pub predict_at: Vec<f64>,
    /// diagnosis.json with an ambiguous verdict: rank by the probability that the measurements settle it
    #[arg(long, value_name = "FILE")]
    pub diagnosis: Option<PathBuf>,
    /// Relative standard deviation of an FRF line
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    pub noise: f64,
    /// Lowest and highest frequency (Hz), comma-separated
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Number of lines of an FRF
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u16).range(2..))]
    pub lines: u16,
    /// Parameters to keep at their values, comma-separated
    #[arg(long, value_name = "PARAMETERS", value_delimiter = ',')]
    pub freeze: Vec<String>,
    #[command(flatten)]
    pub rods: RodArguments,
    /// Number of choices to show of each ranking
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub top: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &PlanArguments) -> CommandResult {
    let (study, identified) = match &given.result {
        Some(path) => {
            let (study, document, input) = given.sources.open_result(path)?;
            (study, Some((document, Some(input))))
        }
        None => (given.sources.open()?, None),
    };
    let study = study.with_settings(Settings {
        rods: given.rods.represent(),
        freeze: given.freeze.clone(),
        ..Settings::default()
    });
    let request = PlanRequest {
        identified,
        data: given.data,
        choose: given.choose.iter().copied().map(usize::from).collect(),
        measured: given.measured.clone(),
        channels: given.channels.clone(),
        states: given.states.clone(),
        predict_at_m: given.predict_at.clone(),
        diagnosis: given
            .diagnosis
            .as_deref()
            .map(read_diagnosis)
            .transpose()
            .map_err(shown)?
            .map(|(found, file)| (found, Some(file))),
        noise: given.noise,
        band_hz: band(&given.band, "5,1000")?,
        lines: usize::from(given.lines),
    };
    let document = study.plan_with(&request).map_err(shown)?;
    let folder = prepare(&given.output, &["plan.json"])?;
    let values = request.identified.as_ref().map(|(identified, _)| &identified.parameters);
    let size = |id: &str| {
        let identified = values.and_then(|rows| rows.get(id)).map(|row| row.value);
        identified
            .or_else(|| study.machine().parameter(id).map(|at| study.machine().parameters[at].start))
            .map_or(1.0, f64::abs)
    };
    let heading = given.result.as_ref().map_or_else(String::new, |path| used(&study, path) + "\n");
    let text = heading + &plan_table(&document, &size, usize::from(given.top));
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "plan.json", &document, &text)
}
