//! How far prediction and measurement are apart.

mod modes;
mod pairing;

pub use modes::{AmplitudeFit, Deviation, ModeObjective, ModeSettings, Objective, ObjectiveError, PositionPrediction};
pub use pairing::{MISSING, Pair, VISIBLE, pair};
