//! Objectives: the misfit between prediction and measurement.

mod calibration;
mod closed_loop;
mod coarse;
mod error;
mod frf;
mod frf_lines;
mod frf_residuals;
mod mode_residuals;
mod mode_settings;
mod mode_slopes;
mod modes;
mod pairing;
mod record;
mod redrawn;
mod settings;
mod setup;
mod squares;

pub use calibration::Channel;
pub(crate) use closed_loop::loop_parameters;
pub use closed_loop::{COMMAND, Excitation};
pub use error::ObjectiveError;
pub use frf::FrfObjective;
pub use frf_residuals::FrfGap;
pub use mode_residuals::AmplitudeFit;
pub use mode_settings::{ModeSettings, Objective};
pub use modes::{ModeObjective, PositionPrediction};
pub use pairing::{Deviation, MISSING, VISIBLE};
pub use record::{FrfRecord, operating};
pub use settings::FrfSettings;
pub(crate) use setup::free_parameters;
pub use setup::{GAIN_RANGE, point_named};
pub use squares::ModeSquares;
