//! `jointid peaks`: natural frequencies from FRFs, tracked over the positions.

use std::sync::Arc;

use crate::arguments::{OutputArguments, band};
use crate::message::shown;
use crate::outcome::{CommandResult, Outcome, deliver_with, prepare, print_out, warn};
use crate::progress::WorkProgress;
use report::peaks_table;
use study::{Control, PeaksRequest, peaks, read_set_from};

/// Arguments of `peaks`.
#[derive(Debug, clap::Args)]
pub struct PeaksArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// Accept files outside the measurement set's folder in its manifest
    #[arg(long)]
    pub allow_outside: bool,
    /// Lowest and highest frequency (Hz), comma-separated; all frequencies by default
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Fit only the modes in --band; modes outside it enter as a background linear in frequency
    #[arg(long)]
    pub local: bool,
    /// Highest polynomial order of the stabilisation diagram
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u8).range(8..=120))]
    pub max_order: u8,
    /// Also show spurious modes, which do not vary smoothly over the positions, with the reasons
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &PeaksArguments) -> CommandResult {
    let set = read_set_from(&given.measurements, given.allow_outside).map_err(shown)?;
    let request = PeaksRequest {
        band_hz: band(&given.band, "20,800")?,
        local: given.local,
        max_order: usize::from(given.max_order),
    };
    let progress = WorkProgress::begin(given.output.quiet, "peaks");
    // Nothing is known before the end, so that Ctrl-C ends the command at once.
    let found = peaks(&set, &request, &Control::new(Arc::default(), Some(progress.watcher())));
    progress.end();
    let found = found.map_err(shown)?;
    let document = &found.document;
    warn(&given.output, &document.stamp.warnings);
    let folder = prepare(&given.output, &["peaks.json", "modes.csv"])?;
    let tables = [("modes.csv", found.modes_csv.clone())];
    // A table without modes would be read as a measurement.
    let tables = &tables[..usize::from(!found.modes_csv.is_empty())];
    deliver_with(
        &given.output,
        folder.as_ref(),
        ("peaks.json", tables),
        document,
        &peaks_table(document, given.all),
    )?;
    if !given.output.json && !given.all && document.modes.iter().any(|m| !m.regular) {
        let spurious = document.modes.iter().filter(|m| !m.regular).count();
        let what =
            if spurious == 1 { "1 spurious mode is" } else { &format!("{spurious} spurious modes are") };
        print_out(&format!("{what} not shown; --all shows the reasons\n"))?;
    }
    Ok(Outcome::Done)
}
