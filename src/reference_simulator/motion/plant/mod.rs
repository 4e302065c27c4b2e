//! The mechanical axis and its step.

mod axis;
mod chain;
mod friction;
mod gap;
mod outside;
mod wave;

pub use axis::{Axis, Growth, Spring};
pub use chain::{Chain, Work};
pub use friction::{Film, Friction, SHARES};
pub use gap::Contact;
pub use outside::{Lump, Outside};
pub use wave::{Wave, along};
