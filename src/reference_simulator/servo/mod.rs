//! An independent reference simulator of a servo axis with its electrics: a synchronous motor in d and q,
//! sampled cascaded loops, a ball screw with backlash, and effects that the analytical model of such an axis
//! lacks.
//!
//! ```text
//! nominal   parameters of the axis that an engineer knows
//! missing   effects that only the simulator has: thermal expansion, lead error, ripple, presliding; each absent at size 0
//! motor     currents, torque
//! drive     encoder, loops of position, velocity and current, limits
//! contact   contact of nut and screw, with backlash
//! friction  elastic elements that slip at a level that falls with speed
//! plant     motor, spring, screw, nut, table; the integration step and its energy
//! path      commands: a sine by its largest feed, a circle by its angular speed
//! sensor    scale, encoder and torque channel
//! run       a run of an axis along a command, recorded every millisecond
//! write     records as measurement sets
//! ```
//!
//! The axis is that of Symmetry 11 (2019) 1156, Table 2. The paper does not print masses, stiffnesses and
//! friction; their values are our own choice.

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
