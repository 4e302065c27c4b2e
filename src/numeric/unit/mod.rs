//! Units: conversions of the model's own quantities, and the parser of unit labels for every place where a
//! file states one.

mod convert;
mod dimension;
mod label;
mod symbol;

pub use convert::{frequency_hz, omega_rad_s, travel_per_radian_m};
pub use dimension::{Dimension, Unit};
pub use label::{UnitError, parse, parse_for};
