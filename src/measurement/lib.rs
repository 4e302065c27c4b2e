//! Measurement sets: FRFs, modes and motion records of a machine at named positions.

mod arrays;
mod embedded;
mod error;
mod folder;
mod frf;
mod frf_entry;
mod friction;
pub mod import;
mod level;
mod manifest;
pub mod modal;
mod mode_order;
mod modes;
mod motion;
mod noise_estimate;
mod passivity;
mod position;
mod quantity;
mod reference;
mod sensing;
mod set;
mod source;
mod split;
mod table;
mod template;

pub use arrays::{FrfArrays, MotionArrays, SetArrays};
pub use embedded::BENCH;
pub use error::MeasurementError;
pub use frf::{Condition, Frf, FrfLine, FrfNoise, NoiseSource};
pub use friction::{FrictionRun, FrictionTable, FrictionUnit, read_friction};
pub use level::level_warning;
pub use manifest::manifest_schema;
pub use mode_order::{MisplacedMode, misplaced_modes, with_fitting_orders};
pub use modes::{ModeObservation, ModeTable};
pub use motion::{DriveEffort, MotionRecord, read_motion};
pub use passivity::Activity;
pub use position::Position;
pub use quantity::Quantity;
pub use reference::{Reference, read_reference};
pub use set::{
    ChannelTolerance, Gain, MeasurementSet, Published, PublishedRow, SetWithoutNoise, read_set,
    read_set_from, read_set_with,
};
pub use source::SourceFile;
pub use split::{DataPart, FitSet, Fitted, HeldOut, HoldOutSet};
pub use template::{MOTION_SET_TEMPLATE, SET_TEMPLATE};
