//! Measurement sets: FRFs, modes and motion records of a machine at named positions.

mod arrays;
mod embedded;
mod error;
mod frf;
mod friction;
pub mod import;
mod manifest;
pub mod modal;
mod modes;
mod motion;
mod noise_estimate;
mod position;
mod quantity;
mod reference;
mod set;
mod source;
mod split;
mod table;
mod template;
pub mod universal;

pub use arrays::{FrfArrays, MotionArrays, SetArrays};
pub use embedded::BENCH;
pub use error::MeasurementError;
pub use frf::{Condition, Frf, FrfLine, FrfNoise, NoiseSource};
pub use friction::{FrictionRun, FrictionTable, FrictionUnit, read_friction};
pub use manifest::manifest_schema;
pub use modes::{ModeObservation, ModeTable};
pub use motion::{DriveEffort, MotionRecord, read_motion};
pub use position::Position;
pub use quantity::Quantity;
pub use reference::{Reference, read_reference};
pub use set::{ChannelTolerance, Gain, MeasurementSet, Published, PublishedRow, read_set, read_set_from, read_set_with};
pub use source::SourceFile;
pub use split::{FitSet, HoldOutSet, MotionSplit};
pub use template::SET_TEMPLATE;
