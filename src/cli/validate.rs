//! `jointid validate`: prediction errors of an identified machine.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, opened};
use crate::completion;
use crate::long_work::stop_flag;
use crate::message::shown;
use crate::outcome::{CommandResult, Outcome, deliver, prepare, used, warn};
use crate::terminal;
use report::validation_text;
use study::{Control, Sources, Study, ValidationRequest};

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArguments {
    /// identification.json to check
    #[arg(long, value_name = "FILE")]
    pub result: PathBuf,
    /// Folder of the measurement set; that of the identification by default
    #[arg(long, value_name = "DIR")]
    pub measurements: Option<String>,
    /// Accept files outside the measurement set's folder in its manifest
    #[arg(long)]
    pub allow_outside: bool,
    /// Positions to check, comma-separated; those held out by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::positions())]
    pub positions: Option<Vec<String>>,
    /// Limit of the relative frequency error, or of the gap of FRFs or records; exit with 1 above it
    #[arg(long, value_name = "SHARE")]
    pub fail_above: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &ValidateArguments) -> CommandResult {
    if let Some(limit) = given.fail_above.filter(|l| !(*l > 0.0)) {
        return Err(format!("--fail-above {limit}: write a share above 0, such as 0.03"));
    }
    let sources = Sources {
        measurements: given.measurements.clone(),
        allow_outside: given.allow_outside,
        ..Sources::default()
    };
    let (study, identified, file) = Study::open_with_result(&sources, &given.result).map_err(shown)?;
    let study = opened(Ok(study))?.with_control(Control::new(stop_flag(), None));
    let request = ValidationRequest { positions: given.positions.clone(), file: Some(file) };
    let folder = prepare(&given.output, &["validation.json"])?;
    let document = study.validate_with(&identified, &request).map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    deliver(
        &given.output,
        folder.as_ref(),
        "validation.json",
        &document,
        &(used(&study, &given.result) + &validation_text(&document)),
    )?;
    if !document.stamp.complete {
        return Ok(Outcome::Stopped);
    }
    let has_gaps = document.positions.values().any(|p| p.gap.is_some());
    let figure = match (document.records.is_empty(), has_gaps) {
        (false, _) => "force error",
        (true, true) => "gap",
        (true, false) => "frequency error",
    };
    Ok(judge(given, figure, document.largest_error.or(document.largest_gap)))
}

/// Compares the largest error with the limit, and reports a limit that is not met.
fn judge(given: &ValidateArguments, figure: &str, largest: Option<f64>) -> Outcome {
    let Some((limit, largest)) = given.fail_above.zip(largest).filter(|(limit, largest)| largest > limit)
    else {
        return Outcome::Done;
    };
    if !given.output.quiet {
        terminal::say(&format!(
            "jointid: the largest {figure}, {:.2} %, is above {:.2} %\n",
            100.0 * largest,
            100.0 * limit
        ));
    }
    Outcome::LimitNotMet
}
