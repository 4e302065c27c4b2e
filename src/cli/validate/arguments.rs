//! What can be said to `validate`.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::outcome::Outcome;

/// `validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArguments {
    /// The identification.json to check
    #[arg(long, value_name = "FILE")]
    pub result: PathBuf,
    /// Folder of the measurement set; that of the identification by default
    #[arg(long, value_name = "DIR")]
    pub measurements: Option<String>,
    /// Positions to check; those held out by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Exit with 1 if a relative frequency error, or for FRFs the gap of a record, is larger
    #[arg(long, value_name = "SHARE")]
    pub fail_above: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

impl ValidateArguments {
    /// Done, or the limit is not met, which is said.
    pub fn judge(&self, what: &str, largest: Option<f64>) -> Outcome {
        let Some((limit, largest)) = self.fail_above.zip(largest).filter(|(limit, largest)| largest > limit) else { return Outcome::Done };
        if !self.output.quiet {
            eprintln!("jointid: the largest {what}, {:.2} %, is above {:.2} %", 100.0 * largest, 100.0 * limit);
        }
        Outcome::LimitNotMet
    }
}
