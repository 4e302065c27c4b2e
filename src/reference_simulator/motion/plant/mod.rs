//! The mechanical axis and its step.

mod axis;
mod chain;
mod friction;
mod gap;
mod outside;
mod wave;

pub use axis::{Axis, Spring, ThermalExpansion};
pub use chain::{Chain, Work};
pub use friction::{Friction, FrictionElements, SHARES};
pub use gap::Contact;
pub use outside::{Lump, UnlistedEffect};
pub use wave::{Wave, wave_sum};
