//! `jointid simulate motion`: a driven axis on a reference, or on the command of a record.

use crate::arguments::{OutputArguments, Sources};
use crate::message::{shown, to_message};
use crate::operating::{nut_place, outcome, stoppable, warn_of_result};
use crate::outcome::{CommandResult, prepare, print_out, write_announced};
use crate::terminal;
use report::{EARLIER, motion_csv, motion_summary, to_json};
use study::simulation::{MotionRequest, Reference, TravelProfile, motion};

/// Arguments of `simulate motion`.
#[derive(Debug, clap::Args)]
pub struct MotionArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Reference of the axis: s-curve, sine, or a table with the columns time_s and command_m
    #[arg(
        long,
        value_name = "s-curve|sine|FILE",
        required_unless_present = "record",
        conflicts_with = "record"
    )]
    pub reference: Option<String>,
    /// Record of the measurement set to simulate in closed loop and to compare
    #[arg(long, value_name = "NAME")]
    pub record: Option<String>,
    /// S-curve: travel (m)
    #[arg(long, value_name = "M", default_value_t = 0.1, allow_negative_numbers = true)]
    pub travel_m: f64,
    /// S-curve: largest velocity (m/s)
    #[arg(long, value_name = "V", default_value_t = 0.2)]
    pub velocity_m_s: f64,
    /// S-curve: largest acceleration (m/s²)
    #[arg(long, value_name = "A", default_value_t = 2.0)]
    pub acceleration_m_s2: f64,
    /// S-curve: largest jerk (m/s³)
    #[arg(long, value_name = "J", default_value_t = 50.0)]
    pub jerk_m_s3: f64,
    /// S-curve: rest before and after (s)
    #[arg(long, value_name = "S", default_value_t = 0.2)]
    pub rest_s: f64,
    /// S-curve: return to the start
    #[arg(long)]
    pub and_back: bool,
    /// Sine: amplitude (m)
    #[arg(long, value_name = "M", default_value_t = 0.01)]
    pub amplitude_m: f64,
    /// Sine: frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub frequency_hz: f64,
    /// Sine: number of periods
    #[arg(long, value_name = "N", default_value_t = 3.0)]
    pub periods: f64,
    /// Nut position at the start, from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    /// Lumps per rod
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub lumps: u16,
    /// Longest time step (s), an integer fraction of the innermost loop's period
    #[arg(long, value_name = "S")]
    pub step_s: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

impl MotionArguments {
    /// Returns the command of the axis.
    fn command(&self) -> Reference {
        if let Some(name) = &self.record {
            return Reference::Record(name.clone());
        }
        match self.reference.as_deref().unwrap_or_default() {
            "s-curve" => Reference::SCurve {
                travel: TravelProfile {
                    travel_m: self.travel_m,
                    velocity_m_s: self.velocity_m_s,
                    acceleration_m_s2: self.acceleration_m_s2,
                    jerk_m_s3: self.jerk_m_s3,
                    rest_s: self.rest_s,
                },
                and_back: self.and_back,
            },
            "sine" => Reference::Sine {
                amplitude_m: self.amplitude_m,
                frequency_hz: self.frequency_hz,
                periods: self.periods,
            },
            path => Reference::Table(path.into()),
        }
    }
}

/// Runs the command.
pub fn run(given: &MotionArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["motion.json", "motion.csv"])?;
    let study = stoppable(study);
    let request = MotionRequest {
        reference: given.command(),
        place: nut_place(given.nut_m),
        lumps: usize::from(given.lumps),
        step_s: given.step_s,
    };
    let document = motion(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    let (csv, json) = (motion_csv(&document), to_json(&document).map_err(to_message)?);
    if let Some(folder) = &folder {
        write_announced(&given.output, folder, &[("motion.json", &json), ("motion.csv", &csv)], EARLIER)?;
    }
    print_out(if given.output.json { &json } else { &csv })?;
    if !given.output.json && !given.output.quiet {
        terminal::say(&motion_summary(&document));
    }
    Ok(outcome(&document.stamp))
}
