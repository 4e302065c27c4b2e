//! Operating condition of a simulation, its control, and the warnings of its document.

use crate::arguments::OutputArguments;
use crate::long_work::stop_flag;
use crate::outcome::{Outcome, warn};
use report::document::Stamp;
use study::simulation::{Load, Place};
use study::{Control, Study};

/// Load on the rolling contacts of nut and bearings.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct LoadArguments {
    /// Velocity of the table (m/s); the friction at this velocity loads the contacts
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), upward positive on a vertical axis; its inertia force loads the
    /// contacts
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N) on the table, which loads the contacts
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub force_n: Option<f64>,
}

impl LoadArguments {
    /// Returns the load.
    pub fn load(&self) -> Load {
        Load {
            velocity_m_s: self.velocity_m_s,
            acceleration_m_s2: self.acceleration_m_s2,
            force_n: self.force_n,
        }
    }
}

/// Returns the place of the nut: its distance from the left end of the screw (m), else mid-stroke.
pub fn nut_place(nut_m: Option<f64>) -> Place {
    nut_m.map_or(Place::MidStroke, Place::Nut)
}

/// Lets Ctrl-C stop a simulation, which then delivers its results so far.
pub fn stoppable(study: Study) -> Study {
    study.with_control(Control::new(stop_flag(), None))
}

/// Prints the warnings of a simulation.
pub fn warn_of_result(output: &OutputArguments, stamp: &Stamp) {
    warn(output, &stamp.warnings);
}

/// Returns the outcome of a simulation that may have been stopped.
pub fn outcome(stamp: &Stamp) -> Outcome {
    if stamp.complete { Outcome::Done } else { Outcome::Stopped }
}
