//! Arguments of `validate`.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::outcome::Outcome;

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArguments {
    /// identification.json to check
    #[arg(long, value_name = "FILE")]
    pub result: PathBuf,
    /// Folder of the measurement set; that of the identification by default
    #[arg(long, value_name = "DIR")]
    pub measurements: Option<String>,
    /// Positions to check, comma-separated; those held out by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Limit of the relative frequency error, or of the gap of FRFs or records; exit with 1 above it
    #[arg(long, value_name = "SHARE")]
    pub fail_above: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

impl ValidateArguments {
    /// Compares the largest error with the limit, and reports a limit that is not met.
    pub fn judge(&self, what: &str, largest: Option<f64>) -> Outcome {
        let Some((limit, largest)) = self.fail_above.zip(largest).filter(|(limit, largest)| largest > limit) else { return Outcome::Done };
        if !self.output.quiet {
            eprintln!("jointid: the largest {what}, {:.2} %, is above {:.2} %", 100.0 * largest, 100.0 * limit);
        }
        Outcome::LimitNotMet
    }
}
