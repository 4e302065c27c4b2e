//! An independent truth of a servo axis with its electrics: a synchronous motor in d and q, sampled cascaded loops, a ball screw with play,
//! and what the analytical model of such an axis does not know.
//!
//! ```text
//! nominal   numbers of the axis that an engineer would know
//! missing   what only the truth has: growth, lead error, ripple, presliding; each off at size 0
//! motor     currents, torque
//! drive     encoder, loops of position, velocity and current, limits
//! contact   nut on screw, with play
//! friction  elastic elements that slip at a level that falls with speed
//! plant     motor, spring, screw, nut, table; the step and its energy
//! path      commands: a sine by its largest feed, a circle by its turning speed
//! sensor    what scale, encoder and torque channel make of it
//! run       an axis along a command, recorded every millisecond
//! write     records as measurement sets
//! ```
//!
//! The axis is that of Symmetry 11 (2019) 1156, Table 2, with masses, stiffnesses and friction of our own choice, which the
//! paper does not print.

mod contact;
mod drive;
mod friction;
mod missing;
mod motor;
mod nominal;
mod path;
mod plant;
mod run;
mod sensor;
mod write;

pub use friction::Friction;
pub use missing::Missing;
pub use nominal::{Axis, Loops, Nominal};
pub use path::{Circle, Feed};
pub use run::{RECORD_S, run};
pub use sensor::{Record, Sensors};
pub use write::{write_circles, write_sines};

#[cfg(test)]
mod tests;
